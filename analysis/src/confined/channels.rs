//! What each kind of measurement says of the parameters: residuals with their derivatives, summed up by block of time.

use crate::base::term::{COLUMNS, Matrix};
use crate::base::windows::{GYRO, Stop, windows};
use crate::confined::log::Log;
use crate::confined::state::{DELAY, FIELD, RATE, State, TILT, VERTICAL, ZERO};
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
    /// `d · v − V` with the down of a logged attitude.
    Tilt,
    /// `e · v`, `e` magnetic east by a logged attitude.
    Yaw,
}

impl Channel {
    /// All of them.
    pub const ALL: [Channel; 5] =
        [Channel::Magnitude, Channel::Dip, Channel::Gyro, Channel::Tilt, Channel::Yaw];

    /// Whether it compares the field with a direction from elsewhere, whose errors may be the same all the time.
    pub fn has_own_direction(self) -> bool {
        matches!(self, Channel::Dip | Channel::Tilt | Channel::Yaw)
    }

    /// Whether its errors last longer than a block of time: those of an attitude drift.
    pub fn drifts(self) -> bool {
        matches!(self, Channel::Tilt | Channel::Yaw)
    }
}

/// What a dip is made of.
#[derive(Debug, Clone, Copy)]
pub struct Share {
    /// Part of its variance that the magnetometer's noise makes.
    pub field: f64,
    /// Part of the variance of the tilt that the accelerometer shows which is the board's own.
    pub tilt: f64,
    /// Variance of the shown direction of one axis across down, rad².
    pub error: f64,
}

impl Share {
    /// As the residuals of a dip taken along what is shown have it; `tilt_square` is the mean square of the tilt that is shown.
    pub fn of(tilt_square: f64, state: &State, magnitude_ut: f64, shown: &Rows) -> Share {
        let squares: f64 = shown.list.iter().map(|(_, _, residual)| residual * residual).sum();
        let dip_ut = (squares / shown.list.len().max(1) as f64).sqrt();
        let level_ut =
            (state.field_ut.powi(2) - state.vertical_ut.powi(2)).max(0.01 * state.field_ut.powi(2));
        // Of one direction across down.
        let error = (dip_ut.powi(2) - magnitude_ut.powi(2)).max(0.0) / level_ut;
        let tilt = 0.5 * tilt_square;
        let share = if tilt > 0.0 { (1.0 - error / tilt).clamp(0.0, 1.0) } else { 1.0 };
        // What is left of the error where the tilt is taken as that.
        let left_ut2 = magnitude_ut.powi(2) + share * error * level_ut;
        Share { field: magnitude_ut.powi(2) / left_ut2.max(1e-12), tilt: share, error }
    }

    /// The tilt as it is shown.
    pub const AS_SHOWN: Share = Share { field: 1.0, tilt: 1.0, error: 0.0 };
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
        let mut smooth: Vec<Vector3<f64>> = log.rows.iter().map(|row| state.corrected(row)).collect();
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
    /// Of a log at this state. Derivatives are taken at a reading that others next to it have smoothed, and at its place on the sphere: at the
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
                    let v = state.corrected(row);
                    let (along, there, residual, column) = match (channel, row.down) {
                        (Channel::Magnitude, _) => {
                            let along = smooth[sample].normalize();
                            (along, along * state.field_ut, v.norm() - state.field_ut, FIELD)
                        }
                        (_, Some(shown)) => {
                            let tilt = shown - log.mean_down;
                            let down = state.down(&(log.mean_down + (share.tilt + state.tilt) * tilt));
                            let residual = down.dot(&v) - state.vertical_ut;
                            let along_down = down.dot(&smooth[sample]) - state.vertical_ut;
                            (down, smooth[sample] - down * (share.field * along_down), residual, VERTICAL)
                        }
                        (_, None) => continue,
                    };
                    let mut derivative = [0.0; COLUMNS];
                    state.follow(&mut derivative, row, &along, &there);
                    derivative[column] = -1.0;
                    if let (Channel::Dip, Some(shown)) = (channel, row.down) {
                        let level = along * along.dot(&there) - there;
                        derivative[ZERO..ZERO + 3].copy_from_slice(level.as_slice());
                        derivative[TILT] = -level.dot(&(shown - log.mean_down));
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
            Channel::Tilt | Channel::Yaw => {
                for sample in (0..log.poses.len()).step_by(log.stride) {
                    rows.posed(channel, sample, block(sample), seen, share);
                }
            }
        }
        rows
    }

    /// The row of a logged attitude at one sample.
    fn posed(&mut self, channel: Channel, sample: usize, block: usize, seen: &Seen, share: &Share) {
        let Seen { log, state, smooth, .. } = seen;
        let (row, Some(mut pose)) = (&log.rows[sample], log.poses[sample]) else { return };
        let mut derivative = [0.0; COLUMNS];
        let v = state.corrected(row);
        if channel == Channel::Tilt {
            let shown = pose.axes.column(2).into_owned();
            let own = log.mean_pose_down + share.tilt * (shown - log.mean_pose_down);
            pose.axes.set_column(2, &own);
            let predicted = state.predicted(&pose, &row.acts);
            let down = predicted.axes[2];
            let there =
                smooth[sample] - down * (share.field * (down.dot(&smooth[sample]) - state.vertical_ut));
            state.follow(&mut derivative, row, &down, &there);
            State::follow_attitude(&mut derivative, &down, &predicted.per_s[1], &there);
            derivative[VERTICAL] = -1.0;
            self.list.push((block, derivative, down.dot(&v) - state.vertical_ut));
        } else {
            let predicted = state.predicted(&pose, &row.acts);
            let [north, east, _] = predicted.axes;
            let there = smooth[sample] - east * east.dot(&smooth[sample]);
            state.follow(&mut derivative, row, &east, &there);
            State::follow_attitude(&mut derivative, &east, &predicted.per_s[0], &there);
            state.follow_yaw(&mut derivative, &predicted, &row.acts, north.dot(&there));
            self.list.push((block, derivative, east.dot(&v)));
        }
    }

    /// Those of one window: two directions across the field for each sample.
    fn window(&mut self, window: &[Stop], block: usize, seen: &Seen) {
        let Seen { log, state, rate, .. } = seen;
        let corrected = |stop: &Stop| state.corrected(&log.rows[stop.sample]);
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
                    state.follow(&mut derivative, &log.rows[stop.sample], &here, &v);
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
    pub fn sums(&self, sigma_ut: f64, parameters: usize) -> Sums {
        let mut blocks = vec![Matrix::new(parameters); BLOCKS];
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
            window.iter().map(|stop| state.corrected(&log.rows[stop.sample])).collect();
        let mean = list.iter().sum::<Vector3<f64>>() / list.len() as f64;
        squares += list.iter().map(|v| (v - mean).norm_squared()).sum::<f64>();
        count += 3 * list.len();
    }
    (squares / count.max(1) as f64).sqrt()
}

/// Two unit vectors at right angles to this one and each other.
fn across(v: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let axis = v.iamin();
    let first = v.cross(&Matrix3::identity().column(axis).into_owned()).normalize();
    (first, v.normalize().cross(&first))
}

#[cfg(test)]
#[path = "channels_tests.rs"]
mod tests;
