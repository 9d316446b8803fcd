//! One Gauss–Newton step of a study's model and of the effects in it.

use super::normal::Normal;
use super::pass::Study;
use crate::effect::Effect;
use crate::extended::FittedEffect;
use crate::math::{self, Real};
use crate::model::{Model, Residual};

/// The model after one step of a magnitude or dip study whose terms were `effects`, in that order; their coefficients are
/// moved too, and their standard errors set from the residual's spread (white noise).
///
/// Repeat passes until nothing moves: one makes it right to 0.1 % for effects up to 15 % of the field, two up to 30 %.
/// `None`, and nothing changed, where the data and the prior do not determine every parameter.
pub fn refit<T: Real, E: Effect<T>, const P: usize, const B: usize, const N: usize>(
    study: &Study<T, P, B, N>,
    prior: Option<&Normal<T, P>>,
    effects: &mut [FittedEffect<T, E>],
) -> Option<Model<T>> {
    let total = Normal::total(study.blocks(), prior);
    let factor = total.factor()?;
    let delta = total.step(&factor);
    let model = match study.residual() {
        Residual::Magnitude => study.model().stepped(&delta)?,
        Residual::Dip => study.model().aligned(&delta)?,
        Residual::Vector => return None,
    };
    let rows = f64::from(total.rows());
    let freedom = (rows - total.columns() as f64).max(1.0);
    let variance = total.squares_after(&delta).as_f64().max(0.0) / freedom;
    let mut column = study.residual().base_columns();
    for fitted in effects {
        let k = fitted.effect.coefficients();
        for (coefficient, error) in fitted.coefficients.iter_mut().zip(&mut fitted.std_errors).take(k) {
            *coefficient += delta.get(column).copied().unwrap_or(T::zero());
            let own = factor.inverse_column(column).get(column).copied().unwrap_or(T::zero());
            *error = T::of(math::sqrt(variance * own.as_f64()));
            column += 1;
        }
    }
    Some(model)
}
