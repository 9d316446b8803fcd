//! An additive vector in proportion to the product of two columns: `product:ONE*OTHER`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated, times};

/// It.
pub struct Product;

impl Simulated for Product {
    fn kind(&self) -> &'static str {
        "product"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["product:COLUMN*COLUMN"]
    }
    fn takes_column(&self) -> bool {
        true
    }
    fn coefficients(&self) -> usize {
        3
    }
    fn input(&self, kind: &EffectKind, _: &Drawn, scene: &dyn Scene, t_s: f64) -> f64 {
        kind.columns().next().map_or(0.0, |name| scene.covariate(name, t_s))
    }
    fn disturbance(
        &self,
        kind: &EffectKind,
        drawn: &Drawn,
        scene: &dyn Scene,
        t_s: f64,
        _: [f64; 3],
    ) -> [f64; 3] {
        let other = kind.columns().nth(1).map_or(0.0, |name| scene.covariate(name, t_s));
        times(drawn.three(0), (self.input(kind, drawn, scene, t_s) - drawn.reference) * other)
    }
    fn describe(&self, _: &EffectKind, drawn: &Drawn) -> String {
        format!(", the first column zero at {}", drawn.reference)
    }
}
