//! The field's magnitude follows a column: `field:COLUMN`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated, times};

/// It.
pub struct Field;

impl Simulated for Field {
    fn kind(&self) -> &'static str {
        "field"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["field:COLUMN"]
    }
    fn takes_column(&self) -> bool {
        true
    }
    fn coefficients(&self) -> usize {
        1
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
        _: [f64; 3],
    ) -> [f64; 3] {
        // The field itself is stronger, whatever else disturbs the sensor.
        let share = drawn.theta(0) * (self.input(kind, drawn, scene, t_s) - drawn.reference);
        times(scene.clean_ut(t_s), share)
    }
    fn describe(&self, _: &EffectKind, drawn: &Drawn) -> String {
        format!(", zero at {}", drawn.reference)
    }
}
