//! `cargo footprint [linked | emulated | BOARD] [--accept]`: flash and RAM of the library and the firmware.
//! `cargo footprint --symbols [ROW]`: where the flash of that row, or of each linked program, goes.
//!
//! Without an argument it builds the linked programs and all images, prints the table and compares it with the snapshot; `--accept`
//! writes the snapshot and the table in `host-tests/measured.md`. `linked` leaves out the images, `emulated` those that no emulator runs. A
//! board's name measures that image alone. `--symbols` lists functions and constants in groups, by the room of the library or the crate, that
//! sum to the row of the table: the large ones of each program, or all of one row.

use std::process::ExitCode;

#[cfg(unix)]
fn main() -> ExitCode {
    let (flags, words): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|word| word.starts_with("--"));
    let (accept, symbols) = match flags.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        [] => (false, false),
        ["--accept"] => (true, false),
        ["--symbols"] => (false, true),
        _ => {
            eprintln!(
                "usage: cargo footprint [linked | emulated | BOARD] [--accept]\n       cargo footprint --symbols [ROW]"
            );
            return ExitCode::from(2);
        }
    };
    let measured = match words.first().map(String::as_str) {
        row if symbols => listed(row),
        None => table_of(Images::All, accept),
        Some("emulated") => table_of(Images::Emulated, accept),
        Some("linked") => table_of(Images::None, accept),
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
fn listed(row: Option<&str>) -> Faults {
    print!("{}", ironout_host_tests::footprint::symbols(row)?);
    Ok(Vec::new())
}

/// Which images are measured.
#[cfg(unix)]
enum Images {
    None,
    Emulated,
    All,
}

#[cfg(unix)]
fn table_of(which: Images, accept: bool) -> Faults {
    use ironout_host_tests::footprint::{images, programs, snapshot_path, table, with_stored, worse};
    let mut rows = programs()?;
    rows.extend(match which {
        Images::None => Vec::new(),
        Images::Emulated => images(true)?,
        Images::All => images(false)?,
    });
    print!("{}", table(&rows));
    if !accept {
        return Ok(worse(&rows, &stored()));
    }
    let text = table(&with_stored(&rows, &stored()));
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
