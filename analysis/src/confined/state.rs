//! The parameters of the model, and a step of them.

use crate::base::term::COLUMNS;
use crate::base::windows::GYRO;
use crate::confined::log::{MOST_EFFECTS, Pose, Row};
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
/// Which part of the tilt that the accelerometer shows is to be added to the share that is taken as the board's own.
pub const TILT: usize = ZERO + 3;
/// Parameters of a log without attitude and effects.
const WITHOUT_ATTITUDE: usize = TILT + 1;
/// The direction of magnetic north in the world of the logged attitude, rad from its north.
pub const YAW: usize = WITHOUT_ATTITUDE;
/// First of the rotation (3, rad) between the axes of the logged attitude and those of the accelerometer.
pub const LEAN: usize = YAW + 1;
/// By how much the logged attitude is early, s.
pub const ATTITUDE_DELAY: usize = LEAN + 3;
/// First of the yaw errors that depend on the heading, rad: sine and cosine of once and twice the heading.
pub const YAW_ERROR: usize = ATTITUDE_DELAY + 1;
/// Number of these.
pub const HARMONICS: usize = 4;
const WITHOUT_EFFECTS: usize = YAW_ERROR + HARMONICS;
/// Parameters of an effect: its vector (3, µT per unit of its column), and the yaw errors (rad per unit) that a compass makes of it.
pub const OF_EFFECT: usize = 6;

/// First parameter of an effect.
pub const fn effect_at(effect: usize) -> usize {
    WITHOUT_EFFECTS + OF_EFFECT * effect
}

/// Values of the parameters.
#[derive(Debug, Clone, Default, PartialEq)]
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
    /// Which part of the shown tilt is to be added to the share taken as the board's own: a board next to the axis that it rocks about is
    /// accelerated as it tilts.
    pub tilt: f64,
    /// Direction of magnetic north in the world of the logged attitude; `None` without one.
    pub yaw: Option<f64>,
    /// From the axes of the logged attitude to those of the accelerometer, rad.
    pub lean: Vector3<f64>,
    /// By how much the logged attitude is early, s.
    pub attitude_delay_s: f64,
    /// Errors of the logged yaw that depend on the heading.
    pub yaw_error: [f64; HARMONICS],
    /// The effects, as many as the log has columns for: vector, and yaw errors with the sine and cosine of the heading and without.
    pub effects: Vec<(Vector3<f64>, Vector3<f64>)>,
}

/// What the logged attitude says of one sample, in the axes of the accelerometer.
#[derive(Debug, Clone, Copy)]
pub struct Predicted {
    /// Magnetic north, magnetic east, down.
    pub axes: [Vector3<f64>; 3],
    /// How magnetic east and down move with the attitude's delay, 1/s.
    pub per_s: [Vector3<f64>; 2],
    /// The yaw errors' shapes: sine and cosine of once and twice the heading.
    pub shapes: [f64; HARMONICS],
}

impl State {
    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        match (self.effects.len(), self.yaw) {
            (0, None) => WITHOUT_ATTITUDE,
            (effects, _) => effect_at(effects),
        }
    }

    /// The corrected reading, µT.
    pub fn corrected(&self, row: &Row) -> Vector3<f64> {
        let mut field = row.measured_ut - self.offset_ut;
        for ((effect, _), value) in self.effects.iter().zip(row.acts) {
            field -= effect * value;
        }
        self.matrix * field
    }

    /// How `along · v` follows offset, matrix and effects, `v` a corrected reading of this row.
    pub fn follow(&self, derivative: &mut [f64; COLUMNS], row: &Row, along: &Vector3<f64>, v: &Vector3<f64>) {
        let offset = -self.matrix.transpose() * along;
        derivative[OFFSET..OFFSET + 3].copy_from_slice(offset.as_slice());
        for i in 0..3 {
            for j in 0..3 {
                derivative[MATRIX + 3 * i + j] = along[i] * v[j];
            }
        }
        for (effect, value) in row.acts.iter().enumerate().take(self.effects.len()) {
            let at = effect_at(effect);
            (0..3).for_each(|axis| derivative[at + axis] = value * offset[axis]);
        }
    }

    /// What a pose says.
    pub fn predicted(&self, pose: &Pose, acts: &[f64; MOST_EFFECTS]) -> Predicted {
        let lean = Rotation3::new(self.lean);
        let now = pose.axes + self.attitude_delay_s * pose.per_s;
        let (sine, cosine) = pose.heading;
        let shapes = [sine, cosine, 2.0 * sine * cosine, cosine * cosine - sine * sine];
        let mut angle = self.yaw.unwrap_or(0.0);
        angle += self.yaw_error.iter().zip(shapes).map(|(error, shape)| error * shape).sum::<f64>();
        for ((_, error), value) in self.effects.iter().zip(acts) {
            angle += value * error.dot(&Vector3::new(sine, cosine, 1.0));
        }
        let (s, c) = angle.sin_cos();
        let column = |of: &Matrix3<f64>, at: usize| of.column(at).into_owned();
        let east = |of: &Matrix3<f64>| lean * (c * column(of, 1) - s * column(of, 0));
        let down = (lean * column(&now, 2)).normalize();
        let magnetic_east = east(&now).normalize();
        Predicted {
            axes: [magnetic_east.cross(&down), magnetic_east, down],
            per_s: [east(&pose.per_s), lean * column(&pose.per_s, 2)],
            shapes,
        }
    }

    /// How `along · v` follows the rotation and the delay of the attitude, with `per_s` the part of `along` that moves with the delay.
    pub fn follow_attitude(
        derivative: &mut [f64; COLUMNS],
        along: &Vector3<f64>,
        per_s: &Vector3<f64>,
        v: &Vector3<f64>,
    ) {
        derivative[LEAN..LEAN + 3].copy_from_slice(along.cross(v).as_slice());
        derivative[ATTITUDE_DELAY] = per_s.dot(v);
    }

    /// How the part of a horizontal field along magnetic east follows the errors of the yaw.
    pub fn follow_yaw(
        &self,
        derivative: &mut [f64; COLUMNS],
        predicted: &Predicted,
        acts: &[f64; MOST_EFFECTS],
        level_ut: f64,
    ) {
        derivative[YAW] = -level_ut;
        for (at, shape) in predicted.shapes.iter().enumerate() {
            derivative[YAW_ERROR + at] = -level_ut * shape;
        }
        let [sine, cosine, ..] = predicted.shapes;
        for (effect, value) in acts.iter().enumerate().take(self.effects.len()) {
            for (at, shape) in [sine, cosine, 1.0].into_iter().enumerate() {
                derivative[effect_at(effect) + 3 + at] = -level_ut * value * shape;
            }
        }
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
        let wide = self.parameters() > WITHOUT_ATTITUDE;
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
            yaw: self.yaw.map(|yaw| yaw + step[YAW]),
            lean: if wide { self.lean + vector(LEAN) } else { self.lean },
            attitude_delay_s: if wide { self.attitude_delay_s + step[ATTITUDE_DELAY] } else { 0.0 },
            yaw_error: match wide {
                true => std::array::from_fn(|at| self.yaw_error[at] + step[YAW_ERROR + at]),
                false => self.yaw_error,
            },
            effects: (self.effects.iter().enumerate())
                .map(|(at, (effect, yaw))| (effect + vector(effect_at(at)), yaw + vector(effect_at(at) + 3)))
                .collect(),
        }
    }
}
