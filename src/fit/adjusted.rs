//! Adjusted least squares: no bias from noise, and the noise itself estimated, from the same sums.
//!
//! The estimate is the null vector of `Ψ(s)` at the root of `λ_min(Ψ(s)) = 0` (Markovsky, Kukush, Van Huffel 2004; for
//! magnetometers Renaudin, Afzal, Lachapelle 2010). The root is found with a few Cholesky factorisations, no eigen
//! solver: for the minimiser `x` at the current `s`, the root of the quadratic `xᵀΨ(t)x` in `t` is the next `s`.

use super::psi::{Matrix10, Vector10, quadratic_form};
use super::trace::{Model, minimise};
use super::{FitError, Termination};
use crate::math;

/// Relative change of `s` at which the iteration stops.
const TOLERANCE: f64 = 1e-6;
/// Changes of `s` (rms radius squared as unit) below the rounding of the moments.
const ROUNDING: f64 = 1e-16;
const MAX_STEPS: u8 = 40;

/// A root of the adjusted least squares.
pub(crate) struct Root {
    /// The null vector, `x₉ = 1`.
    pub x: Vector10,
    /// The noise variance per axis, in the scatter's units squared, not yet corrected for the parameters.
    pub s: f64,
    pub condition_number: f64,
    pub termination: Termination,
}

/// Finds the root in `[0, upper]`; `upper` is the least eigenvalue of the samples' covariance.
///
/// # Errors
/// [`FitError::NotAnEllipsoid`] if the matrix is singular at `s = 0` already.
pub(crate) fn root(p: &[Matrix10; 3], upper: f64, model: Model) -> Result<Root, FitError> {
    let (mut low, mut high) = (0.0, upper.max(0.0));
    let mut s = 0.0;
    let mut best: Option<Root> = None;
    for step in 1..=MAX_STEPS {
        let psi = if s == 0.0 { p[0] } else { p[0] + p[1] * s + p[2] * (s * s) };
        let Some((x, condition_number)) = minimise(&psi, model) else {
            if step == 1 {
                return Err(FitError::NotAnEllipsoid);
            }
            // Past the point where the leading block is positive definite: the root is below.
            high = s;
            s = 0.5 * (low + high);
            continue;
        };
        let a = [quadratic_form(&p[0], &x), quadratic_form(&p[1], &x), quadratic_form(&p[2], &x)];
        if a[0] <= ROUNDING {
            // Noise-free to rounding: this is the trace solution, and there is nothing to adjust.
            return Ok(Root { x, s: 0.0, condition_number, termination: Termination::NoiseFree });
        }
        if a[0] + s * (a[1] + s * a[2]) > 0.0 {
            low = s;
        } else {
            high = s;
        }
        let discriminant = a[1] * a[1] - 4.0 * a[2] * a[0];
        let next =
            if discriminant >= 0.0 { 2.0 * a[0] / (-a[1] + math::sqrt(discriminant)) } else { f64::NAN };
        let inside = next >= low && next <= high;
        let change = math::abs(next - s);
        let done = inside && change <= TOLERANCE * s + ROUNDING;
        best = Some(Root { x, s, condition_number, termination: Termination::Converged { steps: step } });
        if done {
            break;
        }
        s = if inside { next } else { 0.5 * (low + high) };
        if high - low <= TOLERANCE * high + ROUNDING {
            break;
        }
    }
    let mut root = best.ok_or(FitError::NotAnEllipsoid)?;
    if let Termination::Converged { steps } = root.termination
        && steps >= MAX_STEPS
    {
        root.termination = Termination::StepLimit;
    }
    Ok(root)
}
