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
