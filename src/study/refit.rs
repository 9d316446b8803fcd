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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{BuiltIn, ColumnName, Offset};
    use crate::model::{Observation, Term};

    const NO_TURN: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    /// The coefficients' errors over their standard errors, of an offset that follows a current: white noise of 0.3 µT.
    fn errors_over_standard_errors(seed: u64) -> [f64; 3] {
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
        };
        for _ in 0..5 {
            uniform();
        }
        let truth = [2.0, -1.0, 0.5];
        let column = ColumnName::new("current_a").expect("a name");
        let mut effects =
            [FittedEffect::new(BuiltIn::<f64>::Offset(Offset::linear(column, 0.0)), [0.0; 9], [0.0; 9])];
        let mut model = Model::new([10.0, -5.0, 3.0], NO_TURN, 50.0, NO_TURN, 0.0).expect("regular");
        let mut samples = [([0.0; 3], 0.0); 400];
        for (i, (measured, current)) in samples.iter_mut().enumerate() {
            let (turn, tilt) = (0.23 * i as f64, 0.071 * i as f64);
            *current = 2.0 * uniform();
            let field =
                [math::cos(tilt) * math::cos(turn), math::cos(tilt) * math::sin(turn), math::sin(tilt)];
            for axis in 0..3 {
                // Twelve uniform numbers: near enough to a normal one.
                let noise: f64 = (0..12).map(|_| uniform()).sum();
                measured[axis] =
                    50.0 * field[axis] + [10.0, -5.0, 3.0][axis] + truth[axis] * *current + 0.3 * noise;
            }
        }
        for _ in 0..3 {
            let mut study: Study<f64, 12, 2, 1> = Study::new(Residual::Magnitude, model, 3);
            for (i, (measured_ut, current)) in samples.iter().enumerate() {
                let term = Term {
                    effect: &effects[0].effect,
                    coefficients: effects[0].coefficients,
                    inputs: [*current, 0.0],
                    bends: effects[0].bends,
                };
                let reading = Observation { measured_ut: *measured_ut, turn_radps: None, down: None };
                study.push(i / 200, &reading, &[term]).expect("all is finite");
            }
            model = refit(&study, None, &mut effects).expect("determined");
        }
        core::array::from_fn(|i| (effects[0].coefficients[i] - truth[i]) / effects[0].std_errors[i])
    }

    #[test]
    fn the_standard_errors_are_as_large_as_the_errors() {
        const LOGS: u64 = 30;
        let mut square = 0.0;
        for seed in 0..LOGS {
            square += errors_over_standard_errors(seed * 7919 + 3).iter().map(|z| z * z).sum::<f64>();
        }
        let z = math::sqrt(square / (3.0 * LOGS as f64));
        // Ninety errors: a tenth of uncertainty, and some for the closest point.
        assert!((0.75..1.3).contains(&z), "{z}");
    }
}
