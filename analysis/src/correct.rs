//! A calibration with effects on the rows of a log.

use crate::effects::Calibrated;
use crate::samples::clock::even;
use crate::samples::samples::{filled, past_of};
use crate::table::Table;
use ironout::calibration::norm;
use ironout::effect::{ColumnName, Effect, Follows, MAX_INPUTS, Made, Past, TIME};
use ironout::extended::{Conditions, FittedEffect, NotCorrected};
use std::borrow::Cow;

/// A column that an effect of the calibration needs and that the log does not have as it is needed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CannotCorrect {
    /// The column.
    pub column: String,
    /// What is wrong with it, and who needs it.
    pub why: String,
}

impl std::fmt::Display for CannotCorrect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "column {}: {}", self.column, self.why)
    }
}

impl std::error::Error for CannotCorrect {}

/// Ids of the effects that go by the time and change anything.
fn timed(calibration: &Calibrated) -> Vec<String> {
    let effects = calibration.effects.iter().filter(|fitted| is_timed(fitted));
    effects.map(|fitted| ironout::effect::Id(&fitted.effect).to_string()).collect()
}

fn is_timed(fitted: &FittedEffect<f64, Made<ColumnName>>) -> bool {
    fitted.effect.parts().time_reference_s().is_some()
        && fitted.coefficients.iter().any(|value| *value != 0.0)
}

/// A calibration for another log than it was fitted to: without what goes by the clock of that one, and the ids of that.
pub fn on_another_clock(calibration: &Calibrated) -> (Calibrated, Vec<String>) {
    let (mut left, ids) = (Calibrated::plain(calibration.base), timed(calibration));
    for fitted in calibration.effects.iter() {
        let mut fitted = *fitted;
        if is_timed(&fitted) {
            fitted.coefficients.fill(0.0);
        }
        // As many as there were.
        let _ = left.effects.push(fitted);
    }
    (left, ids)
}

/// Corrects the rows of one log: every column of every effect at hand, at the time at which it acts.
pub struct Corrector<'a> {
    calibration: Calibrated,
    table: &'a Table<'a>,
    /// For each effect the values of its columns, a row each.
    inputs: Vec<[Option<Vec<f64>>; MAX_INPUTS]>,
    turn_radps: Option<[Vec<f64>; 3]>,
}

impl<'a> Corrector<'a> {
    /// Finds what the calibration's effects need in the log. A cell that is empty is taken between its neighbours.
    ///
    /// # Errors
    /// The column that is missing, empty or not finite, and the effect that needs it.
    pub fn new(calibration: Calibrated, table: &'a Table<'a>) -> Result<Self, CannotCorrect> {
        let mut inputs = Vec::new();
        let mut turn_radps = None;
        for fitted in calibration.effects.iter() {
            let id = ironout::effect::Id(&fitted.effect).to_string();
            let missing = |column: &str, why: &str| CannotCorrect {
                column: column.to_string(),
                why: format!("{why}; the calibration's effect {id} needs it"),
            };
            let mut own: [Option<Vec<f64>>; MAX_INPUTS] = Default::default();
            // What changes nothing needs nothing.
            if fitted.coefficients.iter().all(|value| *value == 0.0) {
                inputs.push(own.map(|_| Some(vec![0.0; table.rows()])));
                continue;
            }
            for (slot, column) in own.iter_mut().zip(fitted.effect.columns()) {
                let Some(column) = column else { continue };
                if column.name == TIME {
                    let time = table.time_s.map(<[f64]>::to_vec);
                    *slot = Some(time.ok_or_else(|| missing(TIME, "the log has no time column"))?);
                    continue;
                }
                let covariate = table.covariate(column.name).ok_or_else(|| {
                    let names: Vec<&str> = table.covariates.iter().map(|c| c.name).collect();
                    let has = if names.is_empty() { "none".into() } else { names.join(", ") };
                    missing(
                        column.name,
                        &format!("this log has no such column (columns of this kind: {has})"),
                    )
                })?;
                if covariate.not_finite > 0 {
                    return Err(missing(column.name, "some of its cells are NaN or infinite"));
                }
                let filled = filled(covariate.values)
                    .ok_or_else(|| missing(column.name, "every cell of it is empty"))?;
                *slot = Some(match column.past {
                    Past::Now => filled.into_owned(),
                    past => {
                        let time = table.time_s.ok_or_else(|| missing(TIME, "the log has no time column"))?;
                        past_of(&filled, time, 0..table.rows(), past)
                    }
                });
            }
            inputs.push(own);
            if fitted.effect.needs_gyro() {
                let axes = table.gyro_radps.as_ref();
                let axes = axes.ok_or_else(|| missing("gx_radps", "the log has no gyro"))?;
                let [x, y, z] = axes.map(|axis| filled(axis).map(Cow::into_owned));
                let all = x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]);
                turn_radps = Some(all.ok_or_else(|| missing("gx_radps", "every cell of it is empty"))?);
            }
        }
        let mut out = Self { calibration, table, inputs, turn_radps };
        out.choose_clocks();
        Ok(out)
    }

    /// Tones are too fast for stamps of arrival: each goes by the even grid behind them where that leaves less.
    fn choose_clocks(&mut self) {
        let is_time = |fitted: &FittedEffect<f64, Made<ColumnName>>| {
            fitted.effect.columns().map(|column| column.is_some_and(|column| column.name == TIME))
        };
        let tones: Vec<(usize, [bool; MAX_INPUTS])> = (self.calibration.effects.iter().enumerate())
            .filter(|(_, fitted)| fitted.effect.family().follows() == Follows::Tone)
            .map(|(index, fitted)| (index, is_time(fitted)))
            .collect();
        let Some(grid) = self.table.time_s.filter(|_| !tones.is_empty()).and_then(even) else { return };
        let mut least = self.squares();
        for (index, is_time) in tones {
            let by_stamps = self.inputs[index].clone();
            for (slot, _) in self.inputs[index].iter_mut().zip(is_time).filter(|(_, is_time)| *is_time) {
                *slot = Some(grid.clone());
            }
            let squares = self.squares();
            match squares < least {
                true => least = squares,
                false => self.inputs[index] = by_stamps,
            }
        }
    }

    /// Sum of the squared residuals of the rows that can be corrected, µT².
    fn squares(&self) -> f64 {
        let residual = |row| Some(self.residual_ut(row, self.correct(row).ok()?));
        (0..self.table.rows()).filter_map(residual).filter(|r| r.is_finite()).map(|r| r * r).sum()
    }

    /// What the user should know where effects go by the time: a log's clock is its own.
    pub fn notice(&self) -> Option<String> {
        let names = timed(&self.calibration);
        (!names.is_empty()).then(|| {
            format!(
                "effects of time ({}) are correct only if this log has the clock of the log they were fitted to",
                if names.len() == 1 {
                    format!("{} goes", names[0])
                } else {
                    format!("{} go", names.join(" and "))
                }
            )
        })
    }

    /// The calibration.
    pub fn calibration(&self) -> &Calibrated {
        &self.calibration
    }

    /// The values of one column of one effect, a row each, at the time at which they act.
    pub(crate) fn column(&self, effect: usize, slot: usize) -> Option<&[f64]> {
        self.inputs.get(effect)?.get(slot)?.as_deref()
    }

    /// `‖corrected‖ − F` of the corrected field of one row, µT: on a journey with the field of that place.
    pub fn residual_ut(&self, row: usize, corrected_ut: [f64; 3]) -> f64 {
        norm(corrected_ut) - self.calibration.base.field_ut * self.table.place(row).share
    }

    /// The measured vector of one row, µT.
    pub(crate) fn measured_ut(&self, row: usize) -> [f64; 3] {
        self.table.field(row)
    }

    /// What one row was measured under.
    pub fn conditions(&self, row: usize) -> Conditions<f64> {
        let mut conditions = Conditions::unknown();
        conditions.turn_radps = self.turn_radps.as_ref().map(|axes| axes.each_ref().map(|axis| axis[row]));
        for (values, columns) in conditions.inputs.iter_mut().zip(&self.inputs) {
            for (value, column) in values.iter_mut().zip(columns) {
                if let Some(column) = column {
                    *value = column[row];
                }
            }
        }
        conditions
    }

    /// The corrected field of one row, µT.
    ///
    /// # Errors
    /// That of the core, which can only be [`NotCorrected::NotFinite`] here.
    pub fn correct(&self, row: usize) -> Result<[f64; 3], NotCorrected> {
        self.calibration.apply(self.table.field(row), &self.conditions(row))
    }
}
