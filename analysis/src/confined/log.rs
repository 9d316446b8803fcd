//! The samples of a log as the channels read them.

use crate::base::counted::Counted;
use crate::base::windows::windows;
use crate::samples::samples::{Column, Samples};
use crate::table::Table;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use std::ops::Range;

/// More samples say hardly more of a confined log and cost their time.
const MOST: usize = 8_000;
/// A log that the study thins is taken in stretches of this length, s: each is long enough for two windows of the gyro ...
const STRETCH_S: f64 = 8.5;
/// ... and all of them together have this many samples ...
const MOST_IN_STRETCHES: usize = 20_000;
/// ... at this rate, Hz: of a faster log the mean of neighbours is one sample, in which no vehicle turns far.
const PACE_HZ: f64 = 50.0;

/// One sample.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// The reading, µT.
    pub measured_ut: Vector3<f64>,
    /// The direction of gravity, board axes; unit.
    pub down: Option<Vector3<f64>>,
    /// The gyro, rad/s.
    pub rate_radps: Option<Vector3<f64>>,
    /// The columns of the effects, about where these are zero.
    pub acts: [f64; MOST_EFFECTS],
}

/// Most effects of a confined log: what else moves with the vehicle is not told apart.
pub const MOST_EFFECTS: usize = 4;

/// What a logged attitude is at one sample.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// North, east and down of its world in its own axes, as columns.
    pub axes: Matrix3<f64>,
    /// How they move, 1/s.
    pub per_s: Matrix3<f64>,
    /// Sine and cosine of the heading.
    pub heading: (f64, f64),
}

/// A log.
#[derive(Debug, Clone)]
pub struct Log {
    /// Time of each sample, s; empty where it is unknown.
    pub time_s: Vec<f64>,
    /// The samples.
    pub rows: Vec<Row>,
    /// The mean direction of gravity.
    pub mean_down: Vector3<f64>,
    /// Every how many samples magnitude and dip are asked.
    pub stride: usize,
    /// The logged attitude at each sample; empty where the log has none.
    pub poses: Vec<Option<Pose>>,
    /// The mean direction of its down, in its own axes.
    pub mean_pose_down: Vector3<f64>,
    /// Whether the yaw of the attitude counts from true north.
    pub from_north: bool,
    /// Mean square of the column of each effect, about where the effect is zero.
    pub effects: Vec<f64>,
}

/// Turns of the board are compared over this time, s.
const TURN_S: f64 = 2.0;
/// Between samples further apart than this, s, the attitude is not known.
const PAUSE_S: f64 = 0.3;
/// An attitude whose down is further from the accelerometer's in the mean, degrees, has other axes.
const SAME_DOWN_DEG: f64 = 20.0;
/// ... and is turned over where its cosine to that is beneath minus this.
const OVER: f64 = 0.9;
/// An attitude turns as the gyro says but for this share of the mean square turn, or for this angle, degrees.
const SAME_TURN: f64 = 0.1;
const SAME_TURN_DEG: f64 = 2.0;

impl Log {
    /// Of these samples. `None` where most of them know no gravity.
    pub fn of(samples: &Samples) -> Option<Log> {
        let rows: Vec<Row> = (samples.readings.iter())
            .map(|reading| Row {
                measured_ut: reading.measured_ut.into(),
                down: reading.down.map(Vector3::from),
                rate_radps: reading.turn_radps.map(Vector3::from),
                acts: [0.0; MOST_EFFECTS],
            })
            .collect();
        let known: Vec<Vector3<f64>> = rows.iter().filter_map(|row| row.down).collect();
        if 2 * known.len() <= rows.len() {
            return None;
        }
        let mean_down = known.iter().sum::<Vector3<f64>>().try_normalize(1e-3 * known.len() as f64)?;
        let stride = rows.len().div_ceil(MOST).max(1);
        let time_s = samples.time.clone().unwrap_or_default();
        let (poses, effects) = (Vec::new(), Vec::new());
        let (mean_pose_down, from_north) = (Vector3::zeros(), false);
        Some(Log { time_s, rows, mean_down, stride, poses, mean_pose_down, from_north, effects })
    }

    /// The same with effects in proportion to these columns.
    pub fn with_effects(mut self, columns: &[&Column]) -> Log {
        for (effect, column) in columns.iter().enumerate().take(MOST_EFFECTS) {
            let mut square = 0.0;
            for (row, value) in self.rows.iter_mut().zip(&column.values) {
                row.acts[effect] = value - column.reference;
                square += row.acts[effect].powi(2);
            }
            self.effects.push(square / self.rows.len().max(1) as f64);
        }
        self
    }

    /// The same with the attitude that the table has, as it is so many seconds after each row's time.
    ///
    /// # Errors
    /// Why that attitude cannot be used, in words.
    pub fn with_attitude(
        &self,
        table: &Table,
        samples: &Samples,
        after_s: f64,
    ) -> Option<Result<Log, String>> {
        let columns = table.attitude?;
        let turns: Vec<Option<Matrix3<f64>>> = (samples.row.iter())
            .map(|&row| {
                let [w, x, y, z] = columns.map(|column| column.get(row).copied().unwrap_or(f64::NAN));
                let norm = (w * w + x * x + y * y + z * z).sqrt();
                let to_world = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
                (0.9..1.1).contains(&norm).then(|| to_world.inverse().to_rotation_matrix().into_inner())
            })
            .collect();
        let mut turns = turns;
        let down_of = |turns: &[Option<Matrix3<f64>>]| {
            let downs: Vec<Vector3<f64>> =
                turns.iter().flatten().map(|turn| turn.column(2).into_owned()).collect();
            let mean = downs.iter().sum::<Vector3<f64>>().try_normalize(1e-3 * downs.len().max(1) as f64)?;
            Some((mean, downs.len()))
        };
        // A world of east, north, up (ROS, telephones): turned over, with its yaw counted from elsewhere.
        let turned_over = down_of(&turns).is_some_and(|(mean, _)| mean.dot(&self.mean_down) < -OVER);
        if turned_over {
            let over = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
            turns.iter_mut().flatten().for_each(|turn| *turn *= over);
        }
        let (mean, known) = down_of(&turns)?;
        if 2 * known <= turns.len() || self.time_s.len() != turns.len() {
            return Some(Err("it is missing in most rows".into()));
        }
        let apart_deg = mean.dot(&self.mean_down).clamp(-1.0, 1.0).acos().to_degrees();
        if apart_deg > SAME_DOWN_DEG {
            return Some(Err(format!("its direction down is {apart_deg:.0}° from the accelerometer's")));
        }
        if let Some(off_deg) = self.turns_otherwise(&turns) {
            return Some(Err(format!(
                "it rotates differently from the gyro ({off_deg:.0}° rms in {TURN_S:.0} s)"
            )));
        }
        let turns = if after_s == 0.0 { turns } else { self.after(&turns, after_s) };
        let forward = mean.cross(&Vector3::ith(mean.iamin(), 1.0)).normalize();
        let pose = |at: usize| {
            let axes = turns[at]?;
            let (before, after) = (at.saturating_sub(1), (at + 1).min(turns.len() - 1));
            let time_s = self.time_s[after] - self.time_s[before];
            let moved = turns[before].zip(turns[after]).filter(|_| time_s > 0.0 && time_s < TURN_S);
            let per_s = moved.map_or_else(Matrix3::zeros, |(one, two)| (two - one) / time_s);
            let (north, east) = (forward.dot(&axes.column(0)), forward.dot(&axes.column(1)));
            let level = north.hypot(east).max(1e-6);
            Some(Pose { axes, per_s, heading: (east / level, north / level) })
        };
        let poses = (0..turns.len()).map(pose).collect();
        Some(Ok(Log { poses, mean_pose_down: mean, from_north: !turned_over, ..self.clone() }))
    }

    /// Axes so many seconds after each sample, on the line between those before and behind.
    fn after(&self, turns: &[Option<Matrix3<f64>>], after_s: f64) -> Vec<Option<Matrix3<f64>>> {
        let time_s = &self.time_s;
        let at = |t: f64| {
            let next = time_s.partition_point(|own| *own <= t);
            let before = next.checked_sub(1)?;
            let (Some(&from_s), Some(&to_s)) = (time_s.get(before), time_s.get(next)) else { return None };
            let (one, two) = (turns[before]?, turns[next]?);
            let share = (t - from_s) / (to_s - from_s);
            (to_s - from_s < PAUSE_S).then(|| one + share * (two - one))
        };
        time_s.iter().map(|t| at(t + after_s)).collect()
    }

    /// By how much an attitude turns otherwise than the gyro, degrees rms, where that is too much.
    fn turns_otherwise(&self, turns: &[Option<Matrix3<f64>>]) -> Option<f64> {
        let rate: Vec<Option<Vector3<f64>>> = self.rows.iter().map(|row| row.rate_radps).collect();
        let (mut off, mut turned, mut count) = (0.0, 0.0, 0.0_f64);
        let angle = |turn: &Matrix3<f64>| (0.5 * (turn.trace() - 1.0)).clamp(-1.0, 1.0).acos();
        for window in windows(&self.time_s, &rate, TURN_S, 0) {
            let [first, .., last] = window.as_slice() else { continue };
            let Some((one, two)) = turns[first.sample].zip(turns[last.sample]) else { continue };
            let by_attitude = one * two.transpose();
            off += angle(&(by_attitude.transpose() * last.turn.matrix())).powi(2);
            turned += angle(&by_attitude).powi(2).max(angle(last.turn.matrix()).powi(2));
            count += 1.0;
        }
        let off_deg = (off / count.max(1.0)).sqrt().to_degrees();
        (off > SAME_TURN * turned && off_deg > SAME_TURN_DEG).then_some(off_deg)
    }

    /// Whether there is a logged attitude.
    pub fn has_attitude(&self) -> bool {
        !self.poses.is_empty()
    }

    /// Of the samples that count. A long log is taken in stretches of neighbouring samples: between samples that lie far apart nobody
    /// knows how the gyro turned.
    pub fn of_counted(counted: &Counted) -> Option<Log> {
        let samples = &counted.samples;
        let step_s = samples.step_s() / samples.stride as f64;
        let gyro = counted.table.gyro_radps.is_some() && samples.time.is_some() && step_s > 0.0;
        if samples.stride == 1 || !gyro {
            return Log::of(samples);
        }
        let pace = (1.0 / (step_s * PACE_HZ)).floor().max(1.0) as usize;
        let stretches = stretches(counted.used.len(), (STRETCH_S / step_s).ceil() as usize, pace);
        let rows =
            |stretch: Range<usize>| counted.used[stretch].iter().map(|&sample| counted.data.row(sample));
        let neighbours = samples.of_these(counted.table, stretches.into_iter().flat_map(rows).collect());
        Some(Log::of(&neighbours)?.averaged(pace, 1.5 * pace as f64 * step_s))
    }

    /// The means of so many samples after each other, if they lie within `most_s`.
    fn averaged(self, pace: usize, most_s: f64) -> Log {
        if pace == 1 {
            return self;
        }
        let (mut time_s, mut rows) = (Vec::new(), Vec::new());
        for (time, some) in self.time_s.chunks_exact(pace).zip(self.rows.chunks_exact(pace)) {
            if time[pace - 1] - time[0] <= most_s {
                let mean = |sum: Option<Vector3<f64>>| sum.map(|sum| sum / pace as f64);
                time_s.push(time.iter().sum::<f64>() / pace as f64);
                rows.push(Row {
                    measured_ut: some.iter().map(|row| row.measured_ut).sum::<Vector3<f64>>() / pace as f64,
                    down: some
                        .iter()
                        .map(|row| row.down)
                        .sum::<Option<Vector3<f64>>>()
                        .map(|sum| sum.normalize()),
                    rate_radps: mean(some.iter().map(|row| row.rate_radps).sum()),
                    acts: [0.0; MOST_EFFECTS],
                });
            }
        }
        let stride = rows.len().div_ceil(MOST).max(1);
        Log { time_s, rows, stride, ..self }
    }

    /// The same with its tilts from another attitude.
    pub fn about(self, down: Vector3<f64>) -> Log {
        Log { mean_down: down, ..self }
    }

    /// The tilt that this share of the samples does not exceed, degrees from the mean attitude.
    pub fn tilt_deg(&self, share: f64) -> f64 {
        let tilt = |down: Vector3<f64>| down.dot(&self.mean_down).clamp(-1.0, 1.0).acos().to_degrees();
        let posed = |pose: &Option<Pose>| {
            let cosine = pose.as_ref()?.axes.column(2).dot(&self.mean_pose_down);
            Some(cosine.clamp(-1.0, 1.0).acos().to_degrees())
        };
        // An accelerometer that flies shows its thrust.
        let mut tilts: Vec<f64> = match self.has_attitude() {
            true => self.poses.iter().filter_map(posed).collect(),
            false => self.rows.iter().filter_map(|row| row.down.map(tilt)).collect(),
        };
        tilts.sort_by(f64::total_cmp);
        tilts.get((share * tilts.len().saturating_sub(1) as f64) as usize).copied().unwrap_or(180.0)
    }

    /// Mean square of the tilt from the mean attitude, rad².
    pub fn tilt_square(&self) -> f64 {
        let squares: Vec<f64> =
            self.rows.iter().filter_map(|row| Some((row.down? - self.mean_down).norm_squared())).collect();
        squares.iter().sum::<f64>() / squares.len().max(1) as f64
    }

    /// The same of the logged attitude.
    pub fn pose_tilt_square(&self) -> f64 {
        let of = |pose: &Pose| (pose.axes.column(2) - self.mean_pose_down).norm_squared();
        let squares: Vec<f64> = self.poses.iter().flatten().map(of).collect();
        squares.iter().sum::<f64>() / squares.len().max(1) as f64
    }

    /// Whether the samples have a time each and a gyro.
    pub fn has_gyro(&self) -> bool {
        self.time_s.len() == self.rows.len() && self.rows.iter().any(|row| row.rate_radps.is_some())
    }
}

/// Stretches of `long` samples at equal distances in a log of `n`, of whole groups of `pace` samples.
fn stretches(n: usize, long: usize, pace: usize) -> Vec<Range<usize>> {
    let long = long.next_multiple_of(pace).min(n / pace * pace);
    let count = (MOST_IN_STRETCHES * pace / long.max(1)).clamp(1, (n / long.max(1)).max(1));
    let begin = |stretch: usize| stretch * (n - long) / (count - 1).max(1);
    (0..count).map(|stretch| begin(stretch)..begin(stretch) + long).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_lie_apart_and_reach_from_end_to_end() {
        for (n, long, pace) in
            [(1_000_000, 425, 1), (1_000_000, 1700, 4), (50_000, 425, 1), (41_000, 60_000, 1)]
        {
            let list = stretches(n, long, pace);
            assert!(
                list[0].start == 0 && list.iter().all(|one| one.end <= n && one.len() % pace == 0),
                "{n}"
            );
            assert!(list.windows(2).all(|pair| pair[0].end <= pair[1].start), "{n}: {list:?}");
            assert!(list.len() == 1 || list.last().is_some_and(|last| last.end == n), "{n}: {list:?}");
            assert!(
                list.iter().map(Range::len).sum::<usize>() <= (MOST_IN_STRETCHES + 1700) * pace
                    || list.len() == 1
            );
        }
    }

    #[test]
    fn the_mean_of_neighbours_is_one_sample_and_no_mean_reaches_over_a_gap() {
        let rows: Vec<Row> = (0..12)
            .map(|i| Row {
                measured_ut: Vector3::new(f64::from(i), 0.0, 1.0),
                down: Some(Vector3::z()),
                rate_radps: (i > 3).then(|| Vector3::new(0.0, f64::from(i), 0.0)),
                acts: [0.0; MOST_EFFECTS],
            })
            .collect();
        let time_s = (0..12).map(|i| f64::from(i) * 0.01 + if i > 5 { 5.0 } else { 0.0 }).collect();
        let (poses, effects) = (Vec::new(), Vec::new());
        let (mean_down, mean_pose_down, from_north) = (Vector3::z(), Vector3::zeros(), false);
        let log = Log { time_s, rows, mean_down, stride: 1, poses, mean_pose_down, from_north, effects };
        let log = log.averaged(4, 0.06);
        assert_eq!(log.rows.len(), 2);
        assert!((log.time_s[0] - 0.015).abs() < 1e-12 && (log.time_s[1] - 5.095).abs() < 1e-12);
        assert_eq!((log.rows[0].measured_ut.x, log.rows[1].measured_ut.x), (1.5, 9.5));
        assert_eq!(
            (log.rows[0].rate_radps, log.rows[1].rate_radps),
            (None, Some(Vector3::new(0.0, 9.5, 0.0)))
        );
    }
}
