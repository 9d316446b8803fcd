//! A sensor in numbers.

use crate::axes::AxisMap;
use crate::sample::{Reading, Sample};

/// What an application needs to know of a sensor as it is configured and mounted.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sensor {
    /// The chip's name, for logs and for the console.
    pub name: &'static str,
    /// µT per count along each of the *chip's* axes.
    pub ut_per_count: [f32; 3],
    /// How the chip sits on the board.
    pub axes: AxisMap,
    /// Measurements a second.
    pub rate_hz: f32,
    /// The largest magnitude of a valid count.
    pub full_scale_counts: u16,
    /// Bits of the chip's own count, its sign among them.
    pub bits: u8,
    /// How many of the chip's low bits a count leaves out, so that chips with more than 16 bits fit one: a count is the chip's
    /// divided by 2^shift, rounded. Everything else here (`ut_per_count`, `full_scale_counts`) is about counts as they are
    /// carried, so that a fit needs nothing but `ut_per_count`.
    pub shift: u8,
}

impl Sensor {
    /// A sensor with one scale (µT per count) for all axes, the board's axes, and the full range of 16 bits. For sensors
    /// without a driver of the kind, and to fill in the rest of a description.
    pub const fn uniform(name: &'static str, ut_per_count: f32, rate_hz: f32) -> Self {
        Self {
            name,
            ut_per_count: [ut_per_count; 3],
            axes: AxisMap::IDENTITY,
            rate_hz,
            full_scale_counts: i16::MAX as u16,
            bits: 16,
            shift: 0,
        }
    }

    /// The same sensor, mounted like this.
    #[must_use]
    pub const fn mounted(self, axes: AxisMap) -> Self {
        Self { axes, ..self }
    }

    /// A reading (chip axes) as a sample (board axes). A count beyond the full scale is out of range, whatever the chip says.
    #[inline]
    pub fn sample(&self, reading: &Reading) -> Sample {
        let counts = self.axes.counts(reading.counts);
        let beyond = |count: &i16| count.unsigned_abs() > self.full_scale_counts.saturating_add(1);
        if reading.saturated() || counts.iter().any(beyond) {
            Sample::out_of_range(counts)
        } else {
            Sample::valid(counts)
        }
    }

    /// The noise that rounding to a count adds to each of the chip's axes, µT (one standard deviation: a count over √12).
    pub fn rounding_ut(&self) -> [f32; 3] {
        self.ut_per_count.map(|ut| ut * 0.288_675_13)
    }

    /// µT per count along each of the board's axes.
    #[inline]
    pub fn board_ut_per_count(&self) -> [f32; 3] {
        self.axes.unsigned(self.ut_per_count)
    }

    /// The measured field of a sample, µT in the board's axes; `None` for one out of range.
    #[inline]
    pub fn measured_ut(&self, sample: Sample) -> Option<[f32; 3]> {
        let ([x, y, z], [sx, sy, sz]) = (sample.counts.map(f32::from), self.board_ut_per_count());
        sample.is_valid().then_some([x * sx, y * sy, z * sz])
    }

    /// Time between two measurements, ms: 1 at least, 20 where the rate is no positive number.
    pub fn period_ms(&self) -> u32 {
        if self.rate_hz.is_finite() && self.rate_hz > 0.0 {
            // `as` saturates: a rate next to nothing is a very long period.
            ((1000.0 / self.rate_hz) as u32).max(1)
        } else {
            20
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Sensor;
    use crate::sample::{Reading, Sample};

    #[test]
    fn a_count_beyond_the_full_scale_is_no_measurement() {
        let sensor = Sensor { full_scale_counts: 2047, bits: 12, ..Sensor::uniform("chip", 0.1, 75.0) };
        let sample = |x| sensor.sample(&Reading { counts: [x, 0, 0], overflow: [false; 3] });
        assert_eq!(sample(2047), Sample::valid([2047, 0, 0]));
        // Two's complement has one value more below zero.
        assert_eq!(sample(-2048), Sample::valid([-2048, 0, 0]));
        assert_eq!(sample(-2049), Sample::out_of_range([-2049, 0, 0]));
        assert_eq!(sensor.measured_ut(sample(2049)), None);
        let flagged = Reading { counts: [1, 2, 3], overflow: [false, true, false] };
        assert!(!sensor.sample(&flagged).is_valid());
    }

    #[test]
    fn the_period_of_any_rate_is_a_number_of_milliseconds() {
        for (rate_hz, period_ms) in
            [(75.0, 13), (0.75, 1333), (5000.0, 1), (0.0, 20), (-3.0, 20), (f32::NAN, 20)]
        {
            assert_eq!(Sensor::uniform("chip", 0.1, rate_hz).period_ms(), period_ms, "{rate_hz}");
        }
    }
}
