//! A matrix of soft iron that follows a column: `soft-iron:COLUMN`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated};

/// It.
pub struct SoftIron;

impl Simulated for SoftIron {
    fn kind(&self) -> &'static str {
        "soft-iron"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["soft-iron:COLUMN"]
    }
    fn takes_column(&self) -> bool {
        true
    }
    fn coefficients(&self) -> usize {
        6
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
        // The field itself is bent, whatever else disturbs the sensor.
        let share = self.input(kind, drawn, scene, t_s) - drawn.reference;
        let [x, y, z] = scene.clean_ut(t_s).map(|axis| axis * share);
        let [xx, yy, zz] = drawn.three(0);
        let [xy, xz, yz] = drawn.three(3);
        [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
    }
    fn describe(&self, _: &EffectKind, drawn: &Drawn) -> String {
        format!(", zero at {}", drawn.reference)
    }
}
