//! The servo in simulated logs: `servo:COLUMN=STRENGTH`.

use ironout_simulation::{Drawn, EffectKind, Scene, Simulated};

/// A servo whose magnet turns with its arm.
pub struct SimulatedServo;

impl Simulated for SimulatedServo {
    fn kind(&self) -> &'static str {
        "servo"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["servo:COLUMN"]
    }
    fn takes_column(&self) -> bool {
        true
    }
    fn coefficients(&self) -> usize {
        2
    }
    fn disturbance(
        &self,
        kind: &EffectKind,
        drawn: &Drawn,
        scene: &dyn Scene,
        t_s: f64,
        _: [f64; 3],
    ) -> [f64; 3] {
        let (sin, cos) = scene.covariate(&kind.column, t_s).sin_cos();
        let (along, across) = (drawn.theta(0), drawn.theta(1));
        [along * cos - across * sin, along * sin + across * cos, 0.0]
    }
}
