//! How often the board's own study names what is hidden: `cargo run --profile host -p ironout-host-tests --bin learning [SEEDS]`.

use ironout_host_tests::learning::{Kind, row};
use ironout_simulation::Motion;
use std::process::ExitCode;

/// The first seed: none of those that the study was made with.
const FIRST: u64 = 5001;

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
            let row = row(kind, correlation, motion, FIRST..FIRST + seeds);
            println!("{:<44} {} wrong: {:?}", row.name, row.right, row.wrong);
        }
    }
    ExitCode::SUCCESS
}
