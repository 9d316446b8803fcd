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
use crate::samples::series::median;
use crate::table::Table;
use nalgebra::{UnitQuaternion, Vector3};

/// Time constant of the average, s: the accelerations of a hand are shorter, and what the gyro's drift adds to it is small.
const TIME_CONSTANT_S: f64 = 2.0;
/// Longer steps are gaps, across which nobody knows how the board turned, s.
const MAX_STEP_S: f64 = 0.5;
/// A larger turn between two rows is not integrated well, rad.
const MAX_TURN_RAD: f64 = 0.7;
/// Fewer rows say nothing, as in [`crate::base::alignment`].
const MIN_ROWS: usize = 20;
/// Averages that a right gyro brings into one frame keep the length of gravity; turned by a wrong one they cancel. Right gyros of ten recordings
/// leave 99.5 % and more in the median, gyros with swapped axes or signs 40 to 92 %.
const MIN_LENGTH_KEPT: f64 = 0.97;

/// Specific force of a table, m/s², calibrated where it needs it, without the board's own acceleration where the gyro tells it; else as the accelerometer has it.
pub fn of_table<'t>(table: &'t Table<'_>) -> Option<[&'t [f64]; 3]> {
    let accel = corrected(table);
    let quiet = table
        .derived
        .quiet_force_mps2
        .get_or_init(|| quiet_force_mps2(table.time_s?, accel?, table.gyro_radps?));
    quiet.as_ref().map(|axes| axes.each_ref().map(Vec::as_slice)).or(accel)
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

/// Specific force without the board's own acceleration, m/s², in body axes: against gravity, with its usual length. A row is NaN where
/// nothing is known. `None` where the gyro does not turn as the accelerometer does.
fn quiet_force_mps2(
    time_s: &[f64],
    accel_mps2: [&[f64]; 3],
    gyro_radps: [&[f64]; 3],
) -> Option<[Vec<f64>; 3]> {
    let rows = time_s.len();
    let vector = |axes: &[&[f64]; 3], row: usize| {
        let vector = Vector3::from_fn(|axis, _| axes[axis][row]);
        vector.iter().all(|value| value.is_finite()).then_some(vector)
    };
    let mut lengths: Vec<f64> =
        (0..rows).filter_map(|row| Some(vector(&accel_mps2, row)?.norm())).filter(|n| *n > 0.0).collect();
    if lengths.len() < MIN_ROWS {
        return None;
    }
    // Shaking makes the readings longer than gravity, and no scale error is that large.
    let gravity_mps2 = median(&mut lengths).min(STANDARD_GRAVITY_MPS2);
    // How the board turned from the row before; `None` begins a new stretch.
    let turn = |row: usize| {
        let step_s = time_s[row] - time_s[row - 1];
        let turn = 0.5 * (vector(&gyro_radps, row - 1)? + vector(&gyro_radps, row)?) * step_s;
        (step_s <= MAX_STEP_S && turn.norm() <= MAX_TURN_RAD).then(|| UnitQuaternion::from_scaled_axis(turn))
    };
    let mut frames = vec![UnitQuaternion::identity(); rows];
    let mut begins = vec![true; rows];
    for row in 1..rows {
        if let Some(turn) = turn(row) {
            frames[row] = frames[row - 1] * turn;
            begins[row] = false;
        }
    }
    let forces: Vec<Option<Vector3<f64>>> =
        (0..rows).map(|row| vector(&accel_mps2, row).map(|force| frames[row] * force)).collect();
    // Sums that fade with the time constant, of the rows before and of those after.
    let fade = |row: usize| (-(time_s[row] - time_s[row - 1]) / TIME_CONSTANT_S).exp();
    let mut sums = vec![(Vector3::zeros(), 0.0); rows];
    let mut sum = (Vector3::zeros(), 0.0);
    for row in 0..rows {
        let keep = if begins[row] { 0.0 } else { fade(row) };
        sum = (sum.0 * keep, sum.1 * keep);
        if let Some(force) = forces[row] {
            sum = (sum.0 + force, sum.1 + 1.0);
        }
        sums[row] = sum;
    }
    sum = (Vector3::zeros(), 0.0);
    let mut quiet = [vec![f64::NAN; rows], vec![f64::NAN; rows], vec![f64::NAN; rows]];
    let mut kept = Vec::with_capacity(rows);
    for row in (0..rows).rev() {
        let (mean, weight) = (sums[row].0 + sum.0, sums[row].1 + sum.1);
        let length = mean.norm() / weight;
        if length > 0.0 && length.is_finite() {
            kept.push(length / gravity_mps2);
            let force = frames[row].inverse() * mean.normalize() * gravity_mps2;
            (0..3).for_each(|axis| quiet[axis][row] = force[axis]);
        }
        if let Some(force) = forces[row] {
            sum = (sum.0 + force, sum.1 + 1.0);
        }
        let keep = if begins[row] { 0.0 } else { fade(row) };
        sum = (sum.0 * keep, sum.1 * keep);
    }
    (median(&mut kept) >= MIN_LENGTH_KEPT).then_some(quiet)
}

#[cfg(test)]
mod tests {
    use super::*;

    type Axes = [Vec<f64>; 3];
    type Shaken = (Vec<f64>, Axes, Axes, Vec<Vector3<f64>>);

    const ROWS: usize = 4000;
    const STEP_S: f64 = 0.02;

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
        let quiet = quiet_force_mps2(&time, slices(&accel), slices(&gyro)).expect("a right gyro");
        let (raw, fused) = (rms_deg(&accel, &down), rms_deg(&quiet, &down));
        assert!(raw > 15.0 && fused < 1.5, "{raw} {fused}");
    }

    #[test]
    fn a_wrong_gyro_is_not_believed() {
        let (time, accel, gyro, _) = shaken();
        let [x, y, z] = slices(&gyro);
        assert!(quiet_force_mps2(&time, slices(&accel), [y, x, z]).is_none());
        let backwards = gyro.clone().map(|axis| axis.iter().map(|value| -value).collect::<Vec<f64>>());
        assert!(quiet_force_mps2(&time, slices(&accel), slices(&backwards)).is_none());
    }

    #[test]
    fn a_gap_and_missing_cells_part_the_stretches_and_lose_nothing_else() {
        let (mut time, mut accel, mut gyro, down) = shaken();
        time.iter_mut().skip(1500).for_each(|t| *t += 30.0);
        gyro[1][2500] = f64::NAN;
        accel[0][700] = f64::NAN;
        let quiet = quiet_force_mps2(&time, slices(&accel), slices(&gyro)).expect("a right gyro");
        assert!(quiet.iter().flatten().all(|value| value.is_finite()));
        assert!(rms_deg(&quiet, &down) < 2.5, "{}", rms_deg(&quiet, &down));
    }

    #[test]
    fn nothing_is_made_of_nothing() {
        let none = [f64::NAN; 30];
        assert!(quiet_force_mps2(&[0.0; 30], [&none; 3], [&none; 3]).is_none());
        assert!(quiet_force_mps2(&[], [&[]; 3], [&[]; 3]).is_none());
    }
}
