//! The boards: pins, clocks, buses and the chips on them, nothing else. A board is one module with these names:
//!
//! - `NAME` and `Board::take() -> Option<Board>`, whose fields are
//!   `sensor` ([`Magnetometer`](ironout_drivers::Magnetometer)),
//!   `sampled` (`next() -> Option<Sampled>`, `is_waiting() -> bool` and `jitter_us() -> Option<u32>`: what was read beside the loop, with
//!   [`Pace::Pushed`](ironout::device::Pace); [`Polled`](sampled) where the device asks for each sample),
//!   `columns` (`measure(now_us, take)`, which gives `take` the columns that the board measures beside field and motion, with
//!   [`Origin`](ironout::device::Origin); [`NoColumns`](sampled) where there are none),
//!   `store` ([`Store`](ironout::store::Store)),
//!   `console` (`read() -> Option<u8>`, `has_input() -> bool` and [`Output`](ironout::device::Output), none of which waits),
//!   `clock` (`now_us() -> u64`, and `sleep_until_ms(deadline, awake)`, which waits for the deadline or an interrupt unless
//!   `awake()`), `panel` (`show(&Shown)`, `button_down() -> bool`) and
//!   `watchdog` (`turned()`, told at each turn of the loop; [`Unwatched`](sampled) where there is none);
//! - `MOUNTING`, how the sensor sits on the board, `PACE`, when samples are taken, and `SHOWS_COVERAGE`, whether its lights show
//!   more than a state;
//! - `was_hung() -> bool`: whether the watchdog has restarted the board; `restart() -> !` restarts it;
//! - `last_words(text) -> !`, which answers each line on the console with `text` for ever: for a firmware that fails at every start.

#[cfg(any(feature = "board-microbit-v2", feature = "board-stm32f3discovery"))]
mod counter;
#[cfg(not(feature = "board-mps2"))]
mod lines;
#[cfg(feature = "board-microbit-v2")]
mod microbit_v2;
#[cfg(any(feature = "board-microbit-v2", feature = "board-stm32f3discovery"))]
mod motion;
#[cfg(feature = "board-mps2")]
mod mps2;
mod outgoing;
#[cfg(feature = "board-pico")]
mod pico;
#[cfg(not(feature = "board-mps2"))]
mod port;
mod sampled;
#[cfg(not(feature = "board-mps2"))]
mod sampler;
#[cfg(any(feature = "board-microbit-v2", feature = "board-stm32f3discovery"))]
mod shared_bus;
#[cfg(feature = "board-stm32f3discovery")]
mod stm32f3discovery;

#[cfg(feature = "board-microbit-v2")]
pub use microbit_v2::*;
#[cfg(feature = "board-mps2")]
pub use mps2::*;
#[cfg(feature = "board-pico")]
pub use pico::*;
pub use sampled::Sampled;
#[cfg(feature = "board-stm32f3discovery")]
pub use stm32f3discovery::*;
