//! Readings outside the range of a column over which a calibration's effect was fitted: how many, how far, and what the
//! standard errors of its coefficients make of the distance.

use crate::calibration::EffectEntry;
use crate::correct::Corrector;
use ironout::effect::Effect;
use ironout::extended::FittedEffect;
use serde::Serialize;

/// A column's rounding, over the width of its range: nearer than this is inside.
const ROUNDING: f64 = 1e-9;

/// Rows of a log outside the range that an effect was fitted over.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outside {
    /// The effect.
    pub effect: String,
    /// The column.
    pub column: String,
    /// How many rows lie outside.
    pub rows: usize,
    /// Rows of the log.
    pub of_rows: usize,
    /// The range, in the column's unit.
    pub range: [f64; 2],
    /// The reading furthest from it.
    pub furthest: f64,
    /// Error (1σ) there, µT: of the coefficients, and where it is held what the effect would change by from there on;
    /// `None` where it is not known.
    pub error_ut: Option<f64>,
    /// Error (1σ) that the coefficients' standard errors make at the end of the range, µT.
    pub error_at_range_ut: Option<f64>,
}

/// What a log asks of a calibration beyond what it was fitted over.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Extrapolation {
    /// Effects with readings outside their range.
    pub outside: Vec<Outside>,
    /// Effects of which the calibration does not say the range: it was written by an earlier program.
    pub unknown: Vec<String>,
}

impl Corrector<'_> {
    /// Holds the log's columns to the ranges in the entries of the calibration file, given in its order.
    pub fn extrapolation(&self, entries: &[EffectEntry]) -> Extrapolation {
        let mut found = Extrapolation::default();
        for (index, (fitted, entry)) in self.calibration().effects.iter().zip(entries).enumerate() {
            if fitted.coefficients.iter().all(|value| *value == 0.0) {
                continue;
            }
            for (slot, column) in fitted.effect.columns().into_iter().enumerate() {
                let Some(column) = column else { continue };
                match entry.range.as_ref().and_then(|ranges| ranges.get(column.name)) {
                    None => found.unknown.push(entry.id.clone()),
                    Some(&range) => {
                        let place = (index, slot);
                        found.outside.extend(self.beyond(fitted, place, &entry.id, column.name, range));
                    }
                }
            }
        }
        found
    }

    /// The rows whose column `place` (effect and slot) lies outside `range`.
    fn beyond<E: Effect<f64>>(
        &self,
        fitted: &FittedEffect<f64, E>,
        (effect, slot): (usize, usize),
        id: &str,
        column: &str,
        range: [f64; 2],
    ) -> Option<Outside> {
        let [least, most] = range;
        let values = self.column(effect, slot)?;
        let distance = |value: f64| (least - value).max(value - most);
        let far = |value: &f64| distance(*value) > ROUNDING * (most - least).abs();
        let rows = values.iter().filter(|value| far(value)).count();
        let (row, &furthest) = (values.iter().enumerate().filter(|(_, value)| far(value)))
            .max_by(|a, b| distance(*a.1).total_cmp(&distance(*b.1)))?;
        let error = |value: f64| {
            let mut inputs = self.conditions(row).inputs[effect];
            inputs[slot] = value;
            fitted.error_ut(&self.calibration().base, self.measured_ut(row), inputs)
        };
        Some(Outside {
            effect: id.to_string(),
            column: column.to_string(),
            rows,
            of_rows: values.len(),
            range,
            furthest,
            error_ut: error(furthest),
            error_at_range_ut: error(furthest.clamp(least, most)),
        })
    }
}

impl Outside {
    /// In words; `field_ut` is the calibration's.
    pub fn in_words(&self, field_ut: f64) -> String {
        let [least, most] = self.range.map(short);
        let error = match (self.error_ut, self.error_at_range_ut) {
            (Some(there), Some(here)) => format!(
                "Extrapolation error {there:.3} µT ({:.2} % of the field), {here:.3} µT at the end of the range; ironout \
                 extrapolates by at most the width of the range",
                100.0 * there / field_ut
            ),
            _ => "The extrapolation error is unknown; ironout extrapolates by at most the width of the range"
                .into(),
        };
        format!(
            "{} of {} rows have {} outside {least} … {most}, the range fitted for {}, up to {}. {error}",
            self.rows,
            self.of_rows,
            self.column,
            self.effect,
            short(self.furthest)
        )
    }
}

impl Extrapolation {
    /// What to tell the user, a sentence each.
    pub fn notices(&self, field_ut: f64) -> Vec<String> {
        let mut notices: Vec<String> = self.outside.iter().map(|one| one.in_words(field_ut)).collect();
        if !self.unknown.is_empty() {
            notices.push(format!(
                "the calibration (from an earlier program) does not state the range that {} was fitted over, so ironout \
                 cannot detect readings outside it",
                self.unknown.join(", ")
            ));
        }
        notices
    }
}

/// Four significant digits.
fn short(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if (-4..6).contains(&digits) {
        format!("{value:.*}", (3 - digits).max(0) as usize)
    } else {
        format!("{value:.3e}")
    }
}
