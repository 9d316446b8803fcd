//! One measurement, as the chip gives it and as the board sees it.

/// One measurement in the chip's own axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reading {
    /// x, y, z in counts.
    pub counts: [i16; 3],
    /// Per axis: the field was outside the range, so that the count is no measurement of it.
    pub overflow: [bool; 3],
}

impl Reading {
    /// A reading of a chip with wide counts: each divided by 2^`shift` and rounded, half a count away from zero, so that turning
    /// an axis around turns its counts around. An axis that `overflow` names, or whose count does not fit 16 bits, is out of
    /// range and stands at the end of them.
    ///
    /// ```
    /// use ironout_sensor::Reading;
    /// let reading = Reading::carried([131_000, -6, 5], 2, [false; 3]);
    /// assert_eq!((reading.counts, reading.overflow), ([32_750, -2, 1], [false; 3]));
    /// let reading = Reading::carried([131_071, -131_072, 0], 0, [false; 3]);
    /// assert_eq!((reading.counts, reading.overflow), ([i16::MAX, i16::MIN, 0], [true, true, false]));
    /// ```
    pub fn carried(wide: [i32; 3], shift: u8, overflow: [bool; 3]) -> Self {
        let mut reading = Self { counts: [0; 3], overflow };
        let axes = reading.counts.iter_mut().zip(reading.overflow.iter_mut());
        for ((count, overflow), wide) in axes.zip(wide) {
            let magnitude = i64::from(wide.unsigned_abs());
            let half = if shift == 0 { 0 } else { 1_i64.checked_shl(u32::from(shift) - 1).unwrap_or(0) };
            let rounded = (magnitude + half).checked_shr(u32::from(shift)).unwrap_or(0);
            let signed = if wide < 0 { -rounded } else { rounded };
            // −32 768 has no opposite: it is no measurement, as its opposite is none.
            match i16::try_from(signed) {
                Ok(fits) if fits != i16::MIN => *count = fits,
                _ => {
                    *count = if wide < 0 { i16::MIN } else { i16::MAX };
                    *overflow = true;
                }
            }
        }
        reading
    }

    /// Whether any axis was outside its range. Such a sample must not enter a calibration.
    pub fn saturated(&self) -> bool {
        self.overflow.iter().any(|&axis| axis)
    }
}

/// Whether the counts of a sample are a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Validity {
    /// They are.
    Valid,
    /// An axis was out of the sensor's range: they are shown and counted, and used for nothing.
    OutOfRange,
}

/// One measurement in the board's axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sample {
    /// x, y, z in counts.
    pub counts: [i16; 3],
    /// Whether they are a measurement.
    pub validity: Validity,
}

impl Sample {
    /// A measurement.
    pub const fn valid(counts: [i16; 3]) -> Self {
        Self { counts, validity: Validity::Valid }
    }

    /// Counts of a field out of the sensor's range.
    pub const fn out_of_range(counts: [i16; 3]) -> Self {
        Self { counts, validity: Validity::OutOfRange }
    }

    /// Whether the counts are a measurement.
    #[inline]
    pub const fn is_valid(&self) -> bool {
        matches!(self.validity, Validity::Valid)
    }
}

#[cfg(test)]
mod tests {
    use super::Reading;

    #[test]
    fn carried_counts_turn_around_with_their_axis_and_are_wrong_by_half_a_count_at_most() {
        for shift in 0..=8 {
            for wide in (-140_000..=140_000).step_by(37).chain([0, 1, 2, 3, 4, 5, 6, 7, 8]) {
                let one = Reading::carried([wide, 0, 0], shift, [false; 3]);
                let other = Reading::carried([-wide, 0, 0], shift, [false; 3]);
                assert_eq!(one.overflow, other.overflow, "{wide} {shift}");
                if one.saturated() {
                    // Only what does not fit.
                    assert!(wide.abs() >> shift >= 32_767, "{wide} {shift}");
                    continue;
                }
                assert_eq!(one.counts[0], -other.counts[0], "{wide} {shift}");
                let back = i32::from(one.counts[0]) << shift;
                assert!(2 * (back - wide).abs() <= 1 << shift, "{wide} {shift}: {back}");
            }
        }
    }

    #[test]
    fn any_number_and_any_shift_is_a_reading() {
        for wide in [i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX] {
            for shift in 0..=u8::MAX {
                let reading = Reading::carried([wide; 3], shift, [false, true, false]);
                assert!(reading.overflow[1]);
            }
        }
        let most = Reading::carried([i32::MIN, i32::MAX, 0], 16, [false; 3]);
        assert_eq!((most.counts, most.overflow), ([-32_768, 32_767, 0], [true, true, false]));
    }
}
