//! `cargo additions-accuracy`: the part of `cargo accuracy` about irrelevant effects alone.
//!
//! `--seeds N` runs N logs of each kind and holds them to no snapshot; `--each` says every addition on standard error;
//! `--accept` writes the snapshot.

use ironout_host_tests::accuracy::irrelevant::{Case, Trial};
use ironout_host_tests::accuracy::irrelevant_table::{Irrelevant, SEEDS};
use ironout_host_tests::accuracy::snapshot;
use std::process::ExitCode;

fn main() -> ExitCode {
    let (mut seeds, mut accept, mut each) = (SEEDS, false, false);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--accept" => accept = true,
            "--each" => each = true,
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
    let table = Irrelevant::measure(seeds, |case, seed, trial| {
        if each {
            say(case, seed, trial);
        }
    });
    print!("{}", table.text());
    let held = match (accept, seeds == SEEDS) {
        (true, _) => table.store(),
        (false, true) => snapshot::hold(&Irrelevant::snapshot_path(), &table.text()),
        (false, false) => Ok(()),
    };
    match held {
        Ok(()) if table.holds() => ExitCode::SUCCESS,
        Ok(()) => {
            eprintln!("more is accepted than may be");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}\nif the change is meant: run again with --accept, and look at the difference");
            ExitCode::FAILURE
        }
    }
}

fn say(case: &Case, seed: u64, trial: &Trial) {
    let (plain, with) = (&trial.plain, &trial.with);
    eprintln!(
        "{} {:?} seed {seed} + {} ({:?}): accepted {} -> {}, predicted {:.4} -> {:.4}, held out {:.3} -> {:.3}, unseen {:.3} -> \
         {:.3} µT, vector off by {:.4} -> {:.4} of F",
        case.hidden,
        case.motion,
        trial.addition,
        trial.kind,
        plain.accepted,
        with.accepted,
        plain.predicted,
        with.predicted,
        plain.holdout_ut,
        with.holdout_ut,
        plain.unseen_ut,
        with.unseen_ut,
        plain.error,
        with.error
    );
}

fn usage() -> ExitCode {
    eprintln!("usage: cargo additions-accuracy [--seeds N] [--each] [--accept]");
    ExitCode::from(2)
}
