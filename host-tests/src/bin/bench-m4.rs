//! `cargo bench-m4`: instruction counts on the emulated Cortex-M4F, held to a snapshot.
//!
//! `--json` prints one object on standard output; `--accept` stores the figures as the new snapshot and in `host-tests/measured.md`.

use ironout_host_tests::m4::{M4Error, measure, snapshot};
use ironout_host_tests::measured;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut json = false;
    let mut accept = false;
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "--json" => json = true,
            "--accept" => accept = true,
            _ => {
                eprintln!("usage: cargo bench-m4 [--json] [--accept]");
                return ExitCode::from(2);
            }
        }
    }
    let measured = match measure() {
        Ok(measured) => measured,
        Err(M4Error::NoEmulator) if std::env::var_os("IRONOUT_REQUIRE_QEMU").is_none() => {
            eprintln!("skipped: {}", M4Error::NoEmulator);
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if json {
        println!("{}", measured.json());
    } else {
        print!("{}", measured.table());
    }
    let mut faults = measured.over_limit();
    if accept {
        let stored = std::fs::write(snapshot::path(), measured.table())
            .and_then(|()| measured::write(&[("m4", measured.table())]));
        if let Err(error) = stored {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    } else {
        let stored = std::fs::read_to_string(snapshot::path()).unwrap_or_default();
        faults.extend(snapshot::worse(&measured, &snapshot::parse(&stored)));
    }
    for fault in &faults {
        eprintln!("{fault}");
    }
    if faults.is_empty() {
        ExitCode::SUCCESS
    } else {
        eprintln!("if the change is meant: cargo bench-m4 --accept");
        ExitCode::FAILURE
    }
}
