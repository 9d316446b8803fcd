//! What `cargo ironout` does for the commands that need the page: that program is built without it, because the page is half of the
//! building time, and cargo builds the rest when one of these commands is used.

use crate::failure::{Failure, Outcome};
use std::env;
use std::process::Command;

/// Runs this command in the program with the page; its exit status. Outside of cargo, how to build such a program.
pub fn run() -> Outcome<u8> {
    let folder = env!("CARGO_MANIFEST_DIR");
    // Set by `cargo run`, and by no shell.
    let Some(cargo) =
        env::var_os("CARGO").filter(|_| env::var_os("CARGO_MANIFEST_DIR").is_some_and(|run| run == folder))
    else {
        return Err(Failure::usage(
            "this program was built without the page, which `report`, `web` and `live` need. Fix, in the folder of its \
             sources: cargo \
             install --path host-tool --locked --profile host --features page",
        ));
    };
    eprintln!("this command needs the page. Building it for the first time takes some minutes …");
    let profile = if cfg!(debug_assertions) { "dev" } else { "host" };
    let mut command = Command::new(cargo);
    command.args(["run", "--locked", "--profile", profile, "--manifest-path"]);
    command.arg(format!("{folder}/Cargo.toml"));
    command.args(["--features", "demo,page", "--bin", "ironout", "--"]).args(env::args_os().skip(1));
    let status = command.status().map_err(|error| Failure::usage(format!("cargo did not start: {error}")))?;
    // Of the program: 0, 1 or 2. Of cargo, where it could not build: 101.
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).filter(|code| *code <= 2).unwrap_or(2))
}
