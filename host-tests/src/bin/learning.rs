//! How often the board's own study names what is hidden: `cargo run --profile host -p ironout-host-tests --bin learning [SEEDS]`.

use ironout_host_tests::learning::{Kind, Row, TraceOptions, row, row_of};
use ironout_simulation::Motion;
use std::process::ExitCode;

/// The first seed: none of those that the study was made with.
const FIRST: u64 = 5001;

/// A false alarm is rarer than a miss, and takes more traces to see.
fn times(kind: Kind) -> u64 {
    if kind == Kind::Clean { 3 } else { 1 }
}

fn say(row: &Row) {
    let added =
        if row.added.of > 0 { format!("; added, at most 1.1 floors: {}", row.added) } else { String::new() };
    println!("{:<48} {} wrong: {:?}{added}", row.name, row.right, row.wrong);
}

fn main() -> ExitCode {
    let seeds = match std::env::args().nth(1).map(|text| text.parse::<u64>()) {
        None => 40,
        Some(Ok(seeds)) => seeds,
        Some(Err(_)) => {
            eprintln!("usage: learning [SEEDS]");
            return ExitCode::from(2);
        }
    };
    let kinds = [Kind::Clean, Kind::Temperature, Kind::Current, Kind::Lag, Kind::Step, Kind::Ramp];
    for (correlation, motion) in
        [(0.0, Motion::Sphere), (0.6, Motion::Sphere), (0.9, Motion::Sphere), (0.0, Motion::Hand)]
    {
        for kind in kinds {
            say(&row(kind, correlation, motion, FIRST..FIRST + seeds * times(kind)));
        }
    }
    for kind in [Kind::Clean, Kind::Lag] {
        let name = format!("{}, no gyro, noise 0.0, Sphere", kind.name());
        let options = TraceOptions { gyro: false, ..TraceOptions::new(kind, 0) };
        say(&row_of(name, options, FIRST..FIRST + seeds * times(kind)));
    }
    ExitCode::SUCCESS
}
