//! `cargo effects-accuracy`: the part of `cargo accuracy` about hidden effects alone.
//!
//! `--seeds N` runs N logs of each kind and holds them to nothing; `--accept` writes the snapshot and the table of `host-tests/measured.md`.

use ironout_host_tests::accuracy::effect_report::{Effects, SEEDS};
use ironout_host_tests::accuracy::snapshot;
use std::process::ExitCode;

fn main() -> ExitCode {
    let (mut seeds, mut accept) = (SEEDS, false);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--accept" => accept = true,
            "--seeds" => match arguments.next().and_then(|number| number.parse().ok()) {
                Some(number) => seeds = number,
                None => return usage(),
            },
            _ => return usage(),
        }
    }
    if accept && seeds != SEEDS {
        eprintln!("--accept stores the table of {SEEDS} logs: leave --seeds out");
        return ExitCode::from(2);
    }
    let effects = Effects::measure(seeds, |line| println!("{line}"));
    let held = match (accept, seeds == SEEDS) {
        (true, _) => effects.store(),
        (false, true) => snapshot::hold(&Effects::snapshot_path(), &effects.text()),
        (false, false) => Ok(()),
    };
    match held {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}\nif the change is meant: run again with --accept, and look at the difference");
            ExitCode::FAILURE
        }
    }
}

fn usage() -> ExitCode {
    eprintln!("usage: cargo effects-accuracy [--seeds N] [--accept]");
    ExitCode::from(2)
}
