//! Node and rp2040js, and whether they are there.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// The environment variable that makes a missing emulator a failure rather than a reason to skip.
pub const REQUIRE: &str = "IRONOUT_REQUIRE_PICO";

/// The interpreter of the emulator.
pub(super) const NODE: &str = "node";

/// The emulator's own files, and the package that it is made with.
pub(super) const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../pico");
const PACKAGE: &str = "node_modules/rp2040js/package.json";

/// What is missing, and how to get it; `None` where nothing is.
pub fn missing() -> Option<String> {
    let node = Command::new(NODE).arg("--version").stdin(Stdio::null()).output();
    if !node.is_ok_and(|out| out.status.success()) {
        return Some(
            "node was not found: install Node 18 or newer (Debian, Ubuntu: apt-get install nodejs npm)"
                .into(),
        );
    }
    let package = Path::new(FOLDER).join(PACKAGE);
    (!package.is_file()).then(|| "rp2040js is not installed: run `npm ci` in host-tests/pico".into())
}

/// Whether a test that needs the emulated Pico can run. Without it, it says on the standard error that `test` was skipped.
///
/// # Panics
/// Without it, where [`REQUIRE`] is `1`.
pub fn available(test: &str) -> bool {
    let Some(missing) = missing() else { return true };
    assert!(std::env::var(REQUIRE).as_deref() != Ok("1"), "{REQUIRE}=1, but {missing}");
    // Not `eprintln!`: the test harness would keep that to itself when the test passes.
    let _ = writeln!(std::io::stderr(), "{test}: skipped: {missing}");
    false
}
