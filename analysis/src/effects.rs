//! Effects of a calibration: between its plain data and the core.

use crate::calibration::EffectEntry;
use ironout::effect::{
    AmbientField, BuiltIn, ColumnName, CrossAxis, Drift, Eddy, Effect, Gain, Lag, MAX_COEFFICIENTS,
    Nonlinearity, Offset, Periodic, Power, Step, TIME,
};
use ironout::extended::FittedEffect;

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
