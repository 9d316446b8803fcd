//! What can be asked of `demo`.

use clap::{Args, ValueEnum};

/// `demo`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ironout demo
  ironout demo --hidden temperature    the board finds the cause
  ironout demo --board pico

Needs qemu-system-arm for mps2, without which the same session runs on a
simulated bus, and Node with rp2040js (npm ci in host-tests/pico) for pico.")]
pub struct DemoArgs {
    /// Use the simulated bus even if QEMU is installed
    #[arg(long)]
    pub no_qemu: bool,
    /// Hide an effect that the board has to find, learn and correct
    #[arg(long, value_enum, value_name = "EFFECT")]
    pub hidden: Option<HiddenArg>,
    /// The board whose firmware is emulated
    #[arg(long, value_enum, value_name = "BOARD", default_value = "mps2")]
    pub board: BoardArg,
}

/// What `demo` may hide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum HiddenArg {
    /// An offset proportional to the chip's temperature
    Temperature,
    /// An offset proportional to a current (sent to the board with `cov`)
    Current,
    /// An offset that jumps: something magnetic was attached
    Step,
}

/// The boards that can be emulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BoardArg {
    /// Arm's MPS2 with a Cortex-M4F, in QEMU
    Mps2,
    /// A Raspberry Pi Pico, in rp2040js
    Pico,
}
