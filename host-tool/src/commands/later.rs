//! Commands whose time has not come.

use crate::failure::{Failure, Outcome};

/// The answer of a command that is not built yet: exit status 2.
pub fn not_built(command: &str) -> Outcome<u8> {
    Err(Failure::usage(format!(
        "`ironout {command}` is not built yet; built are fit, diagnose, apply, check, export, import, simulate, send, fetch, record and demo (ironout --help)"
    )))
}

/// The answer of a command that makes a page, of a program that was built without it: exit status 2.
#[cfg(not(feature = "page"))]
pub fn without_the_page() -> Outcome<u8> {
    Err(Failure::usage("this program was built without the page: build it with --features page"))
}
