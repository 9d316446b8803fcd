//! The command `ironout`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ironout_cli::run(std::env::args_os().collect())
}
