//! Eddy currents.

use super::{Effect, Quantities, Shape};
use crate::math::Real;
use core::fmt;

/// `lag` too: a 3×3 coupling `E` to the turning field, `Φ θ = E·A (ω × h)`, rows first. Its share along the identity is
/// a pure delay ([`super::Lag`]), which only the dip sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Eddy;

impl<T: Real> Effect<T> for Eddy {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str("lag")
    }

    fn name(&self) -> &str {
        "lag and eddy currents"
    }

    fn explanation(&self) -> &str {
        "A field that turns with respect to the board induces currents in metal plates near the sensor, and filters \
         delay it. The error is in proportion to how fast the field turns, through a 3×3 coupling."
    }

    fn needs_gyro(&self) -> bool {
        true
    }

    fn coefficients(&self) -> usize {
        9
    }

    fn unit(&self) -> &str {
        "s"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let zero = T::zero();
        let [x, y, z] = at.turning_ut_per_s;
        *shape = [
            [x, zero, zero],
            [y, zero, zero],
            [z, zero, zero],
            [zero, x, zero],
            [zero, y, zero],
            [zero, z, zero],
            [zero, zero, x],
            [zero, zero, y],
            [zero, zero, z],
        ];
    }
}
