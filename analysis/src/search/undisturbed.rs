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
use ironout::model::Secant;
use ironout::study::Residual;
use std::fmt;
use std::sync::Arc;

/// The undisturbed vector must take this many variances off the squared error. By chance, the wrong one does in one log of
/// a thousand at most.
const PREFERRED: f64 = 10.0;
/// Rounds in which coefficients and undisturbed vectors settle.
const MOST_ROUNDS: usize = 16;
/// After so many the error must be below that of the measured vector.
const PATIENCE: usize = 6;
/// Rounds from a measured vector to the undisturbed one.
const MOST_STEPS: usize = 60;
/// After so many the way to it is hastened.
const PLAIN_STEPS: usize = 3;
/// The undisturbed vector has settled when it moves by less than this, µT.
const SETTLED_UT: f64 = 1e-4;

/// An effect whose shape is taken at the undisturbed vector, as coefficients near its own give it.
struct Undisturbed<'a> {
    inner: Arc<dyn Effect<f64> + Send + Sync + 'a>,
    coefficients: Coefficients<f64>,
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
        let mut secant = Secant::default();
        for step in 0..MOST_STEPS {
            let off = self.inner.disturbance(&near, &self.coefficients);
            let found: [f64; 3] = core::array::from_fn(|axis| at.measured_ut[axis] - off[axis]);
            let moved = (0..3).map(|axis| (found[axis] - near.measured_ut[axis]).abs()).fold(0.0, f64::max);
            // The last plain step is the first that it learns from.
            let learns = step + 1 >= PLAIN_STEPS;
            let next = if learns { secant.next(near.measured_ut, found) } else { found };
            near.measured_ut = if step < PLAIN_STEPS { found } else { next };
            // A shape that runs away is not finite in the end, and the fit with it is not taken.
            if moved < SETTLED_UT || !moved.is_finite() {
                break;
            }
        }
        self.inner.shape(&near, shape);
    }
}

/// The model with its shapes at the undisturbed vector, settled. `None` where no effect reads the vector, or the fit fails.
fn undisturbed<'a>(pass: &Pass, plain: &Fitted<'a>, known: &Known) -> Result<Option<Fitted<'a>>, BadShape> {
    let inner: Vec<_> = plain.pieces.iter().map(|piece| piece.effect.clone()).collect();
    let mut at: Vec<_> = plain.pieces.iter().map(|piece| piece.coefficients).collect();
    let mut now = plain.clone();
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
        let Ok(Some(next)) = pass.approach(now.model, pieces, known) else { return Ok(None) };
        // By a tenth of a sample's variance.
        let settled = (next.squares - now.squares).abs() < 0.1 * now.squares / now.rows.max(1.0);
        now = next;
        if settled || (round >= PATIENCE && now.squares > plain.squares) {
            break;
        }
    }
    Ok(Some(now))
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
