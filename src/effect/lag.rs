//! A pure delay of the sensor.

use super::{Coefficients, Effect, Quantities, Shape};
use crate::math::Real;
use core::fmt;

/// `lag`: `ĥ(t) = A h(t − τ) + b`, to first order `Φ = A (ω × h)`, k = 1, the coefficient is τ.
///
/// Every late point still lies on the ellipsoid, so the magnitude cannot see it; the dip can.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Lag;

impl<T: Real> Effect<T> for Lag {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str("lag")
    }

    fn name(&self) -> &str {
        "sensor lag"
    }

    fn explanation(&self) -> &str {
        "The sensor's filter or its bus delays the reading against the other sensors. \
         While the board turns, the measured direction trails the true one."
    }

    fn needs_gyro(&self) -> bool {
        true
    }

    fn coefficients(&self) -> usize {
        1
    }

    fn unit(&self) -> &str {
        "s"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [first, ..] = shape;
        *first = at.turning_ut_per_s;
    }

    #[inline]
    fn disturbance(&self, at: &Quantities<T>, [delay, ..]: &Coefficients<T>) -> [T; 3] {
        at.turning_ut_per_s.map(|rate| rate * *delay)
    }
}
