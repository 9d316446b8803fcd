//! The samples of a study: repeated triples dropped, faulty rows set aside, long logs thinned.

use crate::calibration::STANDARD_GRAVITY_MPS2;
use crate::samples::gravity;
use crate::samples::pairs::pairs;
use crate::samples::work::Work;
use crate::table::{Follows, Named, Table};
use crate::track::Place;
use ironout::effect::Past;
use ironout::extended::LowPass;
use ironout::study::Observation;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A study searches over at most this many samples; a longer log is thinned evenly.
pub const MOST_SAMPLES: usize = 40_000;

/// A covariate at the samples.
#[derive(Debug, Clone)]
pub struct Column {
    /// Name in the log.
    pub name: String,
    /// Values at the samples.
    pub values: Vec<f64>,
    /// Mean over the samples.
    pub mean: f64,
    /// Mean square over the samples.
    pub mean_square: f64,
    /// Where its effects are zero: the mean, which keeps them apart from the base; the value at rest where the base is
    /// known for that state.
    pub reference: f64,
    /// The same of its square.
    pub reference_square: f64,
    /// Whether it is missing in most samples, or no number in some.
    pub lacks: bool,
    /// Why it cannot be tested.
    pub problem: Option<String>,
    /// Whether it causes nothing, whatever it does: a copy of the field, an orientation, another time.
    pub causes_nothing: bool,
}

/// How a column was while a calibration was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// Its mean.
    pub mean: f64,
    /// The mean of its square.
    pub mean_square: f64,
}

impl Condition {
    /// Whether a column can be so: larger than 10¹⁵ is none, in any unit.
    pub fn is_sound(&self) -> bool {
        self.mean.abs() <= 1e15 && (0.0..=1e30).contains(&self.mean_square)
    }
}

/// A column that is further from where it was than so many times its own spread in a log says nothing of how it acts.
const FAR: f64 = 1e3;

/// What a study runs over.
#[derive(Debug, Clone)]
pub struct Samples {
    /// Time, s.
    pub time: Option<Vec<f64>>,
    /// Mean time of the first and the last sample, s.
    pub middle_s: f64,
    /// Vectors, rates and directions down.
    pub readings: Vec<Observation<f64>>,
    /// Where on the track each was taken; empty where the field is one field.
    pub places: Vec<Place>,
    /// Covariates.
    pub columns: Vec<Column>,
    /// Each two of them by the name that a product has.
    pub pairs: Arc<Vec<String>>,
    /// Row of the log of each sample.
    pub row: Vec<usize>,
    /// Every how many unique rows one sample was kept.
    pub stride: usize,
    /// Axes that carry data of their own.
    pub axes: [bool; 3],
    /// How much was looked at.
    pub work: Work,
    /// Second moment of the zero error that the accelerometer is expected to have, (m/s²)².
    pub zero_error_square: Matrix3<f64>,
    /// Covariance of the zero error of the gyro where directions down come of it, (rad/s)².
    pub gyro_zero_covariance: Matrix3<f64>,
    /// How each direction down follows the errors of accelerometer and gyro; empty where it is the accelerometer's own.
    pub follows: Vec<Option<Follows>>,
}

/// Rows that begin a run of equal field triples: a log faster than its sensor repeats them.
pub fn unique_rows(table: &Table) -> Vec<usize> {
    (0..table.rows()).filter(|&row| row == 0 || table.field(row) != table.field(row - 1)).collect()
}

/// At most `most` of these rows, evenly, and every how many one was kept. The place within each stride wanders, so that
/// thinning does not fold a high frequency onto a low one.
fn wandering(rows: &[usize], most: usize) -> (Vec<usize>, usize) {
    let stride = rows.len().div_ceil(most).max(1);
    let place = |index: usize, chunk: &[usize]| chunk[(index.wrapping_mul(2_654_435_761) >> 7) % chunk.len()];
    (rows.chunks(stride).enumerate().map(|(index, chunk)| place(index, chunk)).collect(), stride)
}

/// A column with fewer values is hardly more than a line.
const LEAST_CELLS: usize = 10;

/// Fills missing cells from their neighbours, linearly.
fn fill_gaps(values: &mut [f64]) {
    let mut last: Option<usize> = None;
    for i in 0..values.len() {
        if !values[i].is_finite() {
            continue;
        }
        match last {
            None => {
                let value = values[i];
                values[..i].fill(value);
            }
            Some(from) if i > from + 1 => {
                let (a, b) = (values[from], values[i]);
                for k in from + 1..i {
                    values[k] = a + (b - a) * (k - from) as f64 / (i - from) as f64;
                }
            }
            Some(_) => {}
        }
        last = Some(i);
    }
    if let Some(from) = last {
        let value = values[from];
        values[from..].fill(value);
    }
}

/// Why a column of the log cannot be tested, whatever its values, as the end of a sentence that begins with it. A slow one has values in few
/// rows, and is known between them.
pub fn lacks(values: &[f64], not_finite: usize) -> Option<String> {
    if not_finite > 0 {
        return Some(format!("has {not_finite} cells that are NaN or infinite"));
    }
    let known = values.iter().filter(|value| value.is_finite()).take(LEAST_CELLS).count();
    (known < LEAST_CELLS.min(values.len()))
        .then(|| format!("is empty in {} of {} rows", values.len() - known, values.len()))
}

/// A column at some rows of the log.
fn column(named: &Named, rows: &[usize]) -> Column {
    let name = named.name;
    let problem = lacks(named.values, named.not_finite).map(|why| format!("{name} {why}"));
    let lacks = problem.is_some();
    let mut values: Vec<f64> = rows.iter().map(|&row| named.values[row]).collect();
    // Most columns lack no cell, and those of a long log are not read whole to know it.
    if values.iter().any(|value| !value.is_finite())
        && let Some(whole) = filled(named.values)
    {
        values = rows.iter().map(|&row| whole[row]).collect();
    }
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let mean_square = values.iter().map(|value| value * value).sum::<f64>() / n;
    let spread = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt();
    let constant = !spread.is_finite() || spread <= 1e-9 * mean.abs().max(1e-12);
    let problem = problem.or_else(|| constant.then(|| format!("{name} is constant")));
    Column {
        name: name.to_string(),
        values,
        mean,
        mean_square,
        reference: mean,
        reference_square: mean_square,
        lacks,
        problem,
        causes_nothing: false,
    }
}

impl Samples {
    /// Mean of the measured vectors.
    pub fn mean_vector(&self) -> [f64; 3] {
        let n = self.len().max(1) as f64;
        let mut sum = [0.0; 3];
        for reading in &self.readings {
            for (total, value) in sum.iter_mut().zip(reading.measured_ut) {
                *total += value;
            }
        }
        sum.map(|value| value / n)
    }

    /// How the columns are that are there in most samples.
    pub fn conditions(&self) -> BTreeMap<String, Condition> {
        let condition = |column: &Column| Condition { mean: column.mean, mean_square: column.mean_square };
        let known = self.columns.iter().filter(|column| !column.lacks);
        let named = known.map(|column| (column.name.clone(), condition(column)));
        named.filter(|(_, condition)| condition.is_sound()).collect()
    }

    /// Takes the rows that are not left out.
    pub fn take(table: &Table, left_out: &[bool], axes: [bool; 3]) -> Samples {
        let unique: Vec<usize> = unique_rows(table).into_iter().filter(|&row| !left_out[row]).collect();
        let (row, stride) = wandering(&unique, MOST_SAMPLES);
        Samples::of_rows(table, row, stride, axes)
    }

    /// At most so many of these samples, evenly.
    pub fn thinned(&self, table: &Table, most: usize) -> Samples {
        let (row, stride) = wandering(&self.row, most);
        self.some(table, row, self.stride * stride)
    }

    /// Those of these samples that are of such rows.
    pub fn of_these(&self, table: &Table, row: Vec<usize>) -> Samples {
        self.some(table, row, self.stride)
    }

    fn some(&self, table: &Table, row: Vec<usize>, stride: usize) -> Samples {
        let mut few = Samples::of_rows(table, row, stride, self.axes);
        // The same effects, and so the same zeros of them.
        for (column, own) in few.columns.iter_mut().zip(&self.columns) {
            (column.reference, column.reference_square) = (own.reference, own.reference_square);
            column.problem.clone_from(&own.problem);
            column.causes_nothing = own.causes_nothing;
        }
        few.middle_s = self.middle_s;
        few
    }

    pub(super) fn of_rows(table: &Table, row: Vec<usize>, stride: usize, axes: [bool; 3]) -> Samples {
        let pick = |axis: &[f64]| -> Vec<f64> { row.iter().map(|&row| axis[row]).collect() };
        let triple = |axes: &[&[f64]; 3], row: usize| {
            let vector = axes.map(|axis| axis[row]);
            vector.iter().all(|value| value.is_finite()).then_some(vector)
        };
        let readings = row
            .iter()
            .map(|&row| Observation {
                measured_ut: table.field(row),
                turn_radps: table.gyro_radps.as_ref().and_then(|gyro| triple(gyro, row)),
                down: None,
            })
            .collect();
        let places = match &table.track {
            Some(track) => row.iter().map(|&row| track.place(row)).collect(),
            None => Vec::new(),
        };
        // A clock that stands still tells no time.
        let goes_on = |time: &Vec<f64>| time.first() < time.last();
        let time = table.time_s.map(pick).filter(goes_on);
        let middle_s =
            time.as_ref().map_or(0.0, |t| 0.5 * (t.first().unwrap_or(&0.0) + t.last().unwrap_or(&0.0)));
        let columns = table.covariates.iter().map(|named| column(named, &row)).collect();
        let pairs = pairs(&table.covariates.iter().map(|named| named.name).collect::<Vec<_>>());
        let quiet = gravity::quiet(table);
        let follows =
            quiet.map_or_else(Vec::new, |quiet| row.iter().map(|&row| quiet.follows(row)).collect());
        let mut samples = Samples {
            time,
            middle_s,
            readings,
            places,
            columns,
            pairs,
            row,
            stride,
            axes,
            work: Work::default(),
            zero_error_square: gravity::zero_error_square(table),
            gyro_zero_covariance: quiet.map_or_else(Matrix3::zeros, |quiet| quiet.gyro_zero_covariance),
            follows,
        };
        samples.find_down(table, 0.0);
        samples
    }

    /// Directions down, where the accelerometer measures little besides gravity.
    fn find_down(&mut self, table: &Table, late_s: f64) {
        let Some(accel) = gravity::of_table(table) else { return };
        let norm = |a: [f64; 3]| (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
        let vectors: Vec<[f64; 3]> = self.row.iter().map(|&row| late(table, &accel, row, late_s)).collect();
        let mut norms: Vec<f64> =
            vectors.iter().map(|a| norm(*a)).filter(|n| n.is_finite() && *n > 0.0).collect();
        if norms.len() < 20 {
            return;
        }
        let gravity = crate::samples::series::median(&mut norms);
        let near = |n: f64| (n / gravity - 1.0).abs() < 0.1;
        let quiet = norms.iter().filter(|n| near(**n)).count() * 10 > 3 * norms.len();
        for (reading, a) in self.readings.iter_mut().zip(vectors) {
            let n = norm(a);
            reading.down = None;
            if n.is_finite() && n > 0.0 && (near(n) || !quiet) {
                reading.down = Some(a.map(|value| -value / n));
            }
        }
    }

    /// How the direction down of a sample follows the zero errors of accelerometer, rad per m/s², and gyro, rad per rad/s.
    pub fn down_follows(&self, sample: usize, down: &Vector3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
        let follows = self.follows.get(sample).copied().flatten();
        let (accel, gyro_s) = follows
            .map_or((Matrix3::identity(), Matrix3::zeros()), |follows| (follows.accel, follows.gyro_s));
        ((down * (down.transpose() * accel) - accel) / STANDARD_GRAVITY_MPS2, -down.cross_matrix() * gyro_s)
    }

    /// These samples with the effects of the columns zero where the columns rest.
    pub fn from_rest(&self) -> Samples {
        let mut samples = self.clone();
        for column in &mut samples.columns {
            let ends = column.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(*value), high.max(*value))
            });
            // The nearest to zero that the column came: motors off, no current, or as little as there was.
            if ends.0 <= ends.1 {
                column.reference = 0.0_f64.clamp(ends.0, ends.1);
                column.reference_square = column.reference * column.reference;
            }
        }
        samples
    }

    /// These samples with the effects of these columns zero at these values of them, where the base is known.
    pub fn known_at(&self, conditions: &BTreeMap<String, Condition>) -> Samples {
        let mut samples = self.clone();
        for column in &mut samples.columns {
            let spread = (column.mean_square - column.mean * column.mean).max(0.0).sqrt();
            let near = |then: &&Condition| (then.mean - column.mean).abs() <= FAR * spread;
            if let Some(Condition { mean, mean_square }) = conditions.get(&column.name).filter(near) {
                (column.reference, column.reference_square) = (*mean, *mean_square);
            }
        }
        samples
    }

    /// The same samples with accelerometer and gyro as they were `late_s` earlier: what a magnetometer that is so late
    /// stands next to. `None` without time.
    pub fn beside_late(&self, table: &Table, late_s: f64) -> Option<Samples> {
        table.time_s?;
        let mut out = self.clone();
        if let Some(gyro) = &table.gyro_radps {
            for (reading, &row) in out.readings.iter_mut().zip(&self.row) {
                let turn = late(table, gyro, row, late_s);
                reading.turn_radps = turn.iter().all(|value| value.is_finite()).then_some(turn);
            }
        }
        out.find_down(table, late_s);
        // Before the log began nobody knows how they were.
        let (first, last) = (*table.time_s?.first()?, *table.time_s?.last()?);
        for (reading, &row) in out.readings.iter_mut().zip(&self.row) {
            let at = table.time_s?[row] - late_s;
            if at < first || at > last {
                reading.down = None;
                reading.turn_radps = None;
            }
        }
        Some(out)
    }

    /// The place of a sample on the track.
    pub fn place(&self, sample: usize) -> Place {
        self.places.get(sample).copied().unwrap_or(Place::MEAN)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.readings.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.readings.is_empty()
    }

    /// Mean time from one sample to the next, s; 0 without times.
    pub fn step_s(&self) -> f64 {
        let ends = self.time.as_ref().and_then(|time| Some(time.last()? - time.first()?));
        ends.map_or(0.0, |seconds| seconds / self.len().saturating_sub(1).max(1) as f64)
    }

    /// Bounds of `blocks` contiguous blocks of equal size.
    pub fn bounds(&self, blocks: usize) -> Vec<usize> {
        (0..=blocks).map(|k| self.len() * k / blocks).collect()
    }

    /// A past of a covariate, from all rows of the log, linearly between them.
    pub fn past(&self, table: &Table, name: &str, past: Past<f64>) -> Option<Vec<f64>> {
        let time = table.time_s?;
        let named = table.covariates.iter().find(|named| named.name == name)?;
        let of = |values: &[f64]| past_of(values, time, self.row.iter().copied(), past);
        // A delay looks at a few cells of a column, of which hardly any is missing; a filter looks at all.
        let as_is = match past {
            Past::LowPass(_) => None,
            Past::Now | Past::Delayed(_) => {
                Some(of(named.values)).filter(|v| v.iter().all(|v| v.is_finite()))
            }
        };
        as_is.or_else(|| Some(of(&filled(named.values)?)))
    }
}

/// Three axes of another sensor as they were `late_s` before this row.
fn late(table: &Table, axes: &[&[f64]; 3], row: usize, late_s: f64) -> [f64; 3] {
    axes.map(|axis| match table.time_s {
        Some(time) if late_s != 0.0 => delayed(axis, time, row, late_s),
        _ => axis[row],
    })
}

/// A column with missing cells taken from their neighbours, linearly; `None` if all are missing.
pub fn filled(values: &[f64]) -> Option<Cow<'_, [f64]>> {
    if values.iter().all(|value| value.is_finite()) && !values.is_empty() {
        return Some(Cow::Borrowed(values));
    }
    values.iter().any(|value| value.is_finite()).then(|| {
        let mut values = values.to_vec();
        fill_gaps(&mut values);
        Cow::Owned(values)
    })
}

/// A past of a column without missing cells at these rows, which follow each other.
pub fn past_of(
    values: &[f64],
    time_s: &[f64],
    rows: impl Iterator<Item = usize>,
    past: Past<f64>,
) -> Vec<f64> {
    match past {
        Past::Now => rows.map(|row| values[row]).collect(),
        Past::Delayed(delay_s) => {
            // Of an even clock the place of a row is as far from that of the row before as the rows are apart.
            let mut before: Option<(usize, usize)> = None;
            rows.map(|row| {
                let near = before.map_or(row, |(row_before, at)| at + row.saturating_sub(row_before));
                let at = last_before(time_s, near.min(time_s.len() - 1), time_s[row] - delay_s);
                before = Some((row, at));
                between(values, time_s, at, time_s[row] - delay_s)
            })
            .collect()
        }
        Past::LowPass(time_constant_s) => {
            let mut filter = LowPass::<f64>::new(time_constant_s);
            let filtered: Vec<f64> = values
                .iter()
                .zip(time_s)
                .map(|(value, now)| filter.push(*now, *value).unwrap_or(*value))
                .collect();
            rows.map(|row| filtered[row]).collect()
        }
    }
}

/// The last row at or before a time, 0 where there is none: near `row`, by steps that double.
fn last_before(time_s: &[f64], row: usize, wanted: f64) -> usize {
    let (mut low, mut high, mut reach) = (row, row + 1, 1);
    while low > 0 && time_s[low] > wanted {
        (low, high) = (low.saturating_sub(reach), low);
        reach *= 2;
    }
    while high < time_s.len() && time_s[high] <= wanted {
        (low, high) = (high, (high + reach).min(time_s.len()));
        reach *= 2;
    }
    low + time_s[low..high.min(time_s.len())].partition_point(|time| *time <= wanted).saturating_sub(1)
}

/// A column without missing cells `delay_s` before a row, linearly between the rows; before the log began, as in its first
/// row.
pub fn delayed(values: &[f64], time_s: &[f64], row: usize, delay_s: f64) -> f64 {
    let wanted = time_s[row] - delay_s;
    between(values, time_s, last_before(time_s, row, wanted), wanted)
}

/// A column at a time, `at` the last row at or before it.
fn between(values: &[f64], time_s: &[f64], at: usize, wanted: f64) -> f64 {
    let next = (at + 1).min(time_s.len() - 1);
    let (from, span) = (time_s[at], time_s[next] - time_s[at]);
    if wanted <= from || span <= 0.0 {
        values[at]
    } else {
        values[at] + (values[next] - values[at]) * (wanted - from) / span
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delayed_column_is_taken_between_its_rows() {
        let time: Vec<f64> = (0..10).map(|i| f64::from(i) * 0.1).collect();
        let values: Vec<f64> = (0..10).map(|i| f64::from(i * i)).collect();
        let late = |row: usize| delayed(&values, &time, row, 0.15);
        assert_eq!(late(0), 0.0);
        assert!((late(5) - 12.5).abs() < 1e-9, "{}", late(5));
    }

    #[test]
    fn missing_cells_lie_between_their_neighbours() {
        let gap = f64::NAN;
        let column = [gap, 1.0, gap, gap, 4.0, gap];
        let between = filled(&column);
        assert_eq!(between.as_deref(), Some([1.0, 1.0, 2.0, 3.0, 4.0, 4.0].as_slice()));
        assert_eq!(filled(&[gap, gap]), None);
    }
}
