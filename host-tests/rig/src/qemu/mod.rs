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

mod console;
mod debugger;
mod emulator;
mod error;
mod firmware;
mod qmp;

pub use console::{Console, Refusal, Reply};
pub use debugger::Debugger;
pub use emulator::{Emulator, MAX_FIELD_UT, Options, PoweredOff};
pub use error::Error;
pub use firmware::{Firmware, Footprint, WORKSPACE};

use std::io::Write;

/// The environment variable that makes a missing QEMU a failure rather than a reason to skip.
pub const REQUIRE: &str = "IRONOUT_REQUIRE_QEMU";

/// The emulator's program.
pub const PROGRAM: &str = "qemu-system-arm";

/// Whether QEMU is there.
pub fn installed() -> bool {
    std::process::Command::new(PROGRAM)
        .arg("--version")
        .stdin(std::process::Stdio::null())
        .output()
        .is_ok_and(|out| out.status.success())
}

/// Whether a test that needs QEMU can run. Without QEMU it says on the standard error that `test` was skipped.
///
/// # Panics
/// Without QEMU, where [`REQUIRE`] is `1`.
pub fn available(test: &str) -> bool {
    if installed() {
        return true;
    }
    assert!(std::env::var(REQUIRE).as_deref() != Ok("1"), "{REQUIRE}=1, but {}", Error::NotInstalled);
    // Not `eprintln!`: the test harness would keep that to itself when the test passes.
    let _ = writeln!(std::io::stderr(), "{test}: skipped: {}", Error::NotInstalled);
    false
}
