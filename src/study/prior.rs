//! What is known before the data: how magnetometers are.

use super::normal::Normal;
use crate::math::Real;
use crate::model::Model;

/// The weak physical prior on the base model, as standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PhysicalPrior {
    /// Of each axis' gain against the mean gain.
    pub gain: f64,
    /// Of the angle between two axes, rad.
    pub skew: f64,
    /// Of the offset, in multiples of the field.
    pub offset_fields: f64,
}

impl Default for PhysicalPrior {
    /// Gains within 20 % of each other, axes within 10°, offset within a few times the field strength.
    fn default() -> Self {
        PhysicalPrior { gain: 0.2, skew: 0.17, offset_fields: 7.0 }
    }
}

impl PhysicalPrior {
    /// No soft iron at all: the sphere, for orientations that do not determine nine parameters.
    pub fn sphere() -> Self {
        PhysicalPrior { gain: 1e-5, skew: 1e-5, ..Self::default() }
    }
}

/// The prior as information added to a magnitude study of noise `sigma_ut`, linearised at `model`. It counts no rows; its
/// share of `rᵀr` is what the model departs from it.
pub fn base_prior<T: Real, const P: usize>(
    prior: &PhysicalPrior,
    model: &Model<T>,
    sigma_ut: f64,
    columns: usize,
) -> Normal<T, P> {
    let mut out = Normal::new(columns);
    let c = &model.matrix;
    let mean = (c[0][0] + c[1][1] + c[2][2]).as_f64() / 3.0;
    let mut observe = |weights: &[(usize, f64)], value: f64, sigma: f64| {
        let precision = (sigma_ut / sigma) * (sigma_ut / sigma);
        for &(i, a) in weights {
            out.pull(i, T::of(a * value * precision));
            for &(j, b) in weights {
                if j >= i {
                    out.inform(i, j, T::of(a * b * precision));
                }
            }
        }
        out.squares += T::of(value * value * precision);
    };
    // Gains against their mean: the mean itself is free, it is the field's magnitude.
    let diagonal = [3, 6, 8];
    for (axis, column) in diagonal.into_iter().enumerate() {
        let others = [(axis + 1) % 3, (axis + 2) % 3];
        let weights =
            [(column, 2.0 / 3.0), (diagonal[others[0]], -1.0 / 3.0), (diagonal[others[1]], -1.0 / 3.0)];
        observe(&weights, c[axis][axis].as_f64() - mean, prior.gain * mean);
    }
    for (column, value) in [(4, c[0][1]), (5, c[0][2]), (7, c[1][2])] {
        observe(&[(column, 1.0)], value.as_f64(), prior.skew * mean);
    }
    for (axis, value) in model.offset_ut.into_iter().enumerate() {
        let sigma = prior.offset_fields * model.field_ut.as_f64() / mean;
        observe(&[(axis, 1.0)], value.as_f64(), sigma);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_TURN: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    /// What a matrix and an offset of that many fields cost under the default prior, in variances of the noise.
    fn cost(matrix: [[f64; 3]; 3], offset_fields: f64) -> f64 {
        let model =
            Model::new([50.0 * offset_fields, 0.0, 0.0], matrix, 50.0, NO_TURN, 0.0).expect("regular");
        let normal: Normal<f64, 9> = base_prior(&PhysicalPrior::default(), &model, 0.5, 9);
        normal.squares() / 0.25
    }

    #[test]
    fn magnetometers_are_alike_within_a_fifth_ten_degrees_and_a_few_fields() {
        let diagonal = |x, y, z| [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
        assert_eq!(cost(NO_TURN, 0.0), 0.0);
        // One gain a fifth above the mean: once that error, and half of it for each of the others.
        assert!((cost(diagonal(1.2, 0.9, 0.9), 0.0) - 1.5).abs() < 1e-9);
        // The common scale is free.
        assert!(cost(diagonal(1.7, 1.7, 1.7), 0.0).abs() < 1e-9);
        let mut skewed = NO_TURN;
        skewed[0][2] = 10f64.to_radians();
        assert!((cost(skewed, 0.0) - 1.0).abs() < 0.1, "{}", cost(skewed, 0.0));
        assert!((cost(NO_TURN, 7.0) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_prior_pulls_towards_what_it_knows() {
        let matrix = [[1.2, 0.1, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 0.9]];
        let model = Model::new([100.0, 0.0, 0.0], matrix, 50.0, NO_TURN, 0.0).expect("regular");
        let prior: Normal<f64, 9> = base_prior(&PhysicalPrior::default(), &model, 0.5, 9);
        // What it knows nothing of, the common scale, is held weakly.
        let mut total = prior.clone();
        for i in [3, 6, 8] {
            for j in [3, 6, 8].into_iter().filter(|j| *j >= i) {
                total.inform(i, j, 1e-3);
            }
        }
        let factor = total.factor().expect("all is known");
        let step = total.step(&factor);
        let expected = [-100.0, 0.0, 0.0, -0.2, -0.1, 0.0, 0.1, 0.0, 0.1];
        for (step, expected) in step.iter().zip(expected) {
            assert!((step - expected).abs() < 1e-6, "{step} instead of {expected}");
        }
    }
}
