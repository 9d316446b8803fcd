//! `cargo bench`: what everything costs on the host, beside the crate `magcal` on the same counts in the same run, and
//! `diagnose` on a million rows as a program of its own. The last lines are the ratios; times are shown, not asserted.
//!
//! `cargo bench -- WORD` runs what WORD matches, without the last lines. `IRONOUT_ACCEPT=1 cargo bench` writes them into
//! `host-tests/measured.md`.

mod child;
mod core;
mod data;
mod files;
mod flight;
// The one splice of tables into the document; the tool depends on no crate of the tests.
#[path = "../../../host-tests/src/measured.rs"]
mod measured;
mod summary;

fn main() {
    divan::main();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // Cargo's own word; anything else asks for less than all, or for no run at all.
    if arguments != ["--bench"] {
        return;
    }
    match summary::measure() {
        Ok(text) => {
            println!("\n{text}");
            if std::env::var_os("IRONOUT_ACCEPT").is_some()
                && let Err(error) = measured::write(&[("bench", text)])
            {
                eprintln!("{error}");
                std::process::exit(1);
            }
        }
        Err(error) => {
            eprintln!("{error}");
            std::process::exit(1);
        }
    }
}
