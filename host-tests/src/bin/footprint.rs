//! `cargo footprint [--accept | linked | BOARD]`: flash and RAM of the library and the firmware.
//!
//! Without an argument it builds the linked programs and all images, prints the table and compares it with the snapshot; `--accept`
//! writes the snapshot and the table in `docs/measured.md`. `linked` stops before the images; a board's name measures that image alone.

use std::process::ExitCode;

#[cfg(unix)]
fn main() -> ExitCode {
    let argument = std::env::args().nth(1);
    let measured = match argument.as_deref() {
        None | Some("--accept") => whole_table(argument.is_some()),
        Some("linked") => linked(),
        Some(board) => image(board),
    };
    match measured {
        Ok(faults) if faults.is_empty() => ExitCode::SUCCESS,
        Ok(faults) => {
            for fault in faults {
                eprintln!("{fault}");
            }
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(unix)]
type Faults = Result<Vec<String>, Box<dyn std::error::Error>>;

#[cfg(unix)]
fn stored() -> String {
    std::fs::read_to_string(ironout_host_tests::footprint::snapshot_path()).unwrap_or_default()
}

#[cfg(unix)]
fn linked() -> Faults {
    use ironout_host_tests::footprint::{programs, table, worse};
    let rows = programs()?;
    print!("{}", table(&rows));
    Ok(worse(&rows, &stored()))
}

#[cfg(unix)]
fn whole_table(accept: bool) -> Faults {
    use ironout_host_tests::footprint::{images, programs, snapshot_path, table, worse};
    let mut rows = programs()?;
    rows.extend(images()?);
    let text = table(&rows);
    print!("{text}");
    if !accept {
        return Ok(worse(&rows, &stored()));
    }
    std::fs::write(snapshot_path(), &text)?;
    ironout_host_tests::measured::write(&[("footprint", text)])?;
    Ok(Vec::new())
}

#[cfg(unix)]
fn image(board: &str) -> Faults {
    use ironout_rig::qemu::Firmware;
    let size = Firmware::build_for(&format!("board-{board}"))?.footprint()?;
    println!("firmware for {board}, bytes");
    println!(
        "  flash {:>7}  (code {}, constants {}, initial values {})",
        size.flash(),
        size.text,
        size.rodata,
        size.data
    );
    println!("  RAM   {:>7}  (statics {}, stack region {})", size.ram(), size.data + size.bss, size.stack);
    Ok(Vec::new())
}

#[cfg(not(unix))]
fn main() -> ExitCode {
    eprintln!("the footprint is measured on Unix hosts only");
    ExitCode::FAILURE
}
