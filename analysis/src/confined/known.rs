//! What is known before the log: how magnetometers and gyros are, an earlier calibration, the field of the place.

use crate::base::axes;
use crate::base::earlier::EarlierCalibration;
use crate::base::term::{COLUMNS, Matrix};
use crate::confined::log::Log;
use crate::confined::state::{
    ATTITUDE_DELAY, DELAY, FIELD, HARMONICS, LEAN, MATRIX, OFFSET, RATE, State, TILT, VERTICAL, YAW,
    YAW_ERROR, ZERO, effect_at,
};
use nalgebra::{DMatrix, Matrix3, SMatrix, SVector};

/// Gains of the axes next to their mean, and angles between axes (rad): factory trims are within 5 %, soft iron of a vehicle within as much
/// again.
const GAIN: f64 = 0.1;
const SKEW: f64 = 0.05;
/// Between the axes of magnetometer and accelerometer, rad: a mast or a bracket is mounted to some 6°.
const MOUNTING: f64 = 0.1;
/// Offsets, in multiples of the field.
const OFFSET_FIELDS: f64 = 7.0;
/// Where no field is given its magnitude is that of the log: the mean gain is one by definition.
const SCALE_BY_DEFINITION: f64 = 1e-4;
/// A field that is given, in parts: the world magnetic model and the rocks of a place (WMM2025 report: 138 nT globally, a multiple of it over
/// magnetic rock).
const FIELD_GIVEN: f64 = 0.005;
/// A dip that is given, rad: the model's 0.2° (WMM2025 report), and the accelerometer's zero error of as much again and more.
const DIP_GIVEN: f64 = 0.015;
/// A gyro's zero error, rad/s (3°/s: datasheets of MEMS gyros), its gains and axes, and a magnetometer's lateness, s.
const RATE_BIAS: f64 = 0.05;
const RATE_GAIN: f64 = 0.03;
const LATE_S: f64 = 0.1;
/// An accelerometer's zero error, in parts of gravity (datasheets of MEMS accelerometers: 20 to 80 mg).
const ZERO_G: f64 = 0.03;
/// A board at 1 m from the axis of a rock of 4 s is accelerated by a quarter of what it tilts: nearer and slower ones by less.
const TILT_SHOWN: f64 = 0.1;

/// Between the axes of an autopilot's attitude and those of its accelerometer, rad: the level that a user has set.
const LEAN_RAD: f64 = 0.03;
/// The yaw of an autopilot counts from true north, but for this, rad; from anywhere where no declination is known.
const YAW_GIVEN: f64 = 0.1;
const YAW_ANY: f64 = 1.0;
/// The offset that an effect makes at the rms of its column, in fields.
const EFFECT_FIELDS: f64 = 0.5;

/// What is known before the log.
#[derive(Debug, Clone, Default)]
pub struct Before {
    /// The magnitude of the field, µT, where it is given.
    pub field_ut: Option<f64>,
    /// Its dip, degrees, where it is given.
    pub dip_deg: Option<f64>,
    /// The declination, degrees, where the log tells its place.
    pub declination_deg: Option<f64>,
    /// An earlier calibration.
    pub prior: Option<EarlierCalibration>,
}

impl Before {
    /// As information about the parameters at this state, where the first state is `start` and the errors of a logged yaw have these
    /// sizes; the shown direction down is wrong by `down_error`, rad² of one axis, and this share of the tilt that the accelerometer
    /// shows is the board's own.
    pub fn matrix(
        &self,
        start: &State,
        state: &State,
        log: &Log,
        yaw_rad: [f64; 2],
        down_error: f64,
        tilt_share: f64,
    ) -> Matrix {
        let mut known = Matrix::new(state.parameters());
        let mut add = |parts: &[(usize, f64)], departs: f64, spread: f64| {
            let mut row = [0.0; COLUMNS];
            parts.iter().for_each(|(at, value)| row[*at] = value / spread);
            known.push(&row, departs / spread);
        };
        let size = state.field_ut.abs().max(1.0);
        for axis in 0..3 {
            add(&[(OFFSET + axis, 1.0)], state.offset_ut[axis], OFFSET_FIELDS * size);
        }
        let departure = match start.matrix.try_inverse() {
            Some(inverse) => state.matrix * inverse - Matrix3::identity(),
            None => Matrix3::zeros(),
        };
        // A sum of entries of the departure, and how it follows E: the departure moves by E · (1 + departure).
        let mut of_matrix = |weights: Matrix3<f64>, spread: f64| {
            let follows = weights * (Matrix3::identity() + departure).transpose();
            let parts: Vec<(usize, f64)> =
                (0..9).map(|at| (MATRIX + at, follows[(at / 3, at % 3)])).collect();
            add(&parts, weights.dot(&departure), spread);
        };
        let scale = if self.field_ut.is_some() { GAIN } else { SCALE_BY_DEFINITION };
        let mean = Matrix3::identity() / 3.0;
        of_matrix(mean, scale);
        for i in 0..3 {
            let at = |i: usize, j: usize| Matrix3::from_fn(|k, l| f64::from(u8::from((k, l) == (i, j))));
            let j = (i + 1) % 3;
            of_matrix(at(i, i) - mean, GAIN);
            of_matrix(at(i, j) + at(j, i), 2.0 * SKEW);
            of_matrix(0.5 * (at(i, j) - at(j, i)), MOUNTING);
        }
        match self.field_ut {
            Some(field_ut) => add(&[(FIELD, 1.0)], state.field_ut - field_ut, FIELD_GIVEN * field_ut),
            None => add(&[(FIELD, 1.0)], state.field_ut - start.field_ut, 0.3 * start.field_ut),
        }
        match self.dip_deg {
            Some(dip_deg) => {
                let (sine, cosine) = dip_deg.to_radians().sin_cos();
                let departs = state.vertical_ut - sine * state.field_ut;
                // Along a direction that is wrong by an angle the field is smaller by the cosine of it.
                let smaller = state.vertical_ut.abs() * down_error.min(1.0);
                let spread = (DIP_GIVEN * state.field_ut * cosine.abs().max(0.1)).hypot(smaller);
                add(&[(VERTICAL, 1.0), (FIELD, -sine)], departs, spread);
            }
            None => add(&[(VERTICAL, 1.0)], state.vertical_ut, size),
        }
        for i in 0..3 {
            add(&[(RATE + i, 1.0)], state.gyro[i], RATE_BIAS);
        }
        for i in 3..12 {
            add(&[(RATE + i, 1.0)], state.gyro[i], RATE_GAIN);
        }
        add(&[(DELAY, 1.0)], state.delay_s, LATE_S);
        for axis in 0..3 {
            add(&[(ZERO + axis, 1.0)], state.zero[axis], ZERO_G);
        }
        // A vehicle that is accelerated shows an error that goes along with its tilt: a hovering drone shows none of it.
        add(&[(TILT, 1.0)], state.tilt, (TILT_SHOWN * tilt_share).hypot(1.0 - tilt_share));
        if state.parameters() > YAW {
            let yaw = state.yaw.unwrap_or(0.0);
            let (about, spread) = match self.declination_deg.filter(|_| log.from_north) {
                Some(declination_deg) => (declination_deg.to_radians(), YAW_GIVEN),
                None => (start.yaw.unwrap_or(0.0), YAW_ANY),
            };
            add(&[(YAW, 1.0)], (yaw - about).sin().atan2((yaw - about).cos()), spread);
            (0..3).for_each(|i| add(&[(LEAN + i, 1.0)], state.lean[i], LEAN_RAD));
            add(&[(ATTITUDE_DELAY, 1.0)], state.attitude_delay_s, LATE_S);
            (0..HARMONICS).for_each(|k| add(&[(YAW_ERROR + k, 1.0)], state.yaw_error[k], yaw_rad[0]));
        }
        for (at, ((effect, yaw), square)) in state.effects.iter().zip(&log.effects).enumerate() {
            let rms = square.sqrt().max(1e-9);
            for i in 0..3 {
                add(&[(effect_at(at) + i, 1.0)], effect[i], EFFECT_FIELDS * size / rms);
                add(&[(effect_at(at) + 3 + i, 1.0)], yaw[i], yaw_rad[1] / rms);
            }
        }
        if let Some(prior) = &self.prior {
            earlier(&mut known, prior, self.field_ut, state);
        }
        known
    }
}

/// Which sensor would have to be further from what such sensors are than this many standard deviations, and why; `None` where none is. A
/// reversed axis and another unit look like this.
pub fn implausible(state: &State, most: f64) -> Option<String> {
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let gyro = state.gyro.as_slice();
    let (bias, gain) = (largest(&gyro[..3]), largest(&gyro[3..]));
    let zero = largest(state.zero.as_slice());
    let said = [
        (bias / RATE_BIAS, format!("the gyro would have a bias of {bias:.2} rad/s")),
        (gain / RATE_GAIN, format!("the gyro's gains and axes would be off by {:.0} %", 100.0 * gain)),
        (
            state.delay_s.abs() / LATE_S,
            format!("magnetometer and gyro would be {:.2} s apart", state.delay_s.abs()),
        ),
        (zero / ZERO_G, format!("the accelerometer would have a bias of {:.1} m/s²", 9.81 * zero)),
    ];
    let [first, rest @ ..] = said;
    let (times, words) = rest.into_iter().fold(first, |one, other| if other.0 > one.0 { other } else { one });
    (times > most).then_some(words)
}

/// The same of a logged attitude that is so many seconds early.
pub fn implausible_attitude(state: &State, early_s: f64, most: f64) -> Option<String> {
    let (lean, late_s) = (state.lean.amax(), early_s.abs());
    if lean > most * LEAN_RAD {
        return Some(format!("it would be turned by {:.0}° from the accelerometer", lean.to_degrees()));
    }
    (late_s > most * LATE_S).then(|| format!("it would be {late_s:.2} s apart from the magnetometer"))
}

/// Adds an earlier calibration's information about offset and triangle.
fn earlier(known: &mut Matrix, prior: &EarlierCalibration, field_ut: Option<f64>, state: &State) {
    let earlier = prior.earlier(field_ut);
    let Some((triangle, to_triangle)) = triangle_of(&state.matrix) else { return };
    let follows = nine_follow(&to_triangle);
    let departs = SVector::<f64, 9>::from_fn(|i, _| {
        if i < 3 {
            state.offset_ut[i] - earlier.parameters[i]
        } else {
            triangle[i - 3] - earlier.parameters[i]
        }
    });
    let information = SMatrix::<f64, 9, 9>::from_fn(|i, j| earlier.information[i][j]);
    let weight = follows.transpose() * information * follows;
    let pull = follows.transpose() * information * departs;
    for i in 0..12 {
        known.pull(i, pull[i]);
        (i..12).for_each(|j| known.inform(i, j, weight[(i, j)]));
    }
    known.depart(departs.dot(&(information * departs)));
}

/// The covariance of offset and triangle, of that of all parameters at a state with this matrix.
pub fn triangle_covariance(matrix: &Matrix3<f64>, covariance: &DMatrix<f64>) -> Option<[[f64; 9]; 9]> {
    let follows = nine_follow(&triangle_of(matrix)?.1);
    let nine = follows * covariance.fixed_view::<12, 12>(OFFSET, OFFSET) * follows.transpose();
    Some(std::array::from_fn(|i| std::array::from_fn(|j| nine[(i, j)])))
}

/// How offset and triangle follow offset and `E`.
fn nine_follow(to_triangle: &SMatrix<f64, 6, 9>) -> SMatrix<f64, 9, 12> {
    SMatrix::<f64, 9, 12>::from_fn(|row, column| match (row < 3, column < 3) {
        (true, true) => f64::from(u8::from(row == column)),
        (false, false) => to_triangle[(row - 3, column - 3)],
        _ => 0.0,
    })
}

/// The upper triangle `T` of `matrix = R · T` by rows, and how it follows `E` in `(1 + E) · matrix`.
fn triangle_of(matrix: &Matrix3<f64>) -> Option<([f64; 6], SMatrix<f64, 6, 9>)> {
    let rows = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    let triangle = axes::triangle_of(&rows)?;
    let triangle = Matrix3::from_fn(|i, j| triangle[i][j]);
    let rotation = matrix * triangle.try_inverse()?;
    const PLACES: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
    let mut follows = SMatrix::<f64, 6, 9>::zeros();
    for column in 0..9 {
        let e = Matrix3::from_fn(|i, j| f64::from(u8::from(3 * i + j == column)));
        // dT T⁻¹ is the upper triangle whose symmetric part is that of Rᵀ E R.
        let turned = rotation.transpose() * (e + e.transpose()) * rotation;
        let upper = Matrix3::from_fn(|i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => turned[(i, j)],
            std::cmp::Ordering::Equal => 0.5 * turned[(i, j)],
            std::cmp::Ordering::Greater => 0.0,
        });
        let change = upper * triangle;
        PLACES.iter().enumerate().for_each(|(row, place)| follows[(row, column)] = change[*place]);
    }
    Some((PLACES.map(|place| triangle[place]), follows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_triangle_follows_the_matrix_as_it_says() {
        let matrix = Matrix3::new(1.1, 0.02, -0.05, 0.1, 0.95, 0.03, -0.2, 0.04, 1.02);
        let (before, follows) = triangle_of(&matrix).expect("a triangle");
        let e = Matrix3::from_fn(|i, j| 1e-6 * (1.0 + i as f64 - 2.0 * j as f64));
        let (after, _) = triangle_of(&(matrix + e * matrix)).expect("a triangle");
        let expected = follows * SVector::<f64, 9>::from_fn(|at, _| e[(at / 3, at % 3)]);
        for (i, expected) in expected.iter().enumerate() {
            assert!(
                (after[i] - before[i] - expected).abs() < 1e-10,
                "{i}: {} {expected}",
                after[i] - before[i]
            );
        }
    }
}
