//! The calibration that an autopilot had applied, undone.

use nalgebra::{Matrix3, Vector3};

/// `corrected = matrix · (measured − offset)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction {
    /// Subtracted first.
    pub offset: Vector3<f64>,
    /// Applied then.
    pub matrix: Matrix3<f64>,
}

impl Correction {
    /// The symmetric matrix that autopilots store: its diagonal and 12, 13, 23 off it.
    pub fn symmetric(diagonal: [f64; 3], off_diagonal: [f64; 3]) -> Matrix3<f64> {
        let ([a, b, c], [d, e, f]) = (diagonal, off_diagonal);
        Matrix3::new(a, d, e, d, b, f, e, f, c)
    }

    /// What undoes it; `None` where the matrix cannot be inverted or is not finite.
    pub fn inverse(&self) -> Option<Undo> {
        let back = self.matrix.try_inverse()?;
        let sound = back.iter().chain(self.offset.iter()).all(|value| value.is_finite());
        sound.then_some(Undo { back, offset: self.offset })
    }

    /// Whether it changes nothing.
    pub fn is_identity(&self) -> bool {
        self.offset == Vector3::zeros() && self.matrix == Matrix3::identity()
    }
}

/// `measured = back · corrected + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undo {
    back: Matrix3<f64>,
    offset: Vector3<f64>,
}

impl Undo {
    /// What the sensor had measured.
    pub fn apply(&self, corrected: Vector3<f64>) -> Vector3<f64> {
        self.back * corrected + self.offset
    }
}
