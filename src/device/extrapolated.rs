//! What `status` says of a column outside the range that an effect was fitted over.

use core::fmt;

use crate::calibration::Calibration;
use crate::effect::{MAX_INPUTS, TIME};
use crate::extended::{FittedEffect, Outside};
use crate::math;
use crate::number::Num;

/// An effect of the calibration in use that is extrapolated now.
pub(super) struct Extrapolated<'a> {
    /// The column, its value and its range, in the calibration's precision and on the recording's clock.
    outside: Outside<'a, f64>,
    fitted: &'a FittedEffect<f64>,
    base: &'a Calibration<f64>,
}

impl<'a> Extrapolated<'a> {
    /// `outside` is what the live correction says, `origin_s` what the recording's clock shows when that of the correction is
    /// zero; `None` where the calibration has no such effect.
    pub(super) fn of(
        outside: Outside<'a, f32>,
        origin_s: f64,
        mut effects: impl Iterator<Item = &'a FittedEffect<f64>>,
        base: &'a Calibration<f64>,
    ) -> Option<Self> {
        let Outside { effect, input, column, value, range } = outside;
        let fitted = effects.nth(effect)?;
        let origin = if column == TIME { origin_s } else { 0.0 };
        let range = fitted.ranges.get(input).copied().flatten().unwrap_or(range.map(f64::from));
        let outside = Outside { effect, input, column, value: f64::from(value) + origin, range };
        Some(Self { outside, fitted, base })
    }

    /// The error, µT, that the standard errors of the coefficients alone make where the column has this value: in a field as
    /// strong on each axis, so that an effect on any of them is seen.
    fn error_ut(&self, value: f64) -> Option<f64> {
        let each = self.base.field_ut / math::sqrt(3.0);
        let mut inputs = [0.0; MAX_INPUTS];
        *inputs.get_mut(self.outside.input)? = value;
        self.fitted.error_ut(self.base, self.base.offset_ut.map(|offset| offset + each), inputs)
    }
}

impl fmt::Display for Extrapolated<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let outside = &self.outside;
        let ([least, most], value) = (outside.range.map(Num), Digits(outside.value));
        write!(
            f,
            "{}={value} by={} range={least:?},{most:?} effect=",
            outside.column,
            Digits(outside.distance())
        )?;
        crate::effect::Effect::<f64>::id(&self.fitted.effect, f)?;
        if let (Some(there), Some(here)) = (self.error_ut(outside.value), self.error_ut(outside.nearest())) {
            write!(f, " error_ut={:.3} error_at_range_ut={:.3}", Num(there), Num(here))?;
        }
        Ok(())
    }
}

/// A number with at least four significant digits, as far as nine decimals go.
struct Digits(f64);

impl fmt::Display for Digits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (mut size, mut decimals) = (math::abs(self.0), 1);
        while size < 100.0 && decimals < 9 {
            (size, decimals) = (10.0 * size, decimals + 1);
        }
        write!(f, "{:.decimals$}", Num(self.0))
    }
}
