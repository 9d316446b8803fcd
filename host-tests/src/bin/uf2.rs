//! `cargo uf2 [-o FILE]`: builds the firmware for the Raspberry Pi Pico and writes the image that is copied onto the drive that
//! a Pico shows when `BOOTSEL` is held while it is plugged in.

use std::process::ExitCode;

#[cfg(unix)]
fn main() -> ExitCode {
    use ironout_rig::{pico::uf2, qemu::Firmware};

    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let file = match &arguments[..] {
        [] => "ironout-pico.uf2",
        [option, file] if option == "-o" => file,
        _ => {
            eprintln!("usage: cargo uf2 [-o FILE]");
            return ExitCode::from(2);
        }
    };
    let made = Firmware::build_for("board-pico")
        .map_err(|error| error.to_string())
        .and_then(|firmware| uf2(firmware.path()).map_err(|error| error.to_string()))
        .and_then(|image| std::fs::write(file, image).map_err(|error| format!("{file}: {error}")));
    match made {
        Ok(()) => {
            println!(
                "{file}: hold BOOTSEL while the Pico is plugged in, and copy the file onto the drive RPI-RP2"
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
    eprintln!("the image is made on Unix hosts only");
    ExitCode::FAILURE
}
