//! A late sensor: as a pure delay (`lag`), or with eddy currents through a coupling (`eddy`, which is a lag too).

use super::simulated::{Drawn, EffectKind, Scene, Simulated, times};
use nalgebra::{Matrix3, Vector3};

/// A pure delay of the sensor, strength in multiples of the noise of the whole vector (`lag=18ms` states it in time).
pub struct Lag;

impl Simulated for Lag {
    fn kind(&self) -> &'static str {
        "lag"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["lag"]
    }
    fn takes_time(&self) -> bool {
        true
    }
    fn coefficients(&self) -> usize {
        1
    }
    fn disturbance(&self, _: &EffectKind, _: &Drawn, _: &dyn Scene, _: f64, _: [f64; 3]) -> [f64; 3] {
        // The sensor sees an earlier field; nothing is added to it.
        [0.0; 3]
    }
    fn hidden_from_the_magnitude(&self, drawn: &Drawn, scene: &dyn Scene, t_s: f64) -> Option<[f64; 3]> {
        Some(times(scene.turning_ut_per_s(t_s), drawn.theta(0)))
    }
    fn settle(&self, drawn: &mut Drawn) {
        drawn.delay_s = drawn.theta(0).abs();
        drawn.coefficients = vec![drawn.delay_s];
    }
    fn pure_delay_s(&self, drawn: &Drawn) -> f64 {
        drawn.delay_s
    }
    fn describe(&self, _: &EffectKind, drawn: &Drawn) -> String {
        format!(", delay_s = {}", drawn.delay_s)
    }
}

/// Eddy currents: a 3×3 coupling to the rate of change of the field.
pub struct Eddy;

impl Simulated for Eddy {
    fn kind(&self) -> &'static str {
        "eddy"
    }
    fn id(&self) -> &'static str {
        Lag.kind()
    }
    fn listed(&self) -> &'static [&'static str] {
        &["eddy"]
    }
    fn coefficients(&self) -> usize {
        9
    }
    fn disturbance(
        &self,
        _: &EffectKind,
        drawn: &Drawn,
        scene: &dyn Scene,
        t_s: f64,
        _: [f64; 3],
    ) -> [f64; 3] {
        let coupling = Matrix3::from_fn(|i, j| drawn.theta(3 * i + j));
        (coupling * Vector3::from(scene.turning_ut_per_s(t_s))).into()
    }
    fn describe(&self, _: &EffectKind, _: &Drawn) -> String {
        " (eddy currents)".into()
    }
}
