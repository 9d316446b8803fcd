//! A hidden effect with its true coefficients.

use super::simulated::{Drawn, EffectKind, Scene};

/// A hidden effect with its true coefficients.
#[derive(Clone, Debug)]
pub struct HiddenEffect {
    /// Shape.
    pub kind: EffectKind,
    /// Its numbers.
    pub drawn: Drawn,
}

impl HiddenEffect {
    /// True coefficients, in the order and units of the effect of the same id in the library's catalogue.
    pub fn coefficients(&self) -> &[f64] {
        &self.drawn.coefficients
    }

    /// The truth in words: id, coefficients, and what else the effect has of time, frequency, delay or rotation.
    pub fn describe(&self) -> String {
        let besides = self.kind.simulated.describe(&self.kind, &self.drawn);
        format!("{} coefficients = {:?}{besides}", self.kind.id(), self.drawn.coefficients)
    }

    pub(crate) fn pure_delay_s(&self) -> f64 {
        self.kind.simulated.pure_delay_s(&self.drawn)
    }

    pub(crate) fn input(&self, scene: &dyn Scene, t_s: f64) -> f64 {
        self.kind.simulated.input(&self.kind, &self.drawn, scene, t_s)
    }

    /// The disturbance of the measured vector at a time, where the noise-free measured vector is `measured_ut`; µT.
    pub(crate) fn disturbance(&self, scene: &dyn Scene, t_s: f64, measured_ut: [f64; 3]) -> [f64; 3] {
        self.kind.simulated.disturbance(&self.kind, &self.drawn, scene, t_s, measured_ut)
    }
}
