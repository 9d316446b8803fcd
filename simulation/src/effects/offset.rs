//! An additive vector in proportion to a column: `offset:COLUMN`, `offset:COLUMN^2`, `offset:COLUMN@delay`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated, times};

/// It.
pub struct Offset;

impl Simulated for Offset {
    fn kind(&self) -> &'static str {
        "offset"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["offset:COLUMN", "offset:COLUMN^2", "offset:COLUMN@delay"]
    }
    fn takes_column(&self) -> bool {
        true
    }
    fn takes_variants(&self) -> bool {
        true
    }
    fn coefficients(&self) -> usize {
        3
    }
    fn input(&self, kind: &EffectKind, drawn: &Drawn, scene: &dyn Scene, t_s: f64) -> f64 {
        let t_s = if kind.delayed { t_s - drawn.delay_s } else { t_s };
        scene.covariate(&kind.column, t_s).powi(if kind.squared { 2 } else { 1 })
    }
    fn disturbance(
        &self,
        kind: &EffectKind,
        drawn: &Drawn,
        scene: &dyn Scene,
        t_s: f64,
        _: [f64; 3],
    ) -> [f64; 3] {
        times(drawn.three(0), self.input(kind, drawn, scene, t_s) - drawn.reference)
    }
    fn describe(&self, kind: &EffectKind, drawn: &Drawn) -> String {
        let late = if kind.delayed { format!(", delay_s = {}", drawn.delay_s) } else { String::new() };
        format!(", zero at {}{late}", drawn.reference)
    }
}
