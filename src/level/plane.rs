//! The plane of the readings.

use super::forces::Down;
use crate::calibration::Calibration;
use crate::math::symmetric_eigenvalues_3x3;
use crate::scatter::Scatter;
use crate::vector::{cross, dot, minus, norm, product, scaled, times, transposed_times};

/// An affine function of the scatter's coordinates: three slopes and a constant.
pub(super) type Affine = [f64; 4];

/// The plane of the readings, in the frame that the prior corrects to.
pub(super) struct Plane {
    /// Two directions in it, and its normal, down.
    pub(super) axes: [[f64; 3]; 3],
    /// The readings along them: affine functions of the scatter's coordinates; the last without its mean.
    pub(super) readings: [Affine; 3],
    /// The mean reading along the normal, µT.
    pub(super) vertical_ut: f64,
    /// Variance along the normal, µT².
    pub(super) thickness_ut2: f64,
}

impl Plane {
    pub(super) fn of(scatter: &Scatter, prior: &Calibration<f64>, down: Option<Down>) -> Option<Self> {
        let [xx, xy, xz, yy, yz, zz] = scatter.covariance;
        let slopes = prior.matrix.map(|row| scaled(row, scatter.scale_ut));
        let covariance = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let moved = product(&slopes, &covariance);
        let moved: [[f64; 3]; 3] =
            core::array::from_fn(|r| core::array::from_fn(|c| dot(moved[r], slopes[c])));
        let [least, middle, most] = symmetric_eigenvalues_3x3(&moved);
        // (S − λ₂)(S − λ₃) leaves the direction of the least variance alone.
        let without = |value: f64| {
            let mut matrix = moved;
            (0..3).for_each(|axis| matrix[axis][axis] -= value);
            matrix
        };
        let projector = product(&without(middle), &without(most));
        let longest = projector.into_iter().fold([0.0; 3], |a, b| if norm(b) > norm(a) { b } else { a });
        let length = norm(longest);
        if !(length > 0.0 && middle > 0.0) {
            return None;
        }
        let normal = scaled(longest, 1.0 / length);
        let normal = match down {
            Some(down) if dot(normal, down.direction.map(f64::from)) < 0.0 => scaled(normal, -1.0),
            // Board's axes: z is down.
            None if dot(normal, nearest_axis(normal)) < 0.0 => scaled(normal, -1.0),
            _ => normal,
        };
        let [x, y, z] = normal.map(f64::abs);
        let other = if x <= y && x <= z {
            [1.0, 0.0, 0.0]
        } else if y <= z {
            [0.0, 1.0, 0.0]
        } else {
            [0.0, 0.0, 1.0]
        };
        let first = cross(normal, other);
        let first = scaled(first, 1.0 / norm(first));
        let axes = [first, cross(normal, first), normal];
        let middle_ut = times(&prior.matrix, minus(scatter.centre_ut, prior.offset_ut));
        let mut readings = axes.map(|axis| {
            let [a, b, c] = transposed_times(&slopes, axis);
            [a, b, c, dot(axis, middle_ut)]
        });
        let means = [scatter.moment(1, 0, 0), scatter.moment(0, 1, 0), scatter.moment(0, 0, 1)];
        let [_, _, [a, b, c, constant]] = &mut readings;
        let vertical_ut = *constant + dot([*a, *b, *c], means);
        *constant -= vertical_ut;
        Some(Self { axes, readings, vertical_ut, thickness_ut2: least.max(0.0) })
    }
}

/// The board's axis that a direction is nearest to; z points down.
pub(super) fn nearest_axis(direction: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = direction.map(f64::abs);
    let sign = |value: f64| if value < 0.0 { -1.0 } else { 1.0 };
    if z >= x && z >= y {
        [0.0, 0.0, 1.0]
    } else if y >= x {
        [0.0, sign(direction[1]), 0.0]
    } else {
        [sign(direction[0]), 0.0, 0.0]
    }
}
