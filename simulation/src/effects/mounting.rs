//! What is wrong between the sensors: they are turned against each other, or a driver swaps axes.

use super::simulated::{Drawn, EffectKind, Scene, Simulated};
use nalgebra::{Rotation3, Unit, Vector3};

fn describe(drawn: &Drawn) -> String {
    drawn.rotation.map_or(String::new(), |rows| format!(", rotation = {rows:?}"))
}

/// A rotation between the magnetometer and the accelerometer, strength in degrees: `misalignment`.
pub struct Misalignment;

impl Simulated for Misalignment {
    fn kind(&self) -> &'static str {
        "misalignment"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["misalignment"]
    }
    fn usual_strength(&self) -> f64 {
        6.0
    }
    fn coefficients(&self) -> usize {
        0
    }
    fn rotation(&self, strength: f64, normal: &mut dyn FnMut() -> f64) -> Option<[[f64; 3]; 3]> {
        let axis = Unit::new_normalize(Vector3::from_fn(|_, _| normal()));
        let turn = *Rotation3::from_axis_angle(&axis, strength.to_radians()).matrix();
        Some(std::array::from_fn(|i| std::array::from_fn(|j| turn[(i, j)])))
    }
    fn disturbance(&self, _: &EffectKind, _: &Drawn, _: &dyn Scene, _: f64, _: [f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }
    fn describe(&self, _: &EffectKind, drawn: &Drawn) -> String {
        describe(drawn)
    }
}

/// The x and y axes swapped, a mirror image and no rotation: `axis-order`.
pub struct AxisOrder;

impl Simulated for AxisOrder {
    fn kind(&self) -> &'static str {
        "axis-order"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["axis-order"]
    }
    fn coefficients(&self) -> usize {
        0
    }
    fn rotation(&self, _: f64, _: &mut dyn FnMut() -> f64) -> Option<[[f64; 3]; 3]> {
        Some([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    }
    fn disturbance(&self, _: &EffectKind, _: &Drawn, _: &dyn Scene, _: f64, _: [f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }
    fn describe(&self, _: &EffectKind, drawn: &Drawn) -> String {
        describe(drawn)
    }
}
