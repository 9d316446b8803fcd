//! Another magnetometer of the log next to the one that is studied.

use crate::fit::run::fit;
use crate::outcome::request::Options;
use crate::table::Table;
use crate::unlogged::pair::{Pair, pair};

/// Fewest rows in which both are known.
const MIN_ROWS: usize = 200;

/// Compares both. `None` without another, if one of them cannot be calibrated from this log, or if too few rows have both.
pub fn of_table(table: &Table, options: &Options) -> Option<Pair> {
    let other_ut = table.other_ut?;
    let rows: Vec<usize> = (0..table.rows())
        .filter(|row| {
            let mut axes = table.field_ut.iter().chain(&other_ut);
            axes.all(|axis| axis.get(*row).is_some_and(|value| value.is_finite()))
        })
        .collect();
    if rows.len() < MIN_ROWS {
        return None;
    }
    let taken = |column: &[f64]| rows.iter().map(|row| column[*row]).collect::<Vec<f64>>();
    let time_s = table.time_s.map(taken);
    let both = [table.field_ut.map(taken), other_ut.map(taken)];
    let deviations = both.each_ref().map(|field| deviation_ut(time_s.as_deref(), field, options));
    let [Some((first, field_ut)), Some((second, _))] = deviations else { return None };
    Some(pair(&first, &second, field_ut))
}

/// The deviation of the corrected magnitude from its mean in each row, and the field, µT.
fn deviation_ut(time_s: Option<&[f64]>, field: &[Vec<f64>; 3], options: &Options) -> Option<(Vec<f64>, f64)> {
    let table = Table { time_s, field_ut: field.each_ref().map(Vec::as_slice), ..Table::default() };
    let options =
        Options { method: options.method, field_ut: options.field_ut, search: false, ..Options::default() };
    let calibration = fit(&table, &options).ok()?.solution?.calibration;
    let mut deviations: Vec<f64> = (0..field[0].len())
        .map(|row| {
            let [x, y, z] = calibration.apply([0, 1, 2].map(|axis: usize| field[axis][row]));
            (x * x + y * y + z * z).sqrt() - calibration.field_ut
        })
        .collect();
    let mean = deviations.iter().sum::<f64>() / deviations.len() as f64;
    deviations.iter_mut().for_each(|one| *one -= mean);
    Some((deviations, calibration.field_ut))
}
