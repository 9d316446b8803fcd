//! Two calibrations of one recording, side by side.

use ironout::calibration::Calibration;

/// Offset, upper triangle and the coefficients of one effect that follows a column, at a common reference.
#[derive(Clone, Copy, Debug)]
pub struct Both {
    /// Greatest difference of an offset, µT, ...
    pub offset_ut: f64,
    /// ... of an entry of the upper triangle, ...
    pub triangle: f64,
    /// ... and of a coefficient, in its unit.
    pub coefficient: f64,
}

/// The upper triangle with a positive diagonal that has the same `MᵀM`: what magnitudes know of a matrix.
pub fn triangle(calibration: &Calibration<f64>) -> [[f64; 3]; 3] {
    let m = nalgebra::Matrix3::from_fn(|i, j| calibration.matrix[i][j]);
    let factor = (m.transpose() * m).cholesky().expect("a calibration's matrix is regular").l();
    std::array::from_fn(|i| std::array::from_fn(|j| factor[(j, i)]))
}

/// A calibration and the coefficients of its effect, with the value of the column at which that is zero.
#[derive(Clone, Copy, Debug)]
pub struct One {
    /// Offset and matrix.
    pub calibration: Calibration<f64>,
    /// Coefficients.
    pub theta: [f64; 3],
    /// The reference.
    pub reference: f64,
}

impl One {
    /// The offset where the column has another value.
    pub fn offset_at(&self, value: f64) -> [f64; 3] {
        std::array::from_fn(|axis| {
            self.calibration.offset_ut[axis] + self.theta[axis] * (value - self.reference)
        })
    }
}

/// How far two are from each other.
pub fn apart(one: &One, other: &One) -> Both {
    let most = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let (t, u) = (triangle(&one.calibration), triangle(&other.calibration));
    Both {
        offset_ut: most(&one.offset_at(other.reference), &other.calibration.offset_ut),
        triangle: most(t.as_flattened(), u.as_flattened()),
        coefficient: most(&one.theta, &other.theta),
    }
}
