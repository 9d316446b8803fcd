//! The point at which the learner linearises, and what a sample is there: the model's rows of a plain base, in single precision
//! and without everything that only a host needs.

use crate::calibration::Calibration;
use crate::math;
use crate::real::Real;
use crate::vector::{cross, dot, inverse_3x3, minus, norm, product, scaled};

/// The base columns of the magnitude: offset over the field (3), the upper triangle of `C` (6).
pub(super) const BASE: usize = 9;

/// A base model: `r = ‖C (ĥ − b)‖ / F − 1`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) offset_ut: [f32; 3],
    /// The upper triangle of `C`, row after row.
    pub(super) triangle: [f32; 6],
    pub(super) field_ut: f32,
}

/// A sample at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// `r`, no unit.
    pub(super) residual: f32,
    /// Its derivatives by the base.
    pub(super) base: [f32; BASE],
    /// The corrected direction.
    pub(super) direction: [f32; 3],
}

impl Look {
    /// The derivatives by an offset, that over the field.
    pub(super) fn offset(&self) -> [f32; 3] {
        let [x, y, z, ..] = self.base;
        [x, y, z]
    }
}

/// `C v` and `Cᵀ u` of a triangle.
#[inline(always)]
fn times([a, b, c, d, e, f]: [f32; 6], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [a * x + b * y + c * z, d * y + e * z, f * z]
}
#[inline(always)]
fn transposed_times([a, b, c, d, e, f]: [f32; 6], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [a * x, b * x + d * y, c * x + e * y + f * z]
}

impl Point {
    /// The point of a calibration, and the rotation from the triangular frame to that of its matrix: `matrix = R C`. `None` where
    /// it is not sound.
    pub(super) fn of(calibration: &Calibration<f64>) -> Option<(Self, [[f64; 3]; 3])> {
        let m = &calibration.matrix;
        let column = |i: usize| [m[0][i], m[1][i], m[2][i]];
        let gram = |i: usize, j: usize| dot(column(i), column(j));
        // Cholesky of MᵀM, upper.
        let a = gram(0, 0).root();
        let (b, c) = (gram(0, 1) / a, gram(0, 2) / a);
        let d = (gram(1, 1) - b * b).root();
        let e = (gram(1, 2) - b * c) / d;
        let f = (gram(2, 2) - c * c - e * e).root();
        let triangle = [a, b, c, d, e, f];
        let finite = triangle.iter().chain(&calibration.offset_ut).all(|value| value.is_finite());
        if !(finite && a > 0.0 && d > 0.0 && f > 0.0 && calibration.field_ut > 0.0) {
            return None;
        }
        let rotation = product(m, &inverse_3x3(&[[a, b, c], [0.0, d, e], [0.0, 0.0, f]])?);
        let point = Self {
            offset_ut: calibration.offset_ut.map(|value| value as f32),
            triangle: triangle.map(|value| value as f32),
            field_ut: calibration.field_ut as f32,
        };
        Some((point, rotation))
    }

    /// The point after a step of the base columns.
    pub(super) fn stepped(&self, delta: &[f32]) -> Self {
        let d = |index: usize| delta.get(index).copied().unwrap_or(0.0);
        Self {
            offset_ut: core::array::from_fn(|axis| self.offset_ut[axis] + self.field_ut * d(axis)),
            triangle: core::array::from_fn(|index| self.triangle[index] + d(3 + index)),
            field_ut: self.field_ut,
        }
    }

    /// The calibration of this point, its matrix turned by a rotation.
    pub(super) fn calibration(&self, rotation: &[[f64; 3]; 3]) -> Calibration<f64> {
        let [a, b, c, d, e, f] = self.triangle.map(f64::from);
        Calibration {
            offset_ut: self.offset_ut.map(f64::from),
            matrix: product(rotation, &[[a, b, c], [0.0, d, e], [0.0, 0.0, f]]),
            field_ut: f64::from(self.field_ut),
        }
    }

    /// A measured vector, µT: its residual, and the derivatives at the closest point, where they do not hang together with its noise.
    /// `None` where something is not finite.
    #[inline]
    pub(super) fn look(&self, measured_ut: [f32; 3]) -> Option<Look> {
        let centred = minus(measured_ut, self.offset_ut);
        let h = times(self.triangle, centred);
        let length = norm(h);
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let direction = scaled(h, 1.0 / length);
        let pull = transposed_times(self.triangle, direction);
        let residual = length - self.field_ut;
        let closest = minus(centred, scaled(pull, residual / dot(pull, pull)));
        // Its length is the field's but for the square of the residual.
        let [a, b, c] = scaled(times(self.triangle, closest), 1.0 / self.field_ut);
        let [p, q, r] = transposed_times(self.triangle, [a, b, c]);
        let [x, y, z] = scaled(closest, 1.0 / self.field_ut);
        Some(Look {
            residual: residual / self.field_ut,
            base: [-p, -q, -r, a * x, a * y, a * z, b * y, b * z, c * z],
            direction,
        })
    }
}

/// A sample's dip: the angle of a unit direction to `down` about a mean one whose sine is `sine_mean`. `rate` is how the direction
/// turns, 1/s.
pub(super) fn dip(direction: [f32; 3], down: [f32; 3], rate: [f32; 3], sine_mean: f32) -> DipLook {
    let sine = dot(direction, down);
    let cosine = |sine: f32| math::sqrtf((1.0 - sine * sine).max(0.01));
    let (own, mean) = (cosine(sine), cosine(sine_mean));
    let [x, y, z] = scaled(cross(direction, down), 1.0 / own);
    let lag = dot(down, rate) / own;
    // The arc sine of the difference's sine: two degrees or twenty, the series is as good as single precision.
    let difference = sine * mean - sine_mean * own;
    let square = difference * difference;
    let residual = difference * (1.0 + square * (1.0 / 6.0 + square * (3.0 / 40.0)));
    DipLook { residual, row: [x, y, z, -1.0 / mean, lag] }
}

/// The angle to gravity less the mean one, rad; its derivatives by a rotation of the field, by the sine of the dip, and by a delay of
/// the sensor, s.
pub(super) struct DipLook {
    pub(super) residual: f32,
    pub(super) row: [f32; 5],
}
