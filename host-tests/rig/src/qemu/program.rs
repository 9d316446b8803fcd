//! The emulator's program, and whether it is there.

use super::error::Error;
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
