//! Products of axes: `cross-axis`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated};

/// It.
pub struct CrossAxis;

impl Simulated for CrossAxis {
    fn kind(&self) -> &'static str {
        "cross-axis"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["cross-axis"]
    }
    fn coefficients(&self) -> usize {
        7
    }
    fn disturbance(
        &self,
        _: &EffectKind,
        drawn: &Drawn,
        _: &dyn Scene,
        _: f64,
        measured_ut: [f64; 3],
    ) -> [f64; 3] {
        let [x, y, z] = measured_ut;
        let (xy, xz, yz) = (x * y, x * z, y * z);
        let c = |index| drawn.theta(index);
        [c(0) * xy + c(1) * xz + c(6) * yz, c(2) * xy + c(3) * yz, c(4) * xz + c(5) * yz]
    }
}
