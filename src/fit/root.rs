//! Adjusted least squares: no bias from noise, and the noise itself estimated, from the same sums.
//!
//! The estimate is the null vector of `Ψ(s)` at the root of `λ_min(Ψ(s)) = 0` (Markovsky, Kukush, Van Huffel 2004; for
//! magnetometers Renaudin, Afzal, Lachapelle 2010). The root is found with a few factorisations, no eigen solver: for the
//! minimiser `x` at the current `s`, the root of the quadratic `xᵀΨ(t)x` in `t` is the next `s`. At `s = 0` the minimiser
//! is the least squares of the trace normalisation, which is the paper's in its robust reading.
//!
//! The matrices are in double precision; `s` and the steps towards it are known to no more than a millionth and are in
//! single precision, which a Cortex-M4F computes itself.

use super::report::Termination;
use crate::math;
use crate::monomial::COUNT;
use crate::quadric::{Lower, NoiseTerms, Order, corrected, factorise, gram, minimiser, pure};
use crate::scatter::Scatter;

/// Relative change of `s` at which the iteration stops.
const TOLERANCE: f32 = 1e-6;
/// Changes of `s` (rms radius squared as unit) below the rounding of the moments.
const ROUNDING: f32 = 1e-16;
const MAX_STEPS: u8 = 40;

/// A solution over the columns of [`gram`], and the matrix it was solved with.
#[derive(Clone)]
pub(crate) struct Root {
    /// The coefficients over [`crate::quadric`], with a trace of three.
    pub beta: [f64; 10],
    /// The factor of the normal matrix.
    pub factor: Lower,
    /// The noise variance per axis, in the scatter's units squared, not yet corrected for the parameters; `None` where the
    /// method does not estimate it.
    pub s: Option<f32>,
    /// Mean square of the quadric over the samples.
    pub mean_square: f32,
    /// What noise does to that.
    pub noise: NoiseTerms,
    /// Why it ended.
    pub termination: Termination,
}

impl Root {
    /// Nothing solved yet.
    pub const fn new() -> Self {
        Self {
            beta: [0.0; 10],
            factor: [[0.0; 10]; 10],
            s: None,
            mean_square: 0.0,
            noise: NoiseTerms::ZERO,
            termination: Termination::Direct,
        }
    }

    /// Solves with these moments; `false` unless the normal matrix is positive definite.
    #[inline(never)]
    fn solve(&mut self, scatter: &Scatter, moments: &[f64; COUNT], model: Order) -> bool {
        gram(moments, &mut self.factor);
        if !factorise(&mut self.factor, model) {
            return false;
        }
        self.beta = pure(&minimiser(&self.factor));
        self.noise = NoiseTerms::of(scatter, &self.beta);
        true
    }

    /// The noise variance per axis, in the scatter's units squared, corrected for the parameters.
    pub fn variance(&self, model: Order, samples: f32) -> f32 {
        let s = self.s.unwrap_or(self.mean_square / self.noise.gradient2);
        s * samples / (samples - model.parameters() as f32)
    }

    /// The mean square of the quadric as the moments of the last solve have it.
    fn left_over(&self) -> f32 {
        self.factor[9][9] as f32
    }

    /// The least squares of the trace normalisation.
    /// `false` if the normal matrix is singular.
    pub fn trace(&mut self, scatter: &Scatter, model: Order) -> bool {
        if !self.solve(scatter, &scatter.moments, model) {
            return false;
        }
        self.s = None;
        self.mean_square = self.left_over().max(0.0);
        self.termination = Termination::Direct;
        true
    }

    /// Finds the root in `[0, upper]`; `upper` is the least eigenvalue of the samples' covariance. `false` if the matrix is
    /// singular at `s = 0` already.
    pub fn adjusted(&mut self, scatter: &Scatter, upper: f32, model: Order) -> bool {
        let (mut low, mut high) = (0.0, upper.max(0.0));
        let (mut s, mut solved) = (0.0f32, 0.0);
        self.termination = Termination::StepLimit;
        for steps in 1..=MAX_STEPS {
            if !self.solve(scatter, &corrected(&scatter.moments, s), model) {
                if steps == 1 {
                    return false;
                }
                // Past the point where the leading block is positive definite: the root is below.
                high = s;
                s = 0.5 * (low + high);
                continue;
            }
            solved = s;
            let value = self.left_over();
            let [a1, a2] = self.noise.slopes();
            let slope = a1 + 2.0 * a2 * s;
            self.mean_square = (value - s * (a1 + a2 * s)).max(0.0);
            if steps == 1 && value <= ROUNDING {
                // Noise-free to rounding: there is nothing to adjust.
                self.termination = Termination::NoiseFree;
                break;
            }
            if value > 0.0 {
                low = s;
            } else {
                high = s;
            }
            let discriminant = slope * slope - 4.0 * a2 * value;
            let change = if discriminant >= 0.0 {
                2.0 * value / (math::sqrtf(discriminant) - slope)
            } else {
                f32::NAN
            };
            let next = s + change;
            let inside = next >= low && next <= high;
            let done = inside && change.abs() <= TOLERANCE * s + ROUNDING;
            if done || high - low <= TOLERANCE * high + ROUNDING {
                self.termination = Termination::Converged { steps };
                break;
            }
            s = if inside { next } else { 0.5 * (low + high) };
        }
        self.s = Some(solved);
        // Where the step limit came after a matrix that could not be factored, the last good one is restored.
        self.termination != Termination::StepLimit
            || self.solve(scatter, &corrected(&scatter.moments, solved), model)
    }
}
