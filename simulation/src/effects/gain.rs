//! A gain of each axis in proportion to a column: `gain:COLUMN`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated, each, times};

/// It.
pub struct Gain;

impl Simulated for Gain {
    fn kind(&self) -> &'static str {
        "gain"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["gain:COLUMN"]
    }
    fn takes_column(&self) -> bool {
        true
    }
    fn coefficients(&self) -> usize {
        3
    }
    fn input(&self, kind: &EffectKind, _: &Drawn, scene: &dyn Scene, t_s: f64) -> f64 {
        scene.covariate(&kind.column, t_s)
    }
    fn disturbance(
        &self,
        kind: &EffectKind,
        drawn: &Drawn,
        scene: &dyn Scene,
        t_s: f64,
        measured_ut: [f64; 3],
    ) -> [f64; 3] {
        times(each(drawn.three(0), measured_ut), self.input(kind, drawn, scene, t_s) - drawn.reference)
    }
    fn describe(&self, _: &EffectKind, drawn: &Drawn) -> String {
        format!(", zero at {}", drawn.reference)
    }
}
