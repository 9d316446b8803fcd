//! An offset that jumps once: `step`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated, times};

/// It.
pub struct Step;

impl Simulated for Step {
    fn kind(&self) -> &'static str {
        "step"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["step"]
    }
    fn coefficients(&self) -> usize {
        3
    }
    fn disturbance(&self, _: &EffectKind, drawn: &Drawn, _: &dyn Scene, t_s: f64, _: [f64; 3]) -> [f64; 3] {
        times(drawn.three(0), f64::from(t_s >= drawn.at_s))
    }
    fn describe(&self, _: &EffectKind, drawn: &Drawn) -> String {
        format!(", at_s = {}", drawn.at_s)
    }
}
