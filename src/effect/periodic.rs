//! Periodic interference.

use super::{Column, Effect, MAX_INPUTS, Quantities, Shape, TIME, diagonal};
use crate::math::{self, Real};
use core::f64::consts::TAU;
use core::fmt;

/// `periodic`: `Φ = [I₃ sin ω(t − t₀) | I₃ cos ω(t − t₀)]`: mains, or a motor's fundamental, aliased by sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic {
    /// ω/2π, Hz.
    pub frequency_hz: f64,
    /// t₀, s.
    pub reference_s: f64,
}

impl<T: Real> Effect<T> for Periodic {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str("periodic")
    }

    fn name(&self) -> &str {
        "periodic interference"
    }

    fn explanation(&self) -> &str {
        "Mains wiring or a turning motor adds a field that alternates. \
         Sampled, it appears at its own frequency or folded below half the sampling rate."
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        [Some(Column::now(TIME)), None]
    }

    fn coefficients(&self) -> usize {
        6
    }

    fn unit(&self) -> &str {
        "µT (sine, then cosine)"
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        let [time, _] = at.inputs;
        // The phase in double precision and whole turns removed first: after an hour a single has lost it.
        let turns = self.frequency_hz * (time.as_f64() - self.reference_s);
        let phase = TAU * (turns - math::floor(turns));
        diagonal([T::of(math::sin(phase)); 3], 0, shape);
        diagonal([T::of(math::cos(phase)); 3], 3, shape);
    }

    fn reads_centre(&self) -> bool {
        false
    }
}
