//! What a board hands over that reads its sensor by itself, and what stands there for a board that does not.

#[cfg(not(any(feature = "board-pico", feature = "board-microbit-v2")))]
use ironout::device::Origin;
use ironout::device::SensorFault;
use ironout::sensor::Reading;

/// What the board's own accelerometer and gyro said, in its axes: m/s² of specific force, rad/s.
#[derive(Clone, Copy, Default)]
pub struct Moved {
    /// Specific force; `None` where there is no accelerometer, or it was out of its range.
    pub accel_mps2: Option<[f32; 3]>,
    /// Rate of turn.
    pub turn_radps: Option<[f32; 3]>,
}

/// What came of a reading that the board made by itself.
pub struct Sampled {
    /// When: the time of the interrupt.
    pub at_us: u64,
    /// The reading, or why there is none.
    pub reading: Result<Reading, SensorFault>,
    /// How the board moved then.
    pub moved: Moved,
    /// The chip's temperature, where it was asked for: `None` in it of a chip that has none.
    pub temp_c: Option<Option<f32>>,
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

    /// The device itself takes the time.
    pub const fn jitter_us(&self) -> Option<u32> {
        None
    }
}

/// For a board that measures nothing but field and motion.
#[cfg(not(any(feature = "board-pico", feature = "board-microbit-v2")))]
pub struct NoColumns;

#[cfg(not(any(feature = "board-pico", feature = "board-microbit-v2")))]
impl NoColumns {
    /// Nothing.
    pub fn measure(&mut self, _now_us: u64, _take: impl FnMut(&str, f32, Origin)) {}
}

/// For a board without a watchdog.
#[cfg(feature = "board-mps2")]
pub struct Unwatched;

#[cfg(feature = "board-mps2")]
impl Unwatched {
    /// Nobody watches.
    pub const fn turned(&mut self) {}
}
