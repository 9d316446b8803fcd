//! Columns that cause nothing, known by what they are: copies of the field, headings computed from it, orientations, other times and
//! numbers of the rows. Whoever searches for a cause leaves them out, and says so.

use crate::plausible::copies::{CopyOf, FieldCopy, field_copies};
use crate::plausible::heading;
use crate::plausible::orientation;
use crate::table::Table;

/// A time in another unit repeats the time to this share of the log's length.
const SAME_TIME: f64 = 1e-6;
/// Fewer rows say nothing.
const LEAST: usize = 20;

/// A column that causes nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct NoCause {
    /// Index into the covariates.
    pub covariate: usize,
    /// What it is, as the end of a sentence that begins with its name.
    pub what: String,
}

/// The covariates that cause nothing.
pub fn no_causes(table: &Table) -> Vec<NoCause> {
    let copies = field_copies(table);
    let mut found: Vec<NoCause> = copies.iter().map(no_cause).collect();
    let smoothed = copies_of_axes(table, &copies);
    let columns: Vec<&[f64]> = table.covariates.iter().map(|named| named.values).collect();
    let mut covariate = 0;
    while covariate < columns.len() {
        let rest = columns.get(covariate..).unwrap_or_default();
        let mut width = 1;
        if let Some(form) = orientation::beginning_with(rest) {
            width = form.width();
            for place in covariate..covariate + width {
                note(&mut found, place, || format!("a part of {}", form.words()));
            }
        } else if let Some(values) = rest.first() {
            if is_time(table, values) {
                note(&mut found, covariate, || "another time or a row number".to_string());
            } else if is_step(table, values) {
                note(&mut found, covariate, || "a time step".to_string());
            } else if is_angle(values) && heading::is_computed(table, values, &smoothed) {
                note(&mut found, covariate, || "a heading computed from this field".to_string());
            }
        }
        covariate += width;
    }
    found.sort_by_key(|one| one.covariate);
    found
}

/// Whether the log's own heading is computed from its field.
pub fn heading_is_computed(table: &Table) -> bool {
    let Some(heading_deg) = table.heading_deg else { return false };
    heading::is_computed(table, heading_deg, &copies_of_axes(table, &field_copies(table)))
}

fn copies_of_axes<'a>(table: &Table<'a>, copies: &[FieldCopy]) -> Vec<&'a [f64]> {
    /// More columns than these are not axes of two smoothed fields.
    const MOST: usize = 6;
    let axes = copies.iter().filter(|copy| copy.of == CopyOf::Field);
    axes.filter_map(|copy| Some(table.covariates.get(copy.covariate)?.values)).take(MOST).collect()
}

fn note(found: &mut Vec<NoCause>, covariate: usize, what: impl Fn() -> String) {
    if !found.iter().any(|one| one.covariate == covariate) {
        found.push(NoCause { covariate, what: what() });
    }
}

fn no_cause(copy: &FieldCopy) -> NoCause {
    let percent = (1000.0 * copy.explained).floor() / 10.0;
    let what = match (copy.of, copy.filtered) {
        (CopyOf::Field, false) => format!("a copy of the field, which explains {percent} % of it"),
        (CopyOf::Field, true) => {
            format!("a filtered or delayed copy of the field (R² {percent} %)")
        }
        (CopyOf::Magnitude, false) => format!("the magnitude of the field, which explains {percent} % of it"),
        (CopyOf::Magnitude, true) => {
            format!("a filtered or delayed copy of the field's magnitude (R² {percent} %)")
        }
    };
    NoCause { covariate: copy.covariate, what }
}

/// Whether a column is the time in another unit, or the number of the row.
fn is_time(table: &Table, values: &[f64]) -> bool {
    let rows: Vec<f64> = (0..values.len()).map(|row| row as f64).collect();
    let by = |clock: &[f64], is_unit: fn(f64) -> bool| {
        let (Some(from), Some(to), Some(first), Some(last)) =
            (clock.first(), clock.last(), values.first(), values.last())
        else {
            return false;
        };
        let slope = (last - first) / (to - from);
        let near = |(time, value): (&f64, &f64)| {
            (value - first - slope * (time - from)).abs() <= SAME_TIME * (last - first).abs()
        };
        slope > 0.0 && slope.is_finite() && is_unit(slope) && clock.iter().zip(values).all(near)
    };
    let is_power_of_ten = |slope: f64| {
        let power = slope.log10();
        (power - power.round()).abs() < SAME_TIME
    };
    values.len() >= LEAST
        && (by(&rows, |slope| slope == 1.0) || table.time_s.is_some_and(|time| by(time, is_power_of_ten)))
}

/// Whether a column is the time since the row before.
fn is_step(table: &Table, values: &[f64]) -> bool {
    let Some(time) = table.time_s.filter(|_| values.len() >= LEAST) else { return false };
    let steps = time.windows(2).zip(values.iter().skip(1));
    let mut varies = false;
    let first = values.get(1).copied().unwrap_or(f64::NAN);
    let mut scale = None;
    for (pair, value) in steps {
        let step = pair[1] - pair[0];
        if step <= 0.0 || !(*value > 0.0) {
            return false;
        }
        let scale = *scale.get_or_insert(value / step);
        if (value / step / scale - 1.0).abs() > 1e-3 {
            return false;
        }
        varies |= (value - first).abs() > 1e-2 * first;
    }
    // A constant next to an even clock proves nothing, and tests nothing either.
    varies
}

/// Whether all values can be degrees or radians of a circle.
fn is_angle(values: &[f64]) -> bool {
    values.iter().filter(|value| value.is_finite()).all(|value| (-360.5..=360.5).contains(value))
}
