//! `ironout demo` in a program that was built without the board.

use crate::cli::DemoArgs;
use crate::failure::{Failure, Outcome};

/// The answer of a program that was built without the board: exit status 2.
pub fn run(_: &DemoArgs, _: bool) -> Outcome<u8> {
    Err(Failure::usage(
        "this ironout was built without the emulated board: run `cargo ironout demo` in the project's source, or install with \
         --features demo",
    ))
}
