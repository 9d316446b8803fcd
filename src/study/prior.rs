//! What is known before the data: how magnetometers are.

use super::normal::Normal;
use crate::math::Real;
use crate::model::Model;

/// The weak physical prior on the base model, as standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicalPrior {
    /// Of each axis' gain against the mean gain.
    pub gain: f64,
    /// Of the angle between two axes, rad.
    pub skew: f64,
    /// Of the offset, in multiples of the field.
    pub offset_fields: f64,
}

impl Default for PhysicalPrior {
    /// Gains within some 20 % of each other, axes within some 10°, offset within a few fields.
    fn default() -> Self {
        PhysicalPrior { gain: 0.2, skew: 0.17, offset_fields: 7.0 }
    }
}

impl PhysicalPrior {
    /// No soft iron at all: the sphere, for attitude that does not carry nine parameters.
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
