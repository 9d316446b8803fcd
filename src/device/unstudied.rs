//! What stands in the place of the study where it is left out: the values of columns, for the calibrations to come.

use heapless::Vec;

use crate::calibration::Calibration;
use crate::effect::ColumnName;

/// Columns whose values are kept.
pub(super) const MAX_TESTED: usize = 3;

/// What becomes of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fed {
    /// It is tested; without the study none is.
    #[allow(dead_code)]
    Tested,
    /// It is not.
    Not,
}

/// What accelerometer and gyro say, in the board's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    pub(super) accel_mps2: Option<[f32; 3]>,
    pub(super) turn_radps: Option<[f32; 3]>,
}

impl Motion {
    pub(super) const UNKNOWN: Self = Self { accel_mps2: None, turn_radps: None };
}

/// No question is ever under way.
#[derive(Debug, Clone)]
pub(super) enum Question {}

/// The columns' values.
#[derive(Debug, Clone)]
pub(super) struct Learner(Vec<(ColumnName, f32), MAX_TESTED>);

impl Learner {
    pub(super) const fn new() -> Self {
        Self(Vec::new())
    }

    pub(super) fn begin(&mut self, _: &Calibration<f64>) {}

    pub(super) fn begin_again(&mut self) {}

    pub(super) fn begin_anew(&mut self) {
        self.0.clear();
    }

    pub(super) fn field_ut(&self) -> Option<f64> {
        None
    }

    pub(super) fn feed(&mut self, name: &ColumnName, value: f32) -> Fed {
        match self.0.iter_mut().find(|(known, _)| known == name) {
            Some((_, kept)) => *kept = value,
            // Where there is no room, the calibration in use gets the value all the same.
            None => {
                let _ = self.0.push((*name, value));
            }
        }
        Fed::Not
    }

    pub(super) fn drop_column(&mut self, name: &str) {
        self.0.retain(|(known, _)| known.as_str() != name);
    }

    pub(super) fn tested(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    pub(super) fn value(&self, name: &str) -> Option<f32> {
        self.0.iter().find(|(known, _)| known.as_str() == name).map(|(_, value)| *value)
    }
}
