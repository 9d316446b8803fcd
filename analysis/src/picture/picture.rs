//! The series of one log under one calibration.

use crate::base::heading::{difference_deg, heading_deg};
use crate::correct::Corrector;
use crate::picture::bins::{Against, Histogram, Residuals, against, histogram};
use crate::picture::rows::Rows;
use crate::picture::spectrum::{Density, density};
use crate::picture::tiles::{Tiles, tiles};
use crate::picture::timeline::{Pieces, Timeline};
use crate::samples::samples::Samples;
use crate::table::Table;
use ironout::calibration::{Calibration, norm};
use serde::Serialize;

/// Samples that are drawn one by one.
const MOST_POINTS: usize = 2_500;

/// Samples one by one, evenly picked, in the order of time.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Cloud {
    /// Row of the log.
    pub row: Vec<u32>,
    /// Time, s; empty without a clock.
    pub at_s: Vec<f32>,
    /// Measured, µT, axis after axis.
    pub measured_ut: [Vec<f32>; 3],
    /// Corrected, µT; empty without a calibration.
    pub corrected_ut: [Vec<f32>; 3],
    /// Residual of offset and matrix only, µT.
    pub without_ut: Vec<f32>,
    /// Residual of the whole model, µT.
    pub residual_ut: Vec<f32>,
    /// Values of each column of [`Picture::against`], in its order.
    pub columns: Vec<Vec<f32>>,
}

/// What is drawn of one log.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Picture {
    /// The magnitude of the corrected field, µT; `None` without a calibration.
    pub field_ut: Option<f64>,
    /// Samples one by one.
    pub cloud: Cloud,
    /// The sphere of directions.
    pub tiles: Option<Tiles>,
    /// Over time.
    pub timeline: Option<Timeline>,
    /// Against every column, time, attitude and rate of turn.
    pub against: Vec<Against>,
    /// By frequency.
    pub spectrum: Option<Density>,
    /// By size.
    pub histogram: Option<Histogram>,
}

/// What a picture is made of.
pub struct Drawn<'a> {
    /// The log.
    pub table: &'a Table<'a>,
    /// The rows that count.
    pub rows: Vec<usize>,
    /// Its samples with the direction down, where they were sorted out.
    pub samples: Option<&'a Samples>,
    /// What noise leaves of the magnitude, µT.
    pub floor_ut: Option<f64>,
}

impl Drawn<'_> {
    /// The samples as they were measured, where there is no calibration.
    pub fn bare(&self) -> Picture {
        let measured: Vec<[f64; 3]> = self.rows.iter().map(|&row| self.table.field(row)).collect();
        let picked = picked(self.rows.len());
        Picture {
            cloud: Cloud {
                row: picked.iter().filter_map(|&i| self.rows.get(i)).map(|row| *row as u32).collect(),
                at_s: self.times(&self.rows, &picked),
                measured_ut: axes(&measured, &picked),
                ..Cloud::default()
            },
            ..Picture::default()
        }
    }

    /// The samples under a calibration; `base` is that without effects.
    pub fn under(&self, base: &Calibration<f64>, corrector: &Corrector) -> Picture {
        let rows = Rows::of(self.table, self.rows.iter().copied(), base, corrector);
        let floor_ut = self.floor_ut.unwrap_or(0.0);
        let residuals = Residuals { without_ut: &rows.without_ut, with_ut: &rows.with_ut, floor_ut };
        let columns = self.columns(&rows);
        let picked = picked(rows.row.len());
        let mut against_all = Vec::new();
        let mut values_of = Vec::new();
        for (name, unit, values) in &columns {
            if let Some(bins) = against(name, unit, values, &residuals) {
                against_all.push(bins);
                values_of.push(pick(values, &picked));
            }
        }
        let time_s = self.table.time_s.map(|time| rows.row.iter().map(|&row| time[row]).collect::<Vec<_>>());
        Picture {
            field_ut: Some(corrector.calibration().base.field_ut),
            tiles: Some(tiles(&rows.corrected_ut)),
            timeline: time_s.as_deref().and_then(|time| self.timeline(time, &rows)),
            spectrum: density(time_s.as_deref(), &rows.without_ut, &rows.with_ut, floor_ut),
            histogram: histogram(&residuals),
            cloud: Cloud {
                row: picked.iter().filter_map(|&i| rows.row.get(i)).map(|row| *row as u32).collect(),
                at_s: self.times(&rows.row, &picked),
                measured_ut: axes(&rows.measured_ut, &picked),
                corrected_ut: axes(&rows.corrected_ut, &picked),
                without_ut: pick(&rows.without_ut, &picked),
                residual_ut: pick(&rows.with_ut, &picked),
                columns: values_of,
            },
            against: against_all,
        }
    }

    fn times(&self, rows: &[usize], picked: &[usize]) -> Vec<f32> {
        let Some(time) = self.table.time_s else { return Vec::new() };
        picked.iter().filter_map(|&i| time.get(*rows.get(i)?)).map(|t| *t as f32).collect()
    }

    /// Time, attitude, rate of turn and every column, a value a sample.
    fn columns(&self, rows: &Rows) -> Vec<(String, &'static str, Vec<f64>)> {
        let mut columns = Vec::new();
        if let Some(time) = self.table.time_s {
            columns.push(("time".to_string(), "s", rows.row.iter().map(|&row| time[row]).collect()));
        }
        let angle = |of: &dyn Fn([f64; 3]) -> f64| -> Vec<f64> {
            rows.corrected_ut.iter().map(|v| of(*v).to_degrees()).collect()
        };
        columns.push(("azimuth in sensor axes".into(), "°", angle(&|v| v[1].atan2(v[0]))));
        columns.push((
            "elevation in sensor axes".into(),
            "°",
            angle(&|v| (-v[2] / norm(v)).clamp(-1.0, 1.0).asin()),
        ));
        if let Some(gyro) = &self.table.gyro_radps {
            let rate = |row: &usize| norm(gyro.map(|axis| axis[*row])).to_degrees();
            columns.push(("rate of turn".into(), "°/s", rows.row.iter().map(rate).collect()));
        }
        for column in &self.table.covariates {
            let values = rows.row.iter().map(|&row| column.values[row]).collect();
            columns.push((column.name.to_string(), "", values));
        }
        columns
    }

    fn timeline(&self, time_s: &[f64], rows: &Rows) -> Option<Timeline> {
        let pieces = Pieces::of(time_s)?;
        let (mut dip, mut heading) = (vec![f64::NAN; rows.row.len()], vec![f64::NAN; rows.row.len()]);
        let mut downs = self.samples.iter().flat_map(|all| all.row.iter().zip(&all.readings)).peekable();
        for (index, (&row, corrected)) in rows.row.iter().zip(&rows.corrected_ut).enumerate() {
            while downs.next_if(|(at, _)| **at < row).is_some() {}
            let Some((_, reading)) = downs.next_if(|(at, _)| **at == row) else { continue };
            let Some(down) = reading.down else { continue };
            let sine = corrected.iter().zip(down).map(|(a, b)| a * b).sum::<f64>() / norm(*corrected);
            dip[index] = sine.clamp(-1.0, 1.0).asin().to_degrees();
            let truth = self.table.heading_deg.and_then(|truth| truth.get(row)).filter(|v| v.is_finite());
            if let (Some(truth), Some(own)) = (truth, heading_deg(*corrected, down)) {
                heading[index] = difference_deg(own, *truth);
            }
        }
        let any = |values: &[f64]| values.iter().any(|value| value.is_finite());
        Some(Timeline {
            measured_ut: pieces.band(rows.measured_ut.iter().map(|v| norm(*v))),
            without_ut: pieces.band(rows.without_ut.iter().copied()),
            residual_ut: pieces.band(rows.with_ut.iter().copied()),
            dip_deg: any(&dip).then(|| pieces.band(dip)),
            heading_error_deg: any(&heading).then(|| pieces.band(heading)),
            at_s: pieces.at_s,
        })
    }
}

/// At most so many of `count`, evenly.
fn picked(count: usize) -> Vec<usize> {
    let step = (count as f64 / MOST_POINTS as f64).max(1.0);
    (0..count.min(MOST_POINTS)).map(|i| (i as f64 * step) as usize).collect()
}

fn pick(values: &[f64], picked: &[usize]) -> Vec<f32> {
    picked.iter().filter_map(|&i| values.get(i)).map(|value| *value as f32).collect()
}

fn axes(vectors: &[[f64; 3]], picked: &[usize]) -> [Vec<f32>; 3] {
    [0, 1, 2].map(|axis| picked.iter().filter_map(|&i| vectors.get(i)).map(|v| v[axis] as f32).collect())
}
