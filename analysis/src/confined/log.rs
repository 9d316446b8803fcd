//! The samples of a log as the channels read them.

use crate::samples::samples::Samples;
use nalgebra::Vector3;

/// More samples say hardly more of a confined log and cost their time.
const MOST: usize = 8_000;

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
