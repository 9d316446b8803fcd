//! The samples of a log as the channels read them.

use crate::base::counted::Counted;
use crate::samples::samples::Samples;
use nalgebra::Vector3;
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
}

impl Log {
    /// Of these samples. `None` where most of them know no gravity.
    pub fn of(samples: &Samples) -> Option<Log> {
        let rows: Vec<Row> = (samples.readings.iter())
            .map(|reading| Row {
                measured_ut: reading.measured_ut.into(),
                down: reading.down.map(Vector3::from),
                rate_radps: reading.turn_radps.map(Vector3::from),
            })
            .collect();
        let known: Vec<Vector3<f64>> = rows.iter().filter_map(|row| row.down).collect();
        if 2 * known.len() <= rows.len() {
            return None;
        }
        let mean_down = known.iter().sum::<Vector3<f64>>().try_normalize(1e-3 * known.len() as f64)?;
        let stride = rows.len().div_ceil(MOST).max(1);
        Some(Log { time_s: samples.time.clone().unwrap_or_default(), rows, mean_down, stride })
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
        let mut tilts: Vec<f64> = self.rows.iter().filter_map(|row| row.down.map(tilt)).collect();
        tilts.sort_by(f64::total_cmp);
        tilts.get((share * tilts.len().saturating_sub(1) as f64) as usize).copied().unwrap_or(180.0)
    }

    /// Mean square of the tilt from the mean attitude, rad².
    pub fn tilt_square(&self) -> f64 {
        let squares: Vec<f64> =
            self.rows.iter().filter_map(|row| Some((row.down? - self.mean_down).norm_squared())).collect();
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
            })
            .collect();
        let time_s = (0..12).map(|i| f64::from(i) * 0.01 + if i > 5 { 5.0 } else { 0.0 }).collect();
        let log = Log { time_s, rows, mean_down: Vector3::z(), stride: 1 }.averaged(4, 0.06);
        assert_eq!(log.rows.len(), 2);
        assert!((log.time_s[0] - 0.015).abs() < 1e-12 && (log.time_s[1] - 5.095).abs() < 1e-12);
        assert_eq!((log.rows[0].measured_ut.x, log.rows[1].measured_ut.x), (1.5, 9.5));
        assert_eq!(
            (log.rows[0].rate_radps, log.rows[1].rate_radps),
            (None, Some(Vector3::new(0.0, 9.5, 0.0)))
        );
    }
}
