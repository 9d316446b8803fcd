//! The emulator's program, and whether it is there.

use super::error::Error;
use std::fs::File;
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

/// A test's turn at the emulator: while one is held, no other test has one, in any process. Two emulated boards on a small
/// machine slow each other down until their clocks and the host's fall apart.
#[derive(Debug)]
pub struct Turn {
    /// Locked while it is open; `None` where the system has no locks, and tests only lose their patience.
    _lock: Option<File>,
}

impl Turn {
    fn wait() -> Self {
        let path = std::env::temp_dir().join("ironout-emulated-board.lock");
        let lock = File::options().create(true).append(true).open(path).ok();
        Self { _lock: lock.filter(|file| file.lock().is_ok()) }
    }
}

/// The turn of a test that needs QEMU: waits until no other test has one. Without QEMU it says on the standard error that
/// `test` was skipped.
///
/// # Panics
/// Without QEMU, where [`REQUIRE`] is `1`.
pub fn turn(test: &str) -> Option<Turn> {
    if installed() {
        return Some(Turn::wait());
    }
    assert!(std::env::var(REQUIRE).as_deref() != Ok("1"), "{REQUIRE}=1, but {}", Error::NotInstalled);
    // Not `eprintln!`: the test harness would keep that to itself when the test passes.
    let _ = writeln!(std::io::stderr(), "{test}: skipped: {}", Error::NotInstalled);
    None
}
