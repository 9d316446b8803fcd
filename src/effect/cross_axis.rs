//! Cross-axis sensitivity.

use super::{Effect, Quantities, Shape};
use crate::math::Real;
use core::fmt;

/// `cross-axis`: products of axes, the cross-field effect of magnetoresistive bridges.
///
/// Seven shapes, as many quadratic ones as the magnitude can tell apart: `xy` and `xz` on x, `xy` and `yz` on y, `xz`
/// and `yz` on z, and `yz` on x. They contain most of the squares of [`super::Nonlinearity`] as far as the magnitude
/// sees them; of the two the one with fewer coefficients is preferred.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct CrossAxis;

impl<T: Real> Effect<T> for CrossAxis {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str("cross-axis")
    }

    fn name(&self) -> &str {
        "cross-axis sensitivity"
    }

    fn explanation(&self) -> &str {
        "The field across a magnetoresistive bridge changes its sensitivity along it. \
         Each axis' error follows products of readings of different axes."
    }

    fn coefficients(&self) -> usize {
        7
    }

    fn unit(&self) -> &str {
        "1/µT"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let zero = T::zero();
        let [x, y, z] = at.measured_ut;
        let (xy, xz, yz) = (x * y, x * z, y * z);
        let [a, b, c, d, e, f, g, ..] = shape;
        *a = [xy, zero, zero];
        *b = [xz, zero, zero];
        *c = [zero, xy, zero];
        *d = [zero, yz, zero];
        *e = [zero, zero, xz];
        *f = [zero, zero, yz];
        *g = [yz, zero, zero];
    }

    fn reads_centre(&self) -> bool {
        false
    }
}
