//! Level turns that show nothing better than the calibration in use.

use core::fmt;

use crate::level::{InUse, LevelFit};
use crate::number::Num;
use crate::replacement::Worse;

/// The calibration in use gives level headings as good as the new one, and holds for as much tilt.
#[derive(Clone, Copy, Debug)]
pub(super) struct LevelWorse {
    new_deg: f32,
    in_use_deg: f32,
}

impl LevelWorse {
    pub(super) fn of(fit: &LevelFit) -> Option<Self> {
        let InUse { heading_error_deg, is_as_good } = fit.in_use?;
        let [new_deg, ..] = fit.holds_for.heading_errors_deg;
        is_as_good.then_some(Self { new_deg, in_use_deg: heading_error_deg as f32 })
    }
}

impl fmt::Display for LevelWorse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} level headings of the calibration in use are right to {:.2} deg, of the new one to {:.2} deg, and the one in use holds for \
             as much tilt: keep it with cal cancel, or use: cal accept force",
            Worse::CODE,
            Num(self.in_use_deg),
            Num(self.new_deg)
        )
    }
}
