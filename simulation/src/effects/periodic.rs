//! A sinusoid in time: `periodic`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated, plus, times};
use std::f64::consts::TAU;

/// It.
pub struct Periodic;

impl Simulated for Periodic {
    fn kind(&self) -> &'static str {
        "periodic"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["periodic"]
    }
    fn coefficients(&self) -> usize {
        6
    }
    fn disturbance(&self, _: &EffectKind, drawn: &Drawn, _: &dyn Scene, t_s: f64, _: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = (TAU * drawn.frequency_hz * t_s).sin_cos();
        plus(times(drawn.three(0), sin), times(drawn.three(3), cos))
    }
    fn describe(&self, _: &EffectKind, drawn: &Drawn) -> String {
        format!(", frequency_hz = {}", drawn.frequency_hz)
    }
}
