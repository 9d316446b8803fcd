//! What a session is told.

use crate::fit::Method;
use crate::gate::block_samples;
use crate::math;
use crate::sensor::{AxisMap, Sample, Sensor};

/// What a session needs to know of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SessionConfig {
    /// Scale of each axis, µT per count.
    pub ut_per_count: [f64; 3],
    /// The expected magnitude of the field, µT; `None` keeps the mean magnitude.
    pub field_ut: Option<f64>,
    /// The method; without the feature `methods` it is [`Method::Adjusted`], and no other is linked.
    #[cfg(feature = "methods")]
    pub method: Method,
    /// Samples in a block of the rest gate; see [`crate::gate::block_samples`].
    pub samples_per_block: u16,
    /// How the sensor is mounted, as the record of [`Session::accept`](super::Session::accept) says it; `None` where the samples are in
    /// the chip's own axes and nobody asks.
    pub axes: Option<AxisMap>,
}

impl SessionConfig {
    /// For counts of this scale (µT per count, by axis) at this rate (samples a second, 0 where it is not known); the default method, no
    /// expected magnitude, no mounting.
    pub fn scaled(ut_per_count: [f64; 3], rate_hz: f64) -> Self {
        Self {
            ut_per_count,
            field_ut: None,
            #[cfg(feature = "methods")]
            method: Method::default(),
            samples_per_block: block_samples(rate_hz),
            axes: None,
        }
    }

    /// For a sensor whose every conversion is taken: its scale in the board's axes, its rate, its mounting; the default method, and no
    /// expected magnitude.
    pub fn of(sensor: &Sensor) -> Self {
        let scaled = Self::scaled(sensor.board_ut_per_count().map(f64::from), f64::from(sensor.rate_hz));
        Self { axes: Some(sensor.axes), ..scaled }
    }

    /// A measurement in µT as a sample, rounded to counts. What is not finite, and what 16 bits do not hold, is out of range: choose
    /// scales as fine as the sensor's resolution, so that the largest value stays below 32 767 counts.
    pub fn sample(&self, measured_ut: [f32; 3]) -> Sample {
        let mut counts = [0_i16; 3];
        for ((count, value), scale) in counts.iter_mut().zip(measured_ut).zip(self.ut_per_count) {
            // The cast stays within 16 bits.
            *count = math::round(f64::from(value) / scale) as i16;
        }
        let ends = |count: &i16| matches!(*count, i16::MIN | i16::MAX);
        if counts.iter().any(ends) || !measured_ut.iter().all(|value| value.is_finite()) {
            Sample::out_of_range(counts)
        } else {
            Sample::valid(counts)
        }
    }

    /// The method of the next solve.
    pub const fn solved_by(&self) -> Method {
        #[cfg(feature = "methods")]
        return self.method;
        #[cfg(not(feature = "methods"))]
        Method::Adjusted
    }

    /// The scale in the precision of coverage, whose cells are coarse.
    pub(super) fn scale(&self) -> [f32; 3] {
        self.ut_per_count.map(|scale| scale as f32)
    }
}
