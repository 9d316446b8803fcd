//! What each kind of measurement says of the parameters: residuals with their derivatives, summed up by block of time.

use crate::base::piece::{COLUMNS, Matrix};
use crate::base::windows::{GYRO, Stop, windows};
use crate::confined::log::Log;
use crate::confined::state::{DELAY, FIELD, MATRIX, OFFSET, PARAMETERS, RATE, State, TILT, VERTICAL, ZERO};
use nalgebra::{Matrix3, Vector3};

/// Blocks of time, whose sums show how far the samples of a channel err together.
pub const BLOCKS: usize = 24;
/// The gyro is followed for so long, s: a vehicle turns some way, and a gyro's bias hardly moves.
const WINDOW_S: f64 = 4.0;
/// Samples of a window between its ends.
const BETWEEN: usize = 8;
/// Readings are smoothed over so long, s: a gyro's errors turn a reading by less than noise does.
const SMOOTHED_S: f64 = 1.0;
/// Of at most so many.
const MOST_SMOOTHED: usize = 100;
/// A residual counts less from so many robust standard deviations on (Huber, 1964).
const HUBER: f64 = 2.5;

/// Kinds of measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// `‖v‖ − F`, `v` the corrected reading.
    Magnitude,
    /// `d · v − V`, `d` the direction of gravity, `V` the vertical part of the field.
    Dip,
    /// `v` turned back to its window's first sample, without its mean there, across the field: along it is the magnitude's.
    Gyro,
}

impl Channel {
    /// All of them.
    pub const ALL: [Channel; 3] = [Channel::Magnitude, Channel::Dip, Channel::Gyro];
}

/// What a dip is made of.
#[derive(Debug, Clone, Copy)]
pub struct Share {
    /// Part of its variance that the magnetometer's noise makes.
    pub field: f64,
    /// Part of the variance of the tilt that the accelerometer shows which is the board's own.
    pub tilt: f64,
}

impl Share {
    /// As the residuals of a dip taken along what the accelerometer shows have it.
    pub fn of(log: &Log, state: &State, magnitude_ut: f64, shown: &Rows) -> Share {
        let squares: f64 = shown.list.iter().map(|(_, _, residual)| residual * residual).sum();
        let dip_ut = (squares / shown.list.len().max(1) as f64).sqrt();
        let level_ut =
            (state.field_ut.powi(2) - state.vertical_ut.powi(2)).max(0.01 * state.field_ut.powi(2));
        // Of one direction across down.
        let error = (dip_ut.powi(2) - magnitude_ut.powi(2)).max(0.0) / level_ut;
        let tilt = 0.5 * log.tilt_square();
        let share = if tilt > 0.0 { (1.0 - error / tilt).clamp(0.0, 1.0) } else { 1.0 };
        // What is left of the error where the tilt is taken as that.
        let left_ut2 = magnitude_ut.powi(2) + share * error * level_ut;
        Share { field: magnitude_ut.powi(2) / left_ut2.max(1e-12), tilt: share }
    }

    /// The tilt as it is shown.
    pub const AS_SHOWN: Share = Share { field: 1.0, tilt: 1.0 };
}

/// A log at a state: what all channels need of both.
pub struct Seen<'a> {
    log: &'a Log,
    state: &'a State,
    /// The gyro without its errors, rad/s.
    rate: Vec<Option<Vector3<f64>>>,
    /// The corrected readings, each turned back to a moment by the gyro and averaged with those around it. Without a gyro they are as they
    /// are.
    smooth: Vec<Vector3<f64>>,
}

impl<'a> Seen<'a> {
    /// Of a log at this state.
    pub fn of(log: &'a Log, state: &'a State) -> Self {
        let rate: Vec<Option<Vector3<f64>>> =
            log.rows.iter().map(|row| row.rate_radps.map(|rate| state.rate(&rate))).collect();
        let mut smooth: Vec<Vector3<f64>> =
            log.rows.iter().map(|row| state.corrected(&row.measured_ut)).collect();
        if log.has_gyro() {
            for window in windows(&log.time_s, &rate, SMOOTHED_S, MOST_SMOOTHED) {
                let turned = window.iter().map(|stop| stop.turn * smooth[stop.sample]);
                let mean = turned.sum::<Vector3<f64>>() / window.len() as f64;
                window.iter().for_each(|stop| smooth[stop.sample] = stop.turn.inverse() * mean);
            }
        }
        Seen { log, state, rate, smooth }
    }
}

/// The rows of one channel at a state.
pub struct Rows {
    /// Block of time, derivatives, residual in µT.
    list: Vec<(usize, [f64; COLUMNS], f64)>,
}

/// Sums of one channel.
pub struct Sums {
    /// By block of time, in units of the variance of one row.
    pub blocks: Vec<Matrix>,
    /// Rms of all rows, µT.
    pub rms_ut: f64,
    /// Rows.
    pub rows: usize,
}

impl Rows {
    /// Of a log at this state. Derivatives are taken at a reading that others beside it have smoothed, and at its place on the sphere: at the
    /// reading itself the noise of both would be the same, and their product never averages out (`E[Jᵀr] ≠ 0`).
    ///
    /// A board that speeds up, brakes or turns is tilted less than its accelerometer shows. The direction down is taken as what is to be expected
    /// behind what is shown: the mean direction and `share.tilt` of the way from it (regression calibration: Carroll, Ruppert, Stefanski
    /// and Crainiceanu, Measurement Error in Nonlinear Models, 2006, chapter 4). What is left of it then has no part in the derivative.
    pub fn of(channel: Channel, seen: &Seen, share: &Share) -> Rows {
        let Seen { log, state, rate, smooth } = seen;
        let mut rows = Rows { list: Vec::new() };
        let block = |sample: usize| sample * BLOCKS / log.rows.len().max(1);
        match channel {
            Channel::Magnitude | Channel::Dip => {
                for sample in (0..log.rows.len()).step_by(log.stride) {
                    let row = &log.rows[sample];
                    let v = state.corrected(&row.measured_ut);
                    let (along, there, residual, column) = match (channel, row.down) {
                        (Channel::Magnitude, _) => {
                            let along = smooth[sample].normalize();
                            (along, along * state.field_ut, v.norm() - state.field_ut, FIELD)
                        }
                        (_, Some(shown)) => {
                            let tilt = shown - log.mean_down;
                            let down = state.down(&(log.mean_down + share.tilt * (1.0 + state.tilt) * tilt));
                            let residual = down.dot(&v) - state.vertical_ut;
                            let along_down = down.dot(&smooth[sample]) - state.vertical_ut;
                            (down, smooth[sample] - down * (share.field * along_down), residual, VERTICAL)
                        }
                        (_, None) => continue,
                    };
                    let mut derivative = [0.0; COLUMNS];
                    follow(&mut derivative, state, &along, &there);
                    derivative[column] = -1.0;
                    if let (Channel::Dip, Some(shown)) = (channel, row.down) {
                        let level = along * along.dot(&there) - there;
                        derivative[ZERO..ZERO + 3].copy_from_slice(level.as_slice());
                        derivative[TILT] = -share.tilt * level.dot(&(shown - log.mean_down));
                    }
                    rows.list.push((block(sample), derivative, residual));
                }
            }
            Channel::Gyro if log.has_gyro() => {
                for window in windows(&log.time_s, rate, WINDOW_S, BETWEEN) {
                    rows.window(&window, block(window[0].sample), seen);
                }
            }
            Channel::Gyro => {}
        }
        rows
    }

    /// Those of one window: two directions across the field for each sample.
    fn window(&mut self, window: &[Stop], block: usize, seen: &Seen) {
        let Seen { log, state, rate, .. } = seen;
        let corrected = |stop: &Stop| state.corrected(&log.rows[stop.sample].measured_ut);
        let turned: Vec<Vector3<f64>> = window.iter().map(|stop| stop.turn * corrected(stop)).collect();
        let mean = turned.iter().sum::<Vector3<f64>>() / window.len() as f64;
        let (first, second) = across(&mean);
        for direction in [first, second] {
            let mut list: Vec<([f64; COLUMNS], f64)> = (window.iter().zip(&turned))
                .map(|(stop, there)| {
                    let mut derivative = [0.0; COLUMNS];
                    // In the axes of this sample.
                    let here = stop.turn.inverse() * direction;
                    let v = stop.turn.inverse() * mean;
                    follow(&mut derivative, state, &here, &v);
                    let gyro = -(mean.cross_matrix() * stop.follows).transpose() * direction;
                    derivative[RATE..RATE + GYRO].copy_from_slice(gyro.as_slice());
                    let rate = rate[stop.sample].unwrap_or_default();
                    derivative[DELAY] = -here.dot(&rate.cross(&v));
                    (derivative, direction.dot(there) + state.delay_s * derivative[DELAY])
                })
                .collect();
            // The field at the window's start is whatever fits its samples best.
            let n = list.len() as f64;
            let mut middle = [0.0; COLUMNS];
            let mut mean_residual = 0.0;
            for (derivative, residual) in &list {
                middle.iter_mut().zip(derivative).for_each(|(sum, value)| *sum += value / n);
                mean_residual += residual / n;
            }
            for (derivative, residual) in &mut list {
                derivative.iter_mut().zip(&middle).for_each(|(value, mean)| *value -= mean);
                self.list.push((block, *derivative, *residual - mean_residual));
            }
        }
    }

    /// Standard deviation of most rows, µT.
    pub fn sigma_ut(&self) -> f64 {
        let mut sizes: Vec<f64> = self.list.iter().map(|(_, _, residual)| residual.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        // The median of a normal variable's size is 0.6745 of its standard deviation.
        (sizes.get(sizes.len() / 2).copied().unwrap_or(0.0) / 0.6745).max(1e-6)
    }

    /// Sums in units of this standard deviation, with what stands out weighed down.
    pub fn sums(&self, sigma_ut: f64) -> Sums {
        let mut blocks = vec![Matrix::new(PARAMETERS); BLOCKS];
        let mut squares = 0.0;
        for (block, derivative, residual) in &self.list {
            squares += residual * residual;
            let share = (HUBER * sigma_ut / residual.abs().max(1e-300)).min(1.0).sqrt() / sigma_ut;
            let row = derivative.map(|value| value * share);
            blocks[(*block).min(BLOCKS - 1)].push(&row, residual * share);
        }
        let rows = self.list.len();
        Sums { blocks, rms_ut: (squares / rows.max(1) as f64).sqrt(), rows }
    }
}

/// Rms by which the corrected reading leaves its mean in a window, one of three axes, µT: what the gyro has to explain.
pub fn turned_by_ut(log: &Log, state: &State) -> f64 {
    let rate: Vec<Option<Vector3<f64>>> = log.rows.iter().map(|row| row.rate_radps).collect();
    let (mut squares, mut count) = (0.0, 0);
    for window in windows(&log.time_s, &rate, WINDOW_S, BETWEEN) {
        let list: Vec<Vector3<f64>> =
            window.iter().map(|stop| state.corrected(&log.rows[stop.sample].measured_ut)).collect();
        let mean = list.iter().sum::<Vector3<f64>>() / list.len() as f64;
        squares += list.iter().map(|v| (v - mean).norm_squared()).sum::<f64>();
        count += 3 * list.len();
    }
    (squares / count.max(1) as f64).sqrt()
}

/// How `along · v` follows offset and matrix.
fn follow(derivative: &mut [f64; COLUMNS], state: &State, along: &Vector3<f64>, v: &Vector3<f64>) {
    let offset = -state.matrix.transpose() * along;
    derivative[OFFSET..OFFSET + 3].copy_from_slice(offset.as_slice());
    for i in 0..3 {
        for j in 0..3 {
            derivative[MATRIX + 3 * i + j] = along[i] * v[j];
        }
    }
}

/// Two unit vectors at right angles to this one and each other.
fn across(v: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let axis = v.iamin();
    let first = v.cross(&Matrix3::identity().column(axis).into_owned()).normalize();
    (first, v.normalize().cross(&first))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::confined::log::Row;
    use nalgebra::Rotation3;

    /// A boat without noise, and its true parameters.
    fn boat() -> (Log, State) {
        let state = State {
            offset_ut: Vector3::new(20.0, -30.0, 10.0),
            matrix: Matrix3::new(1.05, 0.02, -0.03, 0.04, 0.97, 0.01, -0.02, 0.03, 1.01),
            field_ut: 50.0,
            vertical_ut: 43.0,
            gyro: Default::default(),
            delay_s: 0.0,
            zero: Vector3::zeros(),
            tilt: 0.0,
        };
        let inverse = state.matrix.try_inverse().expect("invertible");
        let at =
            |t: f64| Rotation3::from_euler_angles(0.2 * (1.3 * t).sin(), 0.15 * (0.9 * t).cos(), 0.3 * t);
        let world = Vector3::new((50.0_f64.powi(2) - 43.0_f64.powi(2)).sqrt(), 0.0, 43.0);
        let time_s: Vec<f64> = (0..2000).map(|i| 0.02 * f64::from(i)).collect();
        let rows = (time_s.iter())
            .map(|&t| {
                let here = at(t).inverse();
                let step = at(t - 1e-4).inverse() * at(t + 1e-4);
                Row {
                    measured_ut: state.offset_ut + inverse * (here * world),
                    down: Some(here * Vector3::z()),
                    rate_radps: Some(step.scaled_axis() / 2e-4),
                }
            })
            .collect();
        (Log { time_s, rows, mean_down: Vector3::z(), stride: 1 }, state)
    }

    #[test]
    fn true_parameters_leave_nothing() {
        let (log, state) = boat();
        for channel in Channel::ALL {
            let sums = Rows::of(channel, &Seen::of(&log, &state), &Share::AS_SHOWN).sums(1.0);
            assert!(
                sums.rows > 100 && sums.rms_ut < 2e-3,
                "{channel:?}: {} rows, {}",
                sums.rows,
                sums.rms_ut
            );
        }
    }

    #[test]
    fn residuals_follow_the_parameters_as_their_derivatives_say() {
        let (log, state) = boat();
        for channel in Channel::ALL {
            let before = Rows::of(channel, &Seen::of(&log, &state), &Share::AS_SHOWN);
            for parameter in 0..PARAMETERS {
                let mut step = [0.0; PARAMETERS];
                step[parameter] = 1e-5;
                let moved = state.stepped(&step);
                let after = Rows::of(channel, &Seen::of(&log, &moved), &Share::AS_SHOWN);
                let (mut off, mut size) = (0.0_f64, 1e-3_f64);
                for ((_, derivative, one), (_, _, two)) in before.list.iter().zip(&after.list) {
                    off = off.max((two - one - 1e-5 * derivative[parameter]).abs() / 1e-5);
                    size = size.max(derivative[parameter].abs());
                }
                assert!(off < 0.02 * size, "{channel:?} {parameter}: {off} of {size}");
            }
        }
    }
}
