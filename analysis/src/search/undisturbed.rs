//! At which vector a shape is looked at: the measured one, or the one without the disturbance.
//!
//! The model of a calibration evaluates `Φ` at the measured vector, which is what a correction has. A sensor may as well
//! obey `ĥ = x + Φ(x) θ` with `x = A h + b`: a core saturates with the field it is in, not with its own reading. The two
//! differ in the second order, which beyond twice the noise is enough to bias coefficients by several standard errors and
//! to look like a further effect. Where the data tell the two apart the search goes on with the one that fits.

use crate::base::engine::{Fitted, Pass};
use crate::base::known::Known;
use crate::base::piece::{BadShape, Piece};
use crate::samples::series::Autocorrelation;
use ironout::effect::{Acts, Coefficients, Column, Effect, MAX_INPUTS, Quantities, Shape};
use ironout::study::Residual;
use ironout::vector::{determinant, inverse_3x3, minus, norm, scaled, times};
use std::fmt;
use std::sync::Arc;

/// The undisturbed vector must take this many variances off the squared error. By chance, the wrong one does in one log of
/// a thousand at most.
const PREFERRED: f64 = 10.0;
/// Rounds in which coefficients and undisturbed vectors settle.
const MOST_ROUNDS: usize = 16;
/// After so many the error must be below that of the measured vector.
const PATIENCE: usize = 6;
/// Steps from a measured vector to the undisturbed one (Newton's).
const MOST_STEPS: usize = 12;
/// The undisturbed vector has settled when what it gives is this near to the reading, µT.
const SETTLED_UT: f64 = 1e-4;
/// The answer of the readings to the field is told from a step of this size, µT.
const STEP_UT: f64 = 1e-3;
/// Where a volume of fields becomes one of readings that is less than this share of it, the readings fold over.
const FOLDED: f64 = 0.1;

/// An effect whose shape is taken at the undisturbed vector, as coefficients near its own give it.
struct Undisturbed<'a> {
    inner: Arc<dyn Effect<f64> + Send + Sync + 'a>,
    coefficients: Coefficients<f64>,
}

impl Undisturbed<'_> {
    /// What the sensor reads in the field that these quantities have.
    fn found(&self, near: &Quantities<f64>) -> [f64; 3] {
        minus(near.measured_ut, scaled(self.inner.disturbance(near, &self.coefficients), -1.0))
    }
}

impl Effect<f64> for Undisturbed<'_> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        self.inner.id(out)
    }
    fn name(&self) -> &'static str {
        self.inner.name()
    }
    fn explanation(&self) -> &'static str {
        self.inner.explanation()
    }
    fn columns(&self) -> [Option<Column<'_, f64>>; MAX_INPUTS] {
        self.inner.columns()
    }
    fn needs_gyro(&self) -> bool {
        self.inner.needs_gyro()
    }
    fn coefficients(&self) -> usize {
        self.inner.coefficients()
    }
    fn unit(&self) -> &'static str {
        self.inner.unit()
    }
    fn reads_centre(&self) -> bool {
        self.inner.reads_centre()
    }
    fn delay_s(&self, coefficients: &Coefficients<f64>) -> Option<f64> {
        self.inner.delay_s(coefficients)
    }
    fn shape(&self, at: &Quantities<f64>, shape: &mut Shape<f64>) {
        let mut near = *at;
        let mut found = self.found(&near);
        for _ in 0..MOST_STEPS {
            let lacks = minus(at.measured_ut, found);
            if !(norm(lacks) > SETTLED_UT) {
                break;
            }
            // How the reading answers to the field, by differences.
            let mut answers = [[0.0; 3]; 3];
            for axis in 0..3 {
                let mut beside = near;
                beside.measured_ut[axis] += STEP_UT;
                let moved = minus(self.found(&beside), found);
                (0..3).for_each(|row| answers[row][axis] = moved[row] / STEP_UT);
            }
            // Coefficients on their way may fold the readings over, and then no field gives this one: the nearest is taken.
            if !(determinant(&answers) > FOLDED) {
                break;
            }
            let Some(inverse) = inverse_3x3(&answers) else { break };
            let step = times(&inverse, lacks);
            let mut next = near;
            next.measured_ut = minus(near.measured_ut, scaled(step, -1.0));
            let there = self.found(&next);
            // Past the fold.
            if !(norm(minus(at.measured_ut, there)) < norm(lacks)) {
                break;
            }
            (near, found) = (next, there);
        }
        self.inner.shape(&near, shape);
    }
}

/// The model with its shapes at the undisturbed vector, settled. `None` where no effect reads the vector, or the fit fails.
fn undisturbed<'a>(pass: &Pass, plain: &Fitted<'a>, known: &Known) -> Result<Option<Fitted<'a>>, BadShape> {
    let inner: Vec<_> = plain.pieces.iter().map(|piece| piece.effect.clone()).collect();
    let mut at: Vec<_> = plain.pieces.iter().map(|piece| piece.coefficients).collect();
    let mut now = plain.clone();
    let mut best: Option<Fitted> = None;
    for round in 0..MOST_ROUNDS {
        let mut pieces = now.pieces.clone();
        for ((piece, inner), at) in pieces.iter_mut().zip(&inner).zip(&mut at) {
            // Half way: coefficients that nearly make up for each other would overshoot.
            for (old, new) in at.iter_mut().zip(piece.coefficients) {
                *old = 0.5 * (*old + new);
            }
            if piece.acts(Acts::Measured) {
                piece.effect = Arc::new(Undisturbed { inner: inner.clone(), coefficients: *at });
            }
        }
        // A shape that ran away is no reason to give up the model that stands.
        let Ok(Some(next)) = pass.approach(now.model, pieces, known) else { return Ok(best) };
        // By a tenth of a sample's variance.
        let settled = (next.squares - now.squares).abs() < 0.1 * now.squares / now.rows.max(1.0);
        now = next;
        // Near a fold the rounds do not settle: the best of them counts.
        if best.as_ref().is_none_or(|best| now.squares < best.squares) {
            best = Some(now.clone());
        }
        let behind = |best: &Fitted| best.squares > plain.squares;
        if settled || (round >= PATIENCE && best.as_ref().is_none_or(behind)) {
            break;
        }
    }
    Ok(best)
}

/// Of the two models the one that the data ask for; the shapes at the measured vector where they do not tell.
pub fn prefer<'a>(pass: &Pass, fitted: Fitted<'a>, known: &Known) -> Result<Fitted<'a>, BadShape> {
    if pass.residual != Residual::Magnitude || !fitted.pieces.iter().any(|piece| piece.acts(Acts::Measured)) {
        return Ok(fitted);
    }
    let mut pieces = fitted.pieces.clone();
    for piece in &mut pieces {
        if let (Some(made), true) = (piece.made, piece.acts(Acts::Measured)) {
            piece.effect = Arc::new(made);
        }
    }
    let Some(plain) = pass.fit(fitted.model, pieces, known)? else { return Ok(fitted) };
    let Some(other) = undisturbed(pass, &plain, known)? else { return Ok(plain) };
    let list: Vec<&Piece> = other.pieces.iter().collect();
    let residuals = pass.residuals(&other.model, &list)?;
    let time = Autocorrelation::of(&residuals).time;
    let variance = other.squares / other.rows.max(1.0) * time;
    let better = other.squares.is_finite() && plain.squares - other.squares > PREFERRED * variance;
    Ok(if better { other } else { plain })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ironout::effect::{MAX_COEFFICIENTS, Nonlinearity, no_shape};

    /// The field at which the shape is looked at, of a reading of one axis, with this cube.
    fn field_of(reading: f64, cube: f64) -> f64 {
        let mut coefficients = [0.0; MAX_COEFFICIENTS];
        coefficients[3..6].fill(cube);
        let effect = Undisturbed { inner: Arc::new(Nonlinearity), coefficients };
        let at = Quantities {
            measured_ut: [reading, 0.0, 0.0],
            centred_ut: [reading, 0.0, 0.0],
            turning_ut_per_s: [0.0; 3],
            inputs: [0.0; MAX_INPUTS],
        };
        let mut shape = no_shape();
        effect.shape(&at, &mut shape);
        // The cube's own shape tells where it was taken.
        shape[3][0].cbrt()
    }

    #[test]
    fn a_core_that_saturates_is_looked_at_in_the_field_it_is_in() {
        let cube = -5e-5;
        for field in [-55.0_f64, -20.0, 8.0, 40.0, 60.0] {
            let found = field_of(field + cube * field.powi(3), cube);
            assert!((found - field).abs() < 1e-3, "{found} for {field}");
        }
    }

    #[test]
    fn a_reading_that_no_field_gives_is_looked_at_near_the_largest_that_there_is() {
        // Readings end at 54.4, in a field of 81.6.
        let found = field_of(70.0, -5e-5);
        assert!((60.0..90.0).contains(&found), "{found}");
    }
}
