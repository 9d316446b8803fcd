//! `cargo accuracy`: how good calibrations are, what the verdict lets through, and how well hidden effects are found, as
//! tables held to their snapshots.
//!
//! `--calibrations` measures the first of them alone, `--predicted` that of predicted errors, `--vehicles` that of headings of vehicles:
//! `--flights` that of ordinary flights beside MAGFit's least squares, which the whole does not run:
//! minutes instead of an hour.
//! `--json` prints one object on standard output; `--accept` stores the tables as the new snapshots and writes those of `docs/measured.md`.

use ironout_host_tests::accuracy::effect_report::{Effects, SEEDS};
use ironout_host_tests::accuracy::flights::Flights;
use ironout_host_tests::accuracy::irrelevant_table::{self, Irrelevant};
use ironout_host_tests::accuracy::predicted::{self, Predicted};
use ironout_host_tests::accuracy::truths_table::{LOGS, Truths};
use ironout_host_tests::accuracy::vehicles::{self, Vehicles};
use ironout_host_tests::accuracy::{gates, snapshot, table};
use std::process::ExitCode;

fn main() -> ExitCode {
    let (mut json, mut accept, mut calibrations, mut errors, mut vehicles, mut flights) =
        (false, false, false, false, false, false);
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "--json" => json = true,
            "--accept" => accept = true,
            "--calibrations" => calibrations = true,
            "--predicted" => errors = true,
            "--vehicles" => vehicles = true,
            "--flights" => flights = true,
            _ => {
                eprintln!(
                    "usage: cargo accuracy [--calibrations|--predicted|--vehicles|--flights] [--json] [--accept]"
                );
                return ExitCode::from(2);
            }
        }
    }
    if errors {
        let table = measured_predicted();
        let printed = if json { table.json().to_string() } else { table.text() };
        let held = if accept { table.store() } else { table.hold() };
        return exit_code(alone("--predicted", &printed, held));
    }
    if vehicles {
        let table = measured_vehicles();
        let printed = if json { table.json().to_string() } else { table.text() };
        let held = if accept { table.store() } else { table.hold() };
        return exit_code(alone("--vehicles", &printed, held));
    }
    if flights {
        let table = Flights::unseen(|attitude| eprintln!("{attitude} …"));
        let held = if accept { table.store() } else { table.hold() };
        return exit_code(alone("--flights", &table.text(), held));
    }
    eprintln!("calibrations and verdicts …");
    let solvers = table::measure(table::FULL);
    if calibrations {
        let printed = if json { solvers.json().to_string() } else { solvers.text() };
        let held =
            if accept { solvers.store() } else { snapshot::hold(&table::snapshot_path(), &solvers.text()) };
        let is_held = alone("--calibrations", &printed, held);
        return exit_code(accepts_none_wrongly(&solvers) && is_held);
    }
    eprintln!("hidden effects, minutes …");
    let effects = Effects::measure(SEEDS, |line| eprintln!("{line}"));
    eprintln!("irrelevant effects added, minutes …");
    let irrelevant = Irrelevant::measure(irrelevant_table::SEEDS, |_, _, _| {});
    eprintln!("harder truths, minutes …");
    let truths = Truths::measure(LOGS);
    let errors = measured_predicted();
    let headings = measured_vehicles();
    let (text, found, added) = (solvers.text(), effects.text(), irrelevant.text());
    if json {
        let mut object = solvers.json();
        object["effects"] = effects.json();
        object["dip"] = effects.dip_json();
        object["irrelevant"] = irrelevant.json();
        object["truths"] = truths.json();
        object["predicted"] = errors.json();
        object["vehicles"] = headings.json();
        println!("{object}");
    } else {
        print!(
            "{text}\nHidden effects\n\n{found}\nIrrelevant effects added\n\n{added}\nHarder truths\n\n{}\n{}\n\nPredicted errors\n\n{}\n\nHeadings of vehicles\n\n{}",
            truths.text(),
            truths.times(),
            errors.text(),
            headings.text()
        );
    }
    let held = if accept {
        solvers
            .store()
            .and_then(|()| effects.store())
            .and_then(|()| irrelevant.store())
            .and_then(|()| truths.store())
            .and_then(|()| errors.store())
            .and_then(|()| headings.store())
    } else {
        snapshot::hold(&table::snapshot_path(), &text)
            .and_then(|()| snapshot::hold(&Effects::snapshot_path(), &found))
            .and_then(|()| snapshot::hold(&Irrelevant::snapshot_path(), &added))
            .and_then(|()| truths.hold())
            .and_then(|()| errors.hold())
            .and_then(|()| headings.hold())
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
    exit_code(good)
}

fn exit_code(good: bool) -> ExitCode {
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The table of predicted errors, a line for each kind as it begins.
fn measured_predicted() -> Predicted {
    eprintln!("predicted errors, minutes …");
    Predicted::measure(predicted::LOGS, |kind| eprintln!("{kind}"))
}

/// The table of headings of vehicles.
fn measured_vehicles() -> Vehicles {
    eprintln!("headings of vehicles, minutes …");
    Vehicles::measure(vehicles::LOGS, |kind| eprintln!("{kind}"))
}

/// A table by itself, measured by this `option` alone: `printed`, and `held` to its snapshot or stored as one.
fn alone(option: &str, printed: &dyn std::fmt::Display, held: std::io::Result<()>) -> bool {
    println!("{printed}");
    if let Err(error) = &held {
        eprintln!(
            "{error}\nif the change is meant: cargo accuracy {option} --accept, and look at the difference"
        );
    }
    held.is_ok()
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
