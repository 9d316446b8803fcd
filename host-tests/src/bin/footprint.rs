//! `cargo footprint [BOARD]`: builds the firmware and prints what it takes of the microcontroller's flash and RAM.

use std::process::ExitCode;

#[cfg(unix)]
fn main() -> ExitCode {
    use ironout_rig::qemu::Firmware;

    let board = std::env::args().nth(1).unwrap_or_else(|| "mps2".to_owned());
    let measured = Firmware::build_for(&format!("board-{board}")).and_then(|firmware| firmware.footprint());
    match measured {
        Ok(size) => {
            println!("firmware for {board}, bytes");
            println!(
                "  flash {:>7}  (code {}, constants {}, initial values {})",
                size.flash(),
                size.text,
                size.rodata,
                size.data
            );
            println!(
                "  RAM   {:>7}  (statics {}, stack region {})",
                size.ram(),
                size.data + size.bss,
                size.stack
            );
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(not(unix))]
fn main() -> ExitCode {
    eprintln!("the footprint is measured on Unix hosts only");
    ExitCode::FAILURE
}
