//! Direction of gravity from accelerometer and gyro together.
//!
//! An accelerometer measures gravity and the board's own acceleration alike: in a hand the direction is off by 4 to 40 degrees rms. The
//! gyro tells how the board turned meanwhile, so the specific forces of some seconds can be brought into one frame, where the own
//! accelerations average out (a hand comes back, its velocity is bounded) and gravity stays. The average is taken over the past and the
//! future alike, so that a constant error of the gyro cancels to first order. The idea is that of the inclination correction of VQF (Laidig and Seel,
//! "VQF: Highly accurate IMU orientation estimation", Information Fusion 2023). On ten recordings with optical truth it leaves
//! 0.3 to 4.4 degrees rms where the accelerometer alone leaves 3.8 to 40.

use crate::calibration::{Accelerometer, STANDARD_GRAVITY_MPS2};
use crate::samples::accelerometer;
use crate::samples::detected::Estimate;
use crate::samples::series::median;
use crate::table::{Follows, QuietForce, Table};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Time constant of the average, s: the accelerations of a hand are shorter, and what the gyro's drift adds to it is small.
const TIME_CONSTANT_S: f64 = 2.0;
/// Longer steps are gaps, across which nobody knows how the board turned, s.
const MAX_STEP_S: f64 = 0.5;
/// A larger turn between two rows is not integrated well, rad.
const MAX_TURN_RAD: f64 = 0.7;
/// Fewer rows say nothing, as in [`crate::base::alignment`].
const MIN_ROWS: usize = 20;
/// At most so many rows are marked with what they follow: neighbours follow the same.
const MAX_MARKS: usize = 50_000;
/// Rows that windows are held of at a time.
const PIECE_ROWS: usize = 1 << 17;
/// What lies further away than this is forgotten, s: the average has faded to 2e-9.
const FADED_S: f64 = 20.0 * TIME_CONSTANT_S;
/// The first step comes within a twentieth of an error of 5 °/s, the second to a four-hundredth.
const GAUSS_NEWTON_STEPS: usize = 2;
/// Zero errors of gyros before a log says more, rad/s: data sheets have 1 °/s (LSM6DSO), 3 (BMI160), 5 (ICM-20948).
const GYRO_ZERO_RADPS: f64 = 0.05;
/// Averages that a right gyro brings into one frame keep the length of gravity; turned by a wrong one they cancel. Right gyros of ten recordings
/// leave 99.5 % and more in the median, gyros with swapped axes or signs 40 to 92 %.
const MIN_LENGTH_KEPT: f64 = 0.97;

/// Specific force of a table, m/s², calibrated where it needs it, without the board's own acceleration where the gyro tells it; else as the accelerometer has it.
pub fn of_table<'t>(table: &'t Table<'_>) -> Option<[&'t [f64]; 3]> {
    match quiet(table) {
        Some(quiet) => Some(quiet.mps2.each_ref().map(Vec::as_slice)),
        None => corrected(table),
    }
}

/// The same where the gyro tells the board's own acceleration.
pub fn quiet<'t>(table: &'t Table<'_>) -> Option<&'t QuietForce> {
    let make = || quiet_force(table.time_s?, corrected(table)?, table.gyro_radps?);
    table.derived.quiet_force.get_or_init(make).as_ref()
}

/// Second moment of the zero error that the specific force of a table is still expected to have, (m/s²)².
pub fn zero_error_square(table: &Table<'_>) -> Matrix3<f64> {
    *table
        .derived
        .zero_error_square
        .get_or_init(|| corrected(table).map_or_else(Matrix3::zeros, accelerometer::zero_error_square))
}

/// The calibration of the accelerometer that a table shows, where there is something to correct.
pub fn accelerometer(table: &Table<'_>) -> Option<Accelerometer> {
    *table.derived.accelerometer.get_or_init(|| accelerometer::accelerometer(table))
}

/// Specific force of a table, m/s², as the accelerometer has it once it is calibrated.
fn corrected<'t>(table: &'t Table<'_>) -> Option<[&'t [f64]; 3]> {
    let corrected = table.derived.corrected_force_mps2.get_or_init(|| {
        let (own, axes) = (accelerometer(table)?, table.accel_mps2?);
        let mut out: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(table.rows()));
        for row in 0..table.rows() {
            let force = own.apply(axes.map(|axis| axis[row]));
            out.iter_mut().zip(force).for_each(|(axis, value)| axis.push(value));
        }
        Some(out)
    });
    corrected.as_ref().map(|axes| axes.each_ref().map(Vec::as_slice)).or(table.accel_mps2)
}

/// `None` where the gyro does not turn as the accelerometer does.
fn quiet_force(time_s: &[f64], accel_mps2: [&[f64]; 3], gyro_radps: [&[f64]; 3]) -> Option<QuietForce> {
    let rows = time_s.len();
    let mut lengths: Vec<f64> =
        (0..rows).filter_map(|row| Some(vector(&accel_mps2, row)?.norm())).filter(|n| *n > 0.0).collect();
    if lengths.len() < MIN_ROWS {
        return None;
    }
    // Shaking makes the readings longer than gravity, and no scale error is that large.
    let gravity_mps2 = median(&mut lengths).min(STANDARD_GRAVITY_MPS2);
    drop(lengths);
    let log = Log { time_s, accel_mps2, gyro_radps };
    let every = rows.div_ceil(MAX_MARKS).max(1);
    let gyro_zero = (0..GAUSS_NEWTON_STEPS).fold(Vector3::zeros(), |zero, _| log.gyro_zero(zero, every).0);
    let (_, gyro_zero_covariance) = log.gyro_zero(gyro_zero, every);
    let mut quiet = QuietForce {
        mps2: std::array::from_fn(|_| Vec::with_capacity(rows)),
        follows: Vec::with_capacity(rows.div_ceil(every)),
        every,
        gyro_zero_covariance,
    };
    let mut kept = Vec::with_capacity(rows);
    for (windows, own) in log.pieces(gyro_zero, every) {
        for row in own {
            let ((sum, weight), frame) = (windows.sums[row], windows.frames[row]);
            let length = sum.norm() / weight;
            let is_known = length > 0.0 && length.is_finite();
            if is_known {
                kept.push(length / gravity_mps2);
            }
            let force = match is_known {
                true => frame.inverse() * sum.normalize() * gravity_mps2,
                false => Vector3::from_element(f64::NAN),
            };
            quiet.mps2.iter_mut().zip(&force).for_each(|(axis, value)| axis.push(*value));
            if let Some(sums) = windows.mark(row) {
                let back = matrix(&frame).transpose();
                let scale = if sum.norm() > 0.0 { gravity_mps2 / sum.norm() } else { 0.0 };
                let follows = Follows {
                    accel: back * sums.frames * scale,
                    gyro_s: back * sums.drifts_s / weight.max(1.0),
                };
                quiet.follows.push(follows);
            }
        }
    }
    (median(&mut kept) >= MIN_LENGTH_KEPT).then_some(quiet)
}

/// What the average is made of.
#[derive(Clone, Copy)]
struct Log<'a> {
    time_s: &'a [f64],
    accel_mps2: [&'a [f64]; 3],
    gyro_radps: [&'a [f64]; 3],
}

impl<'a> Log<'a> {
    /// The log in pieces, each with the windows of its rows and their range in them: on a long log the windows would be the largest thing
    /// in memory. A piece begins and ends so far outside of its own rows that what lies beyond has faded.
    fn pieces(
        self,
        gyro_zero_radps: Vector3<f64>,
        every: usize,
    ) -> impl Iterator<Item = (Windows<'a>, std::ops::Range<usize>)> {
        let rows = self.time_s.len();
        let length = PIECE_ROWS.next_multiple_of(every);
        (0..rows).step_by(length).map(move |begin| {
            let end = (begin + length).min(rows);
            let (first_s, last_s) = (self.time_s[begin] - FADED_S, self.time_s[end - 1] + FADED_S);
            let mut from = begin;
            while from > 0 && self.time_s[from - 1] >= first_s {
                from -= 1;
            }
            let mut to = end;
            while to < rows && self.time_s[to] <= last_s {
                to += 1;
            }
            let part = |axes: [&'a [f64]; 3]| axes.map(|axis| &axis[from..to]);
            let (accel, gyro) = (part(self.accel_mps2), part(self.gyro_radps));
            let every = Every { rows: every, first: (every - from % every) % every };
            let windows = Windows::new(&self.time_s[from..to], accel, gyro, gyro_zero_radps, every);
            (windows, begin - from..end - from)
        })
    }

    /// The gyro's whole zero error, rad/s, and its covariance: what makes the specific forces of each window alike in its frame, and what
    /// data sheets say. A rate that is wrong by `w` turns a row by the integral `B` of the rotations from the window's middle on, so that
    /// its force differs from the mean by `−[g]× (B − mean B) w`.
    fn gyro_zero(self, taken_off_radps: Vector3<f64>, every: usize) -> (Vector3<f64>, Matrix3<f64>) {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        let mut marks = Vec::new();
        for (windows, own) in self.pieces(taken_off_radps, every) {
            for row in own {
                let Some(mark) = windows.mark(row) else { continue };
                let (sum, weight) = windows.sums[row];
                let Some(force) = vector(&windows.accel_mps2, row) else {
                    marks.push(None);
                    continue;
                };
                let mean = sum / weight;
                let column = mean.cross_matrix() * mark.drifts_s / weight;
                let off = windows.frames[row] * force - mean + column * taken_off_radps;
                marks.push((weight > 1.0).then_some((column, off)));
            }
        }
        for (column, off) in marks.iter().flatten() {
            normal += column.transpose() * column;
            right += column.transpose() * off;
        }
        let prior = Vector3::from_element(1.0 / (GYRO_ZERO_RADPS * GYRO_ZERO_RADPS));
        let mut estimate = Estimate::new(normal, right, prior, marks.len());
        for (mark, (column, off)) in marks.iter().enumerate().filter_map(|(mark, one)| Some((mark, (*one)?)))
        {
            for axis in 0..3 {
                estimate.add(mark, column.row(axis).transpose(), off[axis]);
            }
        }
        estimate.posterior()
    }
}

/// Every so many rows from a first one on.
#[derive(Clone, Copy)]
struct Every {
    rows: usize,
    first: usize,
}

impl Every {
    /// The number of the mark of a row, where it has one.
    fn mark(self, row: usize) -> Option<usize> {
        let past = row.checked_sub(self.first)?;
        past.is_multiple_of(self.rows).then_some(past / self.rows)
    }
}

fn vector(axes: &[&[f64]; 3], row: usize) -> Option<Vector3<f64>> {
    let vector = Vector3::from_fn(|axis, _| axes[axis][row]);
    vector.iter().all(|value| value.is_finite()).then_some(vector)
}

fn matrix(frame: &UnitQuaternion<f64>) -> Matrix3<f64> {
    frame.to_rotation_matrix().into_inner()
}

/// Sums over the rows near each row, those nearer with more weight, in the frame in which its stretch begins.
struct Windows<'a> {
    accel_mps2: [&'a [f64]; 3],
    /// From the axes of each row to the frame of its stretch.
    frames: Vec<UnitQuaternion<f64>>,
    /// Specific forces, and the weights.
    sums: Vec<(Vector3<f64>, f64)>,
    /// At every so many rows.
    marks: Vec<Mark>,
    every: Every,
}

#[derive(Debug, Clone, Copy)]
struct Mark {
    /// Of the rotations to the frame: what becomes of a constant in body axes.
    frames: Matrix3<f64>,
    /// Of the integrals of these rotations over time from the row on, s: what becomes of a constant rate.
    drifts_s: Matrix3<f64>,
}

/// Running sums of one direction of time.
struct Running {
    force: Vector3<f64>,
    weight: f64,
    mark: Mark,
}

impl Running {
    fn new() -> Self {
        let none = Mark { frames: Matrix3::zeros(), drifts_s: Matrix3::zeros() };
        Running { force: Vector3::zeros(), weight: 0.0, mark: none }
    }

    /// Goes on to a row; `passed_s` is the integral of the rotation from the last one to it.
    fn fade(&mut self, keep: f64, passed_s: &Matrix3<f64>) {
        self.mark.drifts_s = (self.mark.drifts_s - passed_s * self.weight) * keep;
        self.mark.frames *= keep;
        self.force *= keep;
        self.weight *= keep;
    }

    fn add(&mut self, force: Option<Vector3<f64>>, frame: &Matrix3<f64>) {
        if let Some(force) = force {
            self.force += frame * force;
            self.weight += 1.0;
            self.mark.frames += frame;
        }
    }
}

impl<'a> Windows<'a> {
    fn new(
        time_s: &[f64],
        accel_mps2: [&'a [f64]; 3],
        gyro_radps: [&[f64]; 3],
        gyro_zero_radps: Vector3<f64>,
        every: Every,
    ) -> Self {
        let rows = time_s.len();
        // How the board turned from the row before; `None` begins a new stretch.
        let turn = |row: usize| {
            let step_s = time_s[row] - time_s[row - 1];
            let rate = 0.5 * (vector(&gyro_radps, row - 1)? + vector(&gyro_radps, row)?) - gyro_zero_radps;
            let turn = rate * step_s;
            (step_s <= MAX_STEP_S && turn.norm() <= MAX_TURN_RAD)
                .then(|| UnitQuaternion::from_scaled_axis(turn))
        };
        let mut frames = vec![UnitQuaternion::identity(); rows];
        let mut begins = vec![true; rows];
        for row in 1..rows {
            if let Some(turn) = turn(row) {
                frames[row] = frames[row - 1] * turn;
                begins[row] = false;
            }
        }
        // What is kept from one row to the next, and the integral of the rotation between them.
        let step = |row: usize, before: &Matrix3<f64>, after: &Matrix3<f64>| {
            let step_s = time_s[row] - time_s[row - 1];
            let keep = if begins[row] { 0.0 } else { (-step_s / TIME_CONSTANT_S).exp() };
            (keep, (before + after) * (0.5 * step_s))
        };
        let mut sums = Vec::with_capacity(rows);
        let mut marks = Vec::with_capacity(rows.div_ceil(every.rows));
        let mut past = Running::new();
        let mut last = Matrix3::identity();
        for row in 0..rows {
            let frame = matrix(&frames[row]);
            if row > 0 {
                let (keep, passed_s) = step(row, &last, &frame);
                past.fade(keep, &passed_s);
            }
            past.add(vector(&accel_mps2, row), &frame);
            sums.push((past.force, past.weight));
            if every.mark(row).is_some() {
                marks.push(past.mark);
            }
            last = frame;
        }
        let mut future = Running::new();
        for row in (0..rows).rev() {
            let frame = matrix(&frames[row]);
            if row + 1 < rows {
                let (keep, passed_s) = step(row + 1, &last, &frame);
                future.fade(keep, &-passed_s);
            }
            sums[row].0 += future.force;
            sums[row].1 += future.weight;
            if let Some(mark) = every.mark(row) {
                marks[mark].frames += future.mark.frames;
                marks[mark].drifts_s += future.mark.drifts_s;
            }
            future.add(vector(&accel_mps2, row), &frame);
            last = frame;
        }
        Windows { accel_mps2, frames, sums, marks, every }
    }

    /// The mark of a row, where it has one.
    fn mark(&self, row: usize) -> Option<&Mark> {
        self.marks.get(self.every.mark(row)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Axes = [Vec<f64>; 3];
    type Shaken = (Vec<f64>, Axes, Axes, Vec<Vector3<f64>>);

    const ROWS: usize = 4000;
    const STEP_S: f64 = 0.02;
    const EACH: Every = Every { rows: 1, first: 0 };

    /// A board that turns about changing axes while a hand shakes it by some 4 m/s²: time, specific force, rate, and true down.
    fn shaken() -> Shaken {
        let mut attitude = UnitQuaternion::identity();
        let (mut time, mut down) = (Vec::new(), Vec::new());
        let (mut accel, mut gyro): (Axes, Axes) = Default::default();
        for row in 0..ROWS {
            let t = row as f64 * STEP_S;
            let rate = Vector3::new((0.7 * t).sin(), 1.2 * (0.43 * t).cos(), 0.8 * (0.31 * t + 1.0).sin());
            let shake = Vector3::new((7.0 * t).sin(), (8.3 * t).cos(), (5.1 * t).sin()) * 4.0;
            let own_down = attitude.inverse() * Vector3::z();
            let force = attitude.inverse() * shake - own_down * 9.81;
            time.push(t);
            down.push(own_down);
            (0..3).for_each(|axis| {
                accel[axis].push(force[axis]);
                gyro[axis].push(rate[axis] + 0.01);
            });
            attitude *= UnitQuaternion::from_scaled_axis(rate * STEP_S);
        }
        (time, accel, gyro, down)
    }

    fn rms_deg(force: &[Vec<f64>; 3], down: &[Vector3<f64>]) -> f64 {
        let squares = down.iter().enumerate().map(|(row, down)| {
            let own = -Vector3::from_fn(|axis, _| force[axis][row]);
            own.angle(down).powi(2)
        });
        (squares.sum::<f64>() / down.len() as f64).sqrt().to_degrees()
    }

    fn slices(axes: &[Vec<f64>; 3]) -> [&[f64]; 3] {
        axes.each_ref().map(Vec::as_slice)
    }

    #[test]
    fn what_a_hand_shakes_averages_out() {
        let (time, accel, gyro, down) = shaken();
        let quiet = quiet_force(&time, slices(&accel), slices(&gyro)).expect("a right gyro").mps2;
        let (raw, fused) = (rms_deg(&accel, &down), rms_deg(&quiet, &down));
        assert!(raw > 15.0 && fused < 1.5, "{raw} {fused}");
    }

    #[test]
    fn a_wrong_gyro_is_not_believed() {
        let (time, accel, gyro, _) = shaken();
        let [x, y, z] = slices(&gyro);
        assert!(quiet_force(&time, slices(&accel), [y, x, z]).is_none());
        let backwards = gyro.clone().map(|axis| axis.iter().map(|value| -value).collect::<Vec<f64>>());
        assert!(quiet_force(&time, slices(&accel), slices(&backwards)).is_none());
    }

    #[test]
    fn a_gap_and_missing_cells_part_the_stretches_and_lose_nothing_else() {
        let (mut time, mut accel, mut gyro, down) = shaken();
        time.iter_mut().skip(1500).for_each(|t| *t += 30.0);
        gyro[1][2500] = f64::NAN;
        accel[0][700] = f64::NAN;
        let quiet = quiet_force(&time, slices(&accel), slices(&gyro)).expect("a right gyro").mps2;
        assert!(quiet.iter().flatten().all(|value| value.is_finite()));
        assert!(rms_deg(&quiet, &down) < 2.5, "{}", rms_deg(&quiet, &down));
    }

    #[test]
    fn a_zero_error_is_followed_through_the_average() {
        let (time, accel, gyro, _) = shaken();
        let windows = |accel: &Axes| {
            let windows = Windows::new(&time, slices(accel), slices(&gyro), Vector3::zeros(), EACH);
            let quiet =
                |row: usize| windows.frames[row].inverse() * windows.sums[row].0 / windows.sums[row].1;
            let force: Vec<Vector3<f64>> = (0..ROWS).map(quiet).collect();
            let follows = |row: usize| matrix(&windows.frames[row]).transpose() * windows.marks[row].frames;
            (force, (0..ROWS).map(|row| follows(row) / windows.sums[row].1).collect::<Vec<_>>())
        };
        let (plain, follows) = windows(&accel);
        let zero = Vector3::new(0.03, -0.02, 0.04);
        let mut off = accel.clone();
        (0..3).for_each(|axis| off[axis].iter_mut().for_each(|value| *value += zero[axis]));
        let (moved, _) = windows(&off);
        for row in (0..ROWS).step_by(97) {
            let (found, expected) = (moved[row] - plain[row], follows[row] * zero);
            assert!((found - expected).norm() < 1e-9, "row {row}: {found} against {expected}");
            assert!(expected.norm() < zero.norm());
        }
    }

    #[test]
    fn a_gyro_zero_error_is_found_and_followed() {
        let (time, accel, gyro, down) = shaken();
        let still: Axes = std::array::from_fn(|axis| down.iter().map(|down| -9.81 * down[axis]).collect());
        let zero = Vector3::new(0.06, -0.04, 0.05);
        let mut off = gyro.clone();
        (0..3).for_each(|axis| off[axis].iter_mut().for_each(|value| *value += zero[axis] - 0.01));
        let zero_of = |accel: &Axes| {
            let log = Log { time_s: &time, accel_mps2: slices(accel), gyro_radps: slices(&off) };
            log.gyro_zero(Vector3::zeros(), 1)
        };
        let (found, covariance) = zero_of(&still);
        assert!((found - zero).norm() < 0.05 * zero.norm(), "{found}");
        assert!(covariance.trace().sqrt() < 0.01, "{covariance}");
        let (_, shaken) = zero_of(&accel);
        assert!(shaken.trace() > covariance.trace());
        // Where each row goes with an error that is left.
        let quiet = quiet_force(&time, slices(&still), slices(&off)).expect("a right gyro");
        // Half a step between two ways of integrating is all that is left.
        assert!(rms_deg(&quiet.mps2, &down) < 0.3, "{}", rms_deg(&quiet.mps2, &down));
        let left = Vector3::new(0.004, 0.002, -0.003);
        let at = |zero: Vector3<f64>, row: usize| {
            let windows = Windows::new(&time, slices(&still), slices(&off), zero, EACH);
            windows.frames[row].inverse() * windows.sums[row].0.normalize()
        };
        for row in (50..ROWS).step_by(797) {
            let force = at(zero, row);
            let (moved, follows) =
                (at(zero - left, row) - force, quiet.follows(row).expect("a row of the log"));
            let expected = (follows.gyro_s * left).cross(&force);
            assert!((moved - expected).norm() < 0.05 * left.norm(), "row {row}: {moved} against {expected}");
        }
    }

    #[test]
    fn nothing_is_made_of_nothing() {
        let none = [f64::NAN; 30];
        assert!(quiet_force(&[0.0; 30], [&none; 3], [&none; 3]).is_none());
        assert!(quiet_force(&[], [&[]; 3], [&[]; 3]).is_none());
    }
}
