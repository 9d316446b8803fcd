//! The emulated board: the firmware, built and run in QEMU, with its console, its sensor's field and its EEPROM in the
//! hands of a test or a demonstration.
//!
//! ```no_run
//! use ironout_rig::qemu::{Emulator, Firmware, Options};
//!
//! # fn main() -> Result<(), ironout_rig::qemu::Error> {
//! let firmware = Firmware::build()?;
//! let mut board = Emulator::start(&firmware, &Options::default())?;
//! board.set_field_ut([110.0, 93.0, 52.0])?;
//! println!("{}", board.console.command("status")?);
//! let mut board = board.power_cut()?.start()?; // the EEPROM keeps what it held
//! println!("{}", board.console.command("cal show")?);
//! # Ok(())
//! # }
//! ```
//!
//! It speaks to QEMU over Unix sockets, so it is there on Unix only. Nothing here needs a library of the system.

mod bridge;
mod console;
mod debugger;
mod emulator;
mod error;
mod firmware;
mod limits;
mod program;
mod qmp;

pub use crate::reply::{Refusal, Reply};
pub use console::Console;
pub use debugger::Debugger;
pub use emulator::{Emulator, Options, PoweredOff, SAMPLE_LIMIT};
pub use error::Error;
pub use firmware::{Firmware, Footprint, WORKSPACE};
pub use limits::MAX_FIELD_UT;
pub use program::{PROGRAM, REQUIRE, Turn, installed, turn};
