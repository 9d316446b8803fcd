//! A Raspberry Pi Pico on the bench: the image that one flashes, ELF or UF2, runs in an emulated RP2040 (rp2040js), with simulated
//! chips on its I²C bus, its console, its button and its power in the hands of a test or a demonstration.
//!
//! ```no_run
//! use ironout_rig::chips::Lsm303dlhcChip;
//! use ironout_rig::pico::{Pico, Port};
//! use ironout_rig::qemu::Firmware;
//! use std::{cell::RefCell, rc::Rc};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let firmware = Firmware::build_for("board-pico")?;
//! let mut board = Pico::start(firmware.path())?;
//! board.attach(Rc::new(RefCell::new(Lsm303dlhcChip::new(|_| [20.0, 0.0, 43.0], 0.1, 1))));
//! board.run_ms(100)?;
//! println!("{}", board.command("status")?);
//! # Ok(())
//! # }
//! ```
//!
//! All time is the board's own, counted in the cycles of its core: nothing depends on how fast or how busy the host is.

mod board;
mod error;
mod node;
mod program;
mod uf2;
mod wire;

pub use board::{
    BUTTON_PIN, CLOCK_PIN, CYCLES_PER_US, Calls, DATA_PIN, Ended, LIGHT_PIN, Pico, PinChange, Port,
    SLOT_STRIDE, SLOTS, State,
};
pub use error::Error;
pub use program::{REQUIRE, available, missing};
pub use uf2::uf2;
pub use wire::{Event, Fault};
