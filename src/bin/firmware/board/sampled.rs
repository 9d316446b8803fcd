//! What a board hands over that reads its sensor by itself, and what stands there for a board that does not.

use ironout::device::SensorFault;
use ironout::sensor::Reading;

/// What came of a reading that the board made by itself.
pub struct Sampled {
    /// When.
    pub at_ms: u64,
    /// The reading, or why there is none.
    pub reading: Result<Reading, SensorFault>,
}

/// For a board whose sensor is read in the loop.
#[cfg(feature = "board-mps2")]
pub struct Polled;

#[cfg(feature = "board-mps2")]
impl Polled {
    /// Nothing, ever.
    pub const fn next(&mut self) -> Option<Sampled> {
        None
    }

    /// Never.
    pub const fn is_waiting(&self) -> bool {
        false
    }
}

/// For a board without a watchdog.
#[cfg(feature = "board-mps2")]
pub struct Unwatched;

#[cfg(feature = "board-mps2")]
impl Unwatched {
    /// Nobody watches.
    pub const fn turned(&mut self) {}
}
