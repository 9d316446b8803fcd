//! The boards: pins, clocks, buses and the chips on them, nothing else. A board is one module with these names:
//!
//! - `NAME` and `Board::take() -> Option<Board>`, whose fields are
//!   `sensor` ([`Magnetometer`](ironout_drivers::Magnetometer)),
//!   `store` ([`Store`](ironout::store::Store)),
//!   `console` (`read() -> Option<u8>` and [`core::fmt::Write`], neither of which waits for long),
//!   `clock` (`now_ms() -> u64`) and `panel` (`set_light(bool)`, `button_down() -> bool`);
//! - `sleep()`, which waits for an interrupt, at most a millisecond.

#[cfg(feature = "board-mps2")]
mod mps2;
#[cfg(feature = "board-mps2")]
pub use mps2::*;
