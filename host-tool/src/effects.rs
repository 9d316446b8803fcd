//! Effects of a calibration on this side: between the file, the core, and the columns of a log.

use crate::cal_file::EffectEntry;
use crate::diagnose::samples::{delayed, filled};
use crate::failure::{Failure, Outcome};
use crate::input::Log;
use ironout::effect::{
    AmbientField, BuiltIn, ColumnName, CrossAxis, Drift, Eddy, Effect, Gain, Lag, MAX_COEFFICIENTS,
    MAX_INPUTS, Nonlinearity, Offset, Periodic, Power, Step, TIME,
};
use ironout::extended::{Conditions, ExtendedCalibration, FittedEffect, NotCorrected};

/// The id of an effect, taken apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Id<'a> {
    /// `offset`, `gain`, `field`, or the whole id where it names no column.
    pub kind: &'a str,
    /// The column, where there is one.
    pub column: Option<&'a str>,
    /// `^2`.
    pub squared: bool,
    /// `@delay`.
    pub delayed: bool,
}

impl<'a> Id<'a> {
    /// Takes an id apart; `None` if there is no effect of that kind.
    pub fn parse(id: &'a str) -> Option<Self> {
        let plain = ["drift", "step", "lag", "nonlinearity", "cross-axis", "periodic"];
        if plain.contains(&id) {
            return Some(Id { kind: id, column: None, squared: false, delayed: false });
        }
        let (kind, column) = id.split_once(':')?;
        let (column, squared) = column.strip_suffix("^2").map_or((column, false), |column| (column, true));
        let (column, delayed) =
            column.strip_suffix("@delay").map_or((column, false), |column| (column, true));
        let known = kind == "offset" || (["gain", "field"].contains(&kind) && !squared && !delayed);
        (known && !column.is_empty()).then_some(Id { kind, column: Some(column), squared, delayed })
    }
}

/// The effect of the core that an entry of a calibration file stands for.
///
/// # Errors
/// What is wrong with the entry, in words.
pub fn from_entry(entry: &EffectEntry) -> Result<FittedEffect<f64>, String> {
    let id = &entry.id;
    let parts = Id::parse(id).ok_or_else(|| format!("there is no effect {id}"))?;
    let parameter =
        |name: &str| entry.parameters.get(name).copied().ok_or_else(|| format!("{id} has no {name}"));
    let reference = |column: &str| {
        entry.reference.get(column).copied().ok_or_else(|| format!("{id} has no reference for {column}"))
    };
    let column = || -> Result<(ColumnName, f64), String> {
        let name = parts.column.unwrap_or_default();
        Ok((ColumnName::new(name).map_err(|error| format!("{id}: {error}"))?, reference(name)?))
    };
    let effect = match parts.kind {
        "offset" => {
            let (column, value) = column()?;
            let (power, reference) =
                if parts.squared { (Power::Squared, value * value) } else { (Power::Linear, value) };
            let delay_s = if parts.delayed { Some(parameter("delay_s")?) } else { None };
            BuiltIn::Offset(Offset { column, reference, power, delay_s })
        }
        "gain" => column().map(|(column, reference)| BuiltIn::Gain(Gain { column, reference }))?,
        "field" => column().map(|(column, reference)| BuiltIn::Field(AmbientField { column, reference }))?,
        "drift" => BuiltIn::Drift(Drift { reference_s: reference(TIME)? }),
        "step" => BuiltIn::Step(Step { at_s: parameter("at_s")? }),
        "periodic" => BuiltIn::Periodic(Periodic {
            frequency_hz: parameter("frequency_hz")?,
            reference_s: reference(TIME)?,
        }),
        "lag" if entry.coefficients.len() == 1 => BuiltIn::Lag(Lag),
        "lag" => BuiltIn::Eddy(Eddy),
        "nonlinearity" => BuiltIn::Nonlinearity(Nonlinearity),
        _ => BuiltIn::CrossAxis(CrossAxis),
    };
    let k = Effect::<f64>::coefficients(&effect);
    if entry.coefficients.len() != k || entry.std_errors.len() != k {
        return Err(format!("{id} has {k} coefficients and as many standard errors"));
    }
    let padded = |values: &[f64]| {
        let mut out = [0.0; MAX_COEFFICIENTS];
        out[..k].copy_from_slice(values);
        out
    };
    let errors: Vec<f64> = entry.std_errors.iter().map(|error| error.unwrap_or(f64::NAN)).collect();
    let (coefficients, std_errors) = (padded(&entry.coefficients), padded(&errors));
    Ok(FittedEffect { effect, coefficients, std_errors })
}

/// Corrects the rows of one log: every column of every effect at hand, at the time at which it acts.
pub struct Corrector<'a> {
    calibration: ExtendedCalibration,
    log: &'a Log,
    /// For each effect the values of its columns, a row each.
    inputs: Vec<[Option<Vec<f64>>; MAX_INPUTS]>,
    turn_radps: Option<[Vec<f64>; 3]>,
}

impl<'a> Corrector<'a> {
    /// Finds what the calibration's effects need in the log. A cell that is empty is taken between its neighbours.
    ///
    /// # Errors
    /// The column that is missing, empty or not finite, and the effect that needs it.
    pub fn new(calibration: ExtendedCalibration, log: &'a Log) -> Outcome<Self> {
        let mut inputs = Vec::new();
        let mut turn_radps = None;
        for fitted in calibration.effects.iter() {
            let id = ironout::effect::Id(&fitted.effect).to_string();
            let missing = |column: &str, why: &str| {
                Failure::usage(format!("{why}; the calibration's effect {id} needs it"))
                    .in_file(&log.path)
                    .at_column(column)
            };
            let mut own: [Option<Vec<f64>>; MAX_INPUTS] = Default::default();
            for (slot, column) in own.iter_mut().zip(fitted.effect.columns()) {
                let Some(column) = column else { continue };
                if column.name == TIME {
                    let time = log.time_s.clone();
                    *slot = Some(time.ok_or_else(|| missing(TIME, "the log has no time column"))?);
                    continue;
                }
                let covariate = log.covariate(column.name).ok_or_else(|| {
                    let names: Vec<&str> = log.covariates.iter().map(|c| c.name.as_str()).collect();
                    let has = if names.is_empty() { "none".into() } else { names.join(", ") };
                    missing(column.name, &format!("the log has no such column (of that kind it has {has})"))
                })?;
                if covariate.not_finite > 0 {
                    return Err(missing(column.name, "some of its cells are NaN or infinite"));
                }
                let filled = filled(&covariate.values)
                    .ok_or_else(|| missing(column.name, "every cell of it is empty"))?;
                let delay_s = column.delay_s;
                *slot = Some(if delay_s > 0.0 {
                    let time = log.time_s.as_ref();
                    delayed(
                        &filled,
                        time.ok_or_else(|| missing(TIME, "the log has no time column"))?,
                        delay_s,
                    )
                } else {
                    filled
                });
            }
            inputs.push(own);
            if fitted.effect.needs_gyro() {
                let axes = log.gyro_radps.as_ref();
                let axes = axes.ok_or_else(|| missing("gx_radps", "the log has no rate of turn"))?;
                let [x, y, z] = axes.each_ref().map(|axis| filled(axis));
                let all = x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]);
                turn_radps = Some(all.ok_or_else(|| missing("gx_radps", "every cell of it is empty"))?);
            }
        }
        Ok(Self { calibration, log, inputs, turn_radps })
    }

    /// What the user should know where effects go by the time: a log's clock is its own.
    pub fn notice(&self) -> Option<String> {
        let timed = |fitted: &&FittedEffect<f64>| fitted.effect.parts().time_reference_s().is_some();
        let names: Vec<String> = (self.calibration.effects.iter().filter(timed))
            .map(|fitted| ironout::effect::Id(&fitted.effect).to_string())
            .collect();
        (!names.is_empty()).then(|| {
            format!(
                "{} by this log's clock: right for a log on the same clock as the one it was fitted to",
                if names.len() == 1 {
                    format!("{} goes", names[0])
                } else {
                    format!("{} go", names.join(" and "))
                }
            )
        })
    }

    /// The calibration.
    pub fn calibration(&self) -> &ExtendedCalibration {
        &self.calibration
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
        self.calibration.apply(self.log.field(row), &self.conditions(row))
    }

    /// The corrected field of one row, µT; a failure that names the row.
    pub fn field(&self, row: usize) -> Outcome<[f64; 3]> {
        self.correct(row).map_err(|error| {
            Failure::usage(format!("row {} cannot be corrected: {error}", row + 1)).in_file(&self.log.path)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_taken_apart() {
        let parts = |id| Id::parse(id).map(|p| (p.kind, p.column, p.squared, p.delayed));
        assert_eq!(parts("offset:temp_c"), Some(("offset", Some("temp_c"), false, false)));
        assert_eq!(parts("offset:a@delay^2"), Some(("offset", Some("a"), true, true)));
        assert_eq!(parts("lag"), Some(("lag", None, false, false)));
        for unknown in
            ["", "offset", "offset:", "gain:x^2", "field:x@delay", "Lag", "wobble:x", "misalignment"]
        {
            assert_eq!(parts(unknown), None, "{unknown}");
        }
    }
}
