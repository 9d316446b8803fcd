//! Squares and cubes of each axis: `nonlinearity`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated, each, plus};

/// It.
pub struct Nonlinearity;

impl Simulated for Nonlinearity {
    fn kind(&self) -> &'static str {
        "nonlinearity"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["nonlinearity"]
    }
    fn coefficients(&self) -> usize {
        6
    }
    fn balance(&self, coefficients: &mut [f64], field_ut: f64) {
        // Squares are in µT per µT², cubes in µT per µT³: as shares of the field they are drawn alike.
        coefficients.iter_mut().skip(3).for_each(|cube| *cube /= field_ut);
    }
    fn disturbance(
        &self,
        _: &EffectKind,
        drawn: &Drawn,
        _: &dyn Scene,
        _: f64,
        measured_ut: [f64; 3],
    ) -> [f64; 3] {
        let square = each(measured_ut, measured_ut);
        plus(each(drawn.three(0), square), each(drawn.three(3), each(square, measured_ut)))
    }
}
