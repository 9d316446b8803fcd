//! `cargo accuracy`: how good calibrations are, what the verdict lets through, and how well hidden effects are found, as
//! tables held to their snapshots.
//!
//! `--calibrations` measures the first of them alone, `--predicted` that of predicted errors: minutes instead of an hour.
//! `--json` prints one object on standard output; `--accept` stores the tables as the new snapshots and writes those of `docs/measured.md`.

use ironout_host_tests::accuracy::effect_report::{Effects, SEEDS};
use ironout_host_tests::accuracy::irrelevant_table::{self, Irrelevant};
use ironout_host_tests::accuracy::predicted::{self, Predicted};
use ironout_host_tests::accuracy::truths_table::{LOGS, Truths};
use ironout_host_tests::accuracy::{gates, snapshot, table};
use std::process::ExitCode;

fn main() -> ExitCode {
    let (mut json, mut accept, mut calibrations, mut errors) = (false, false, false, false);
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "--json" => json = true,
            "--accept" => accept = true,
            "--calibrations" => calibrations = true,
            "--predicted" => errors = true,
            _ => {
                eprintln!("usage: cargo accuracy [--calibrations|--predicted] [--json] [--accept]");
                return ExitCode::from(2);
            }
        }
    }
    if errors {
        return alone_predicted(&measured_predicted(), json, accept);
    }
    eprintln!("calibrations and verdicts …");
    let solvers = table::measure(table::FULL);
    if calibrations {
        return alone(&solvers, json, accept);
    }
    eprintln!("hidden effects, minutes …");
    let effects = Effects::measure(SEEDS, |line| eprintln!("{line}"));
    eprintln!("irrelevant effects added, minutes …");
    let irrelevant = Irrelevant::measure(irrelevant_table::SEEDS, |_, _, _| {});
    eprintln!("harder truths, minutes …");
    let truths = Truths::measure(LOGS);
    let errors = measured_predicted();
    let (text, found, added) = (solvers.text(), effects.text(), irrelevant.text());
    if json {
        let mut object = solvers.json();
        object["effects"] = effects.json();
        object["dip"] = effects.dip_json();
        object["irrelevant"] = irrelevant.json();
        object["truths"] = truths.json();
        object["predicted"] = errors.json();
        println!("{object}");
    } else {
        print!(
            "{text}\nHidden effects\n\n{found}\nIrrelevant effects added\n\n{added}\nHarder truths\n\n{}\n{}\n\nPredicted errors\n\n{}",
            truths.text(),
            truths.times(),
            errors.text()
        );
    }
    let held = if accept {
        solvers
            .store()
            .and_then(|()| effects.store())
            .and_then(|()| irrelevant.store())
            .and_then(|()| truths.store())
            .and_then(|()| errors.store())
    } else {
        snapshot::hold(&table::snapshot_path(), &text)
            .and_then(|()| snapshot::hold(&Effects::snapshot_path(), &found))
            .and_then(|()| snapshot::hold(&Irrelevant::snapshot_path(), &added))
            .and_then(|()| truths.hold())
            .and_then(|()| errors.hold())
    };
    let mut good = true;
    if let Err(error) = held {
        eprintln!("{error}\nif the change is meant: cargo accuracy --accept, and look at the difference");
        good = false;
    }
    good &= accepts_none_wrongly(&solvers);
    if !irrelevant.holds() {
        eprintln!("irrelevant effects are accepted too often");
        good = false;
    }
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The table of predicted errors by itself.
fn alone_predicted(table: &Predicted, json: bool, accept: bool) -> ExitCode {
    if json {
        println!("{}", table.json());
    } else {
        print!("{}", table.text());
    }
    match if accept { table.store() } else { table.hold() } {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!(
                "{error}\nif the change is meant: cargo accuracy --predicted --accept, and look at the difference"
            );
            ExitCode::FAILURE
        }
    }
}

/// Measures it, a line for each kind as it begins.
fn measured_predicted() -> Predicted {
    eprintln!("predicted errors, minutes …");
    Predicted::measure(predicted::LOGS, |kind| eprintln!("{kind}"))
}

/// The table of calibrations and verdicts by itself.
fn alone(solvers: &table::Report, json: bool, accept: bool) -> ExitCode {
    if json {
        println!("{}", solvers.json());
    } else {
        print!("{}", solvers.text());
    }
    let held =
        if accept { solvers.store() } else { snapshot::hold(&table::snapshot_path(), &solvers.text()) };
    if let Err(error) = &held {
        eprintln!(
            "{error}\nif the change is meant: cargo accuracy --calibrations --accept, and look at the difference"
        );
    }
    let good = accepts_none_wrongly(solvers);
    if held.is_ok() && good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Whether no calibration of limited attitude was accepted that is off; says so where one was.
fn accepts_none_wrongly(solvers: &table::Report) -> bool {
    let wrong = solvers.wrongly_accepted();
    if wrong > 0 {
        let percent = gates::WRONG * 100.0;
        eprintln!(
            "{wrong} calibrations of limited attitude were accepted though off by more than {percent} %"
        );
    }
    wrong == 0
}
