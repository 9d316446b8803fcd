//! An offset that drifts steadily: `drift`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated, times};

/// It.
pub struct Drift;

impl Simulated for Drift {
    fn kind(&self) -> &'static str {
        "drift"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["drift"]
    }
    fn coefficients(&self) -> usize {
        3
    }
    fn input(&self, _: &EffectKind, _: &Drawn, _: &dyn Scene, t_s: f64) -> f64 {
        t_s
    }
    fn disturbance(&self, _: &EffectKind, drawn: &Drawn, _: &dyn Scene, t_s: f64, _: [f64; 3]) -> [f64; 3] {
        times(drawn.three(0), t_s - drawn.reference)
    }
    fn describe(&self, _: &EffectKind, drawn: &Drawn) -> String {
        format!(", zero at {}", drawn.reference)
    }
}
