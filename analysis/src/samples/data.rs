//! The samples of a log and the core's sums of them.

use crate::samples::samples::unique_rows;
use crate::table::Table;
use ironout::calibration::{Calibration, norm};
use ironout::fit::FitError;
use ironout::gate::{Motion, RestDetector, block_samples};
use ironout::moments::Moments;
use ironout::scatter::{Scatter, ScatterBuilder};

/// Levels are looked for in this many samples.
const LEVEL_SAMPLES: usize = 20_000;

/// A log as samples: rows with equal triples in a run are one.
pub struct Data<'a> {
    /// The log.
    pub table: &'a Table<'a>,
    /// The row of each sample.
    pub rows: Vec<u32>,
    /// The step the values were rounded to on each axis, µT.
    pub step_ut: [f64; 3],
    centre_ut: [f64; 3],
    /// Where the readings of all places are drawn to one sphere: its centre.
    about_ut: Option<[f64; 3]>,
}

/// The core's sums: exact for 16-bit counts, the same as on the board; in f64 for microtesla.
pub enum Sums {
    /// Counts.
    Exact(Box<Moments>),
    /// Microtesla.
    Float(Box<ScatterBuilder>),
}

impl<'a> Data<'a> {
    /// The samples of a log.
    pub fn new(table: &'a Table<'a>) -> Self {
        let rows: Vec<u32> = unique_rows(table).into_iter().map(|row| row as u32).collect();
        let centre_ut = table.field_ut.map(middle);
        let step_ut = [0, 1, 2].map(|axis| match table.counts {
            Some((_, scale)) => scale[axis],
            None => step(table.field_ut[axis]),
        });
        Data { table, rows, step_ut, centre_ut, about_ut: None }
    }

    /// The same samples as if the field were everywhere that of the mean of the way: their vectors about this offset are made
    /// as much longer or shorter. `None` where it is one field.
    pub fn in_one_field(&self, about_ut: [f64; 3]) -> Option<Self> {
        self.table.track.as_ref()?;
        Some(Data { rows: self.rows.clone(), about_ut: Some(about_ut), ..*self })
    }

    /// The measured vector of a sample, µT.
    pub fn field(&self, sample: u32) -> [f64; 3] {
        let row = self.row(sample);
        let measured = self.table.field(row);
        match self.about_ut {
            None => measured,
            Some(about) => {
                let share = self.table.place(row).share;
                [0, 1, 2].map(|axis| about[axis] + (measured[axis] - about[axis]) / share)
            }
        }
    }

    /// The row of a sample.
    pub fn row(&self, sample: u32) -> usize {
        self.rows[sample as usize] as usize
    }

    /// Empty sums for this data.
    pub fn sums(&self) -> Sums {
        match self.table.counts.filter(|_| self.about_ut.is_none()) {
            Some(_) => Sums::Exact(Box::new(Moments::new())),
            None => Sums::Float(Box::new(ScatterBuilder::new(self.centre_ut))),
        }
    }

    /// `‖corrected‖ − F` of these samples, µT.
    pub fn residual(&self, samples: &[u32], calibration: &Calibration<f64>) -> Vec<f64> {
        samples.iter().map(|&s| norm(calibration.apply(self.field(s))) - calibration.field_ut).collect()
    }

    /// Those of `samples` that the core's gate lets through: of a moving board, block by block. The gate knows what rest
    /// looks like in microtesla; `unit` takes the log's values there (1, unless its scale is not the true one).
    pub fn moving(&self, samples: &[u32], unit: f64) -> Vec<u32> {
        let mut detector = RestDetector::new();
        let mut moving = Vec::with_capacity(samples.len());
        let mut held: Vec<u32> = Vec::new();
        for block in samples.chunks(usize::from(block_samples(self.rate_hz()))) {
            let (mean_ut, variance_ut2) = self.mean_and_variance(block);
            held.extend_from_slice(block);
            let mean_ut = mean_ut.map(|v| (v * unit) as f32);
            match detector.judge(mean_ut, (variance_ut2 * unit * unit) as f32, block.len() as u32) {
                Motion::Moved => moving.append(&mut held),
                Motion::Undecided => {}
                Motion::Rest => held.clear(),
            }
        }
        // A pause that was too short to be rest was motion.
        moving.append(&mut held);
        moving
    }

    /// Samples per second, over the whole log; NaN without a time column.
    pub fn rate_hz(&self) -> f64 {
        let seconds = self.table.time_s.and_then(|time| Some(time.last()? - time.first()?));
        seconds.map_or(f64::NAN, |seconds| self.rows.len() as f64 / seconds)
    }

    fn mean_and_variance(&self, block: &[u32]) -> ([f64; 3], f64) {
        let n = block.len() as f64;
        let mut sum = [0.0; 3];
        for &sample in block {
            self.field(sample).iter().zip(&mut sum).for_each(|(value, sum)| *sum += value);
        }
        let mean = sum.map(|sum| sum / n);
        let squares: f64 = block
            .iter()
            .flat_map(|&sample| self.field(sample).into_iter().zip(mean))
            .map(|(value, mean)| (value - mean) * (value - mean))
            .sum();
        (mean, squares / (3.0 * (n - 1.0).max(1.0)))
    }
}

impl Sums {
    /// Adds one sample.
    pub fn push(&mut self, data: &Data, sample: u32) {
        let row = data.row(sample);
        match self {
            Sums::Exact(moments) => {
                if let Some(counts) = data.table.counts.and_then(|(counts, _)| counts.get(row)) {
                    moments.push(*counts);
                }
            }
            Sums::Float(builder) => builder.push(data.field(sample)),
        }
    }

    /// Adds the sums of other samples of the same data.
    pub fn merge(&mut self, other: &Sums) {
        match (self, other) {
            (Sums::Exact(mine), Sums::Exact(other)) => {
                mine.merge(other);
            }
            (Sums::Float(mine), Sums::Float(other)) => {
                mine.merge(other);
            }
            // One log has one kind.
            _ => {}
        }
    }

    /// The scatter of the sums.
    pub fn finish(&self, data: &Data) -> Result<Scatter, FitError> {
        match self {
            Sums::Exact(moments) => {
                Scatter::from_moments(moments, data.table.counts.map_or([1.0; 3], |(_, scale)| scale))
            }
            Sums::Float(builder) => {
                let mean_square = data.step_ut.iter().map(|step| step * step).sum::<f64>() / 3.0;
                builder.finish(mean_square.sqrt())
            }
        }
    }
}

/// The median of some of the values: near the data whatever single values are.
fn middle(values: &[f64]) -> f64 {
    let stride = values.len() / LEVEL_SAMPLES + 1;
    let mut some: Vec<f64> = values.iter().step_by(stride).copied().collect();
    let half = some.len() / 2;
    if some.is_empty() { 0.0 } else { *some.select_nth_unstable_by(half, f64::total_cmp).1 }
}

/// The least distance between two values that occur: the sensor's step, or the rounding of the log.
fn step(values: &[f64]) -> f64 {
    let stride = values.len() / LEVEL_SAMPLES + 1;
    let mut levels: Vec<f64> = values.iter().step_by(stride).copied().collect();
    levels.sort_unstable_by(f64::total_cmp);
    let gap = levels
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|gap| *gap > 0.0)
        .fold(f64::INFINITY, f64::min);
    if gap.is_finite() { gap } else { 0.0 }
}
