//! Faults of the data: what a sensor, a cable or a logger does to a good log.

use crate::effects::SpecError;
use crate::log::Log;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

/// A fault of the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultSpec {
    /// A magnet passes for about a second.
    Burst,
    /// One axis clips at 85 % of its largest reading.
    Clipping,
    /// The magnetometer repeats one reading for two seconds.
    Stuck,
    /// Three seconds of the log are missing.
    Gap,
    /// The z column is a copy of y.
    CopiedAxis,
    /// A slow sensor in a fast log: every reading stands three times. No fault.
    Repeats,
    /// Rows arrive in bursts, so their times do. No fault.
    BurstyArrival,
}

impl FaultSpec {
    /// Reads a fault's name: `burst`, `clipping`, `stuck`, `gap`, `copied-axis`, `repeats`, `bursty-arrival`.
    pub fn parse(text: &str) -> Result<FaultSpec, SpecError> {
        Ok(match text {
            "burst" => FaultSpec::Burst,
            "clipping" => FaultSpec::Clipping,
            "stuck" => FaultSpec::Stuck,
            "gap" => FaultSpec::Gap,
            "copied-axis" => FaultSpec::CopiedAxis,
            "repeats" => FaultSpec::Repeats,
            "bursty-arrival" => FaultSpec::BurstyArrival,
            _ => return Err(SpecError(format!("unknown fault `{text}`"))),
        })
    }

    pub(crate) fn inflict(self, log: &mut Log, rng: &mut ChaCha8Rng) {
        let rows = log.rows();
        let (Some(time), Some(x)) = (log.position("t_s"), log.position("mx_ut")) else { return };
        if rows < 50 {
            return;
        }
        let seconds = log.columns[time][rows - 1] - log.columns[time][0];
        let row_s = seconds / (rows - 1) as f64;
        let rows_in = |s: f64| ((s / row_s) as usize).clamp(2, rows / 4);
        let start = rng.random_range(rows / 5..3 * rows / 5);
        match self {
            FaultSpec::Burst => {
                let length = rows_in(1.2);
                let peak: [f64; 3] = core::array::from_fn(|_| rng.random_range(15.0..40.0));
                for i in 0..length {
                    let phase = std::f64::consts::PI * (i as f64 + 0.5) / length as f64;
                    for (axis, height) in peak.iter().enumerate() {
                        log.columns[x + axis][start + i] += height * phase.sin().powi(2);
                    }
                }
            }
            FaultSpec::Clipping => {
                let axis = x + rng.random_range(0..3);
                let top = log.columns[axis].iter().fold(0.0_f64, |top, value| top.max(value.abs())) * 0.85;
                for value in &mut log.columns[axis] {
                    *value = value.clamp(-top, top);
                }
            }
            FaultSpec::Stuck => {
                for axis in x..x + 3 {
                    let held = log.columns[axis][start];
                    log.columns[axis][start..start + rows_in(2.0)].fill(held);
                }
            }
            FaultSpec::Gap => {
                let end = start + rows_in(3.0);
                for column in &mut log.columns {
                    column.drain(start..end);
                }
            }
            FaultSpec::CopiedAxis => log.columns[x + 2] = log.columns[x + 1].clone(),
            FaultSpec::Repeats => {
                for axis in x..x + 3 {
                    for row in 0..rows {
                        log.columns[axis][row] = log.columns[axis][row - row % 3];
                    }
                }
            }
            FaultSpec::BurstyArrival => {
                let times = log.columns[time].clone();
                for row in 0..rows {
                    let last = (row - row % 8 + 7).min(rows - 1);
                    log.columns[time][row] = times[last] - 0.1 * row_s * (last - row) as f64;
                }
            }
        }
    }
}
