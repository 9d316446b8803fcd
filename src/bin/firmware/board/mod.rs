//! The boards: pins, clocks and buses, nothing else. A board is one module with these names:
//!
//! - `NAME`, `Board::take() -> Option<Board>` with the fields `bus` (embedded-hal [`I2c`](embedded_hal::i2c::I2c)),
//!   `console` (`read`, `write`, `try_write`), `clock` (`now_ms`, `sample_due`) and `panel` (`light`, `button_pressed`);
//! - `Delay` (embedded-hal [`DelayNs`](embedded_hal::delay::DelayNs)) and `sleep()`, which waits for an interrupt.

#[cfg(feature = "board-mps2")]
mod mps2;
#[cfg(feature = "board-mps2")]
pub use mps2::*;
