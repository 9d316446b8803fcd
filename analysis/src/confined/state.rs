//! The parameters of the model, and a step of them.

use crate::base::windows::GYRO;
use nalgebra::{Matrix3, Rotation3, SVector, Vector3};

/// First of the three offsets, µT.
pub const OFFSET: usize = 0;
/// First of the nine entries of `E` in `matrix = (1 + E) · matrix`, by rows.
pub const MATRIX: usize = 3;
/// The magnitude of the field, µT.
pub const FIELD: usize = 12;
/// Its part along gravity, µT.
pub const VERTICAL: usize = 13;
/// First of the gyro's errors: bias (3, rad/s), gains and axes (9, by columns).
pub const RATE: usize = 14;
/// By how much the magnetometer is later than the gyro, s.
pub const DELAY: usize = RATE + GYRO;
/// First of the accelerometer's zero error (3), in parts of gravity.
pub const ZERO: usize = DELAY + 1;
/// By which part tilts are larger than the accelerometer shows them.
pub const TILT: usize = ZERO + 3;
/// All parameters.
pub const PARAMETERS: usize = TILT + 1;

/// Values of the parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Hard iron, µT.
    pub offset_ut: Vector3<f64>,
    /// From readings to the axes of the accelerometer.
    pub matrix: Matrix3<f64>,
    /// Magnitude of the field, µT.
    pub field_ut: f64,
    /// Its part along gravity, µT.
    pub vertical_ut: f64,
    /// What is added to the gyro's rates: bias, rad/s, and gains and axes times the rate.
    pub gyro: SVector<f64, GYRO>,
    /// By how much the magnetometer is later than the gyro, s.
    pub delay_s: f64,
    /// The zero error of the specific force, in parts of gravity and along the direction down that it shows.
    pub zero: Vector3<f64>,
    /// By which part tilts are larger than shown: a board beside the axis that it rocks about is accelerated as it tilts.
    pub tilt: f64,
}

impl State {
    /// The corrected reading, µT.
    pub fn corrected(&self, measured_ut: &Vector3<f64>) -> Vector3<f64> {
        self.matrix * (measured_ut - self.offset_ut)
    }

    /// The direction of gravity without the accelerometer's zero error.
    pub fn down(&self, shown: &Vector3<f64>) -> Vector3<f64> {
        (shown - self.zero).normalize()
    }

    /// The matrix to the axes in which the accelerometer, with its zero error, shows gravity at the mean attitude: a heading takes gravity as
    /// the accelerometer shows it.
    pub fn matrix_as_shown(&self, mean_down: &Vector3<f64>) -> Matrix3<f64> {
        match Rotation3::rotation_between(&self.down(mean_down), mean_down) {
            Some(turn) => turn * self.matrix,
            None => self.matrix,
        }
    }

    /// The gyro's rate without its errors, rad/s.
    pub fn rate(&self, rate: &Vector3<f64>) -> Vector3<f64> {
        let bias = Vector3::new(self.gyro[0], self.gyro[1], self.gyro[2]);
        let gains = Matrix3::from_fn(|from, by| self.gyro[3 + 3 * by + from]);
        rate + bias + gains * rate
    }

    /// After a step of its parameters.
    pub fn stepped(&self, step: &[f64]) -> State {
        let vector = |at: usize| Vector3::new(step[at], step[at + 1], step[at + 2]);
        let e = Matrix3::from_fn(|i, j| step[MATRIX + 3 * i + j]);
        State {
            offset_ut: self.offset_ut + vector(OFFSET),
            matrix: self.matrix + e * self.matrix,
            field_ut: self.field_ut + step[FIELD],
            vertical_ut: self.vertical_ut + step[VERTICAL],
            gyro: self.gyro + SVector::<f64, GYRO>::from_fn(|i, _| step[RATE + i]),
            delay_s: self.delay_s + step[DELAY],
            zero: self.zero + vector(ZERO),
            tilt: self.tilt + step[TILT],
        }
    }
}
