//! Effects of a calibration: between its plain data and the core.

use crate::calibration::EffectEntry;
use ironout::calibration::Calibration;
use ironout::effect::{
    BuiltIn, ColumnName, Effect, Id, InParts, MAX_COEFFICIENTS, MAX_INPUTS, Made, Parts, Registry, Zero,
};
use ironout::extended::{ExtendedCalibration, FittedEffect, MAX_EFFECTS};
use std::collections::BTreeMap;

/// A calibration with effects of any family.
pub type Calibrated = ExtendedCalibration<f64, Made<ColumnName>>;

/// The same calibration with the effects in the type that the board and its records hold; `None` if one of them is none of
/// the library's.
pub fn of_library(calibration: &Calibrated) -> Option<ExtendedCalibration<f64>> {
    let mut out = ExtendedCalibration::plain(calibration.base);
    for FittedEffect { effect, coefficients, std_errors, ranges, bends } in calibration.effects.iter() {
        let effect = BuiltIn::of(effect.parts())?;
        let fitted = FittedEffect::new(effect, *coefficients, *std_errors);
        out.effects.push(fitted.over(*ranges).bending(*bends)).ok()?;
    }
    Some(out)
}

/// A calibration with the effects of these entries.
///
/// # Errors
/// What is wrong with an entry, in words; more of them than a calibration carries.
pub fn calibrated(
    base: Calibration<f64>,
    entries: &[EffectEntry],
    registry: Registry,
) -> Result<Calibrated, String> {
    let mut calibration = Calibrated::plain(base);
    for entry in entries {
        let fitted = from_entry(entry, registry)?;
        let too_many = |_| format!("it contains more than {MAX_EFFECTS} effects");
        calibration.effects.push(fitted).map_err(too_many)?;
    }
    Ok(calibration)
}

/// The entry of a calibration file that stands for an effect: the inverse of [`from_entry`].
pub fn entry<E: Effect<f64> + InParts>(fitted: &FittedEffect<f64, E>) -> EffectEntry {
    let FittedEffect { effect, coefficients, std_errors, ranges, bends } = fitted;
    let (parts, k) = (effect.parts(), effect.coefficients());
    let names: Vec<String> =
        effect.columns().iter().flatten().map(|column| column.name.to_string()).collect();
    // The column's value, not its square's.
    let of_column = |value: f64| if parts.form.is_squared() { value.max(0.0).sqrt() } else { value };
    let known: Option<BTreeMap<String, [f64; 2]>> =
        names.iter().zip(ranges).map(|(name, range)| Some((name.clone(), (*range)?))).collect();
    EffectEntry {
        id: Id(effect).to_string(),
        name: effect.name().to_string(),
        coefficients: coefficients.iter().take(k).copied().collect(),
        std_errors: std_errors.iter().take(k).map(|error| Some(*error).filter(|e| e.is_finite())).collect(),
        unit: effect.unit().to_string(),
        reference: names.first().cloned().zip(parts.reference().map(of_column)).into_iter().collect(),
        parameters: parts
            .parameter()
            .map(|(searched, value)| (searched.name().to_string(), value))
            .into_iter()
            .collect(),
        range: known,
        columns: names,
        bends: *bends,
    }
}

/// The effect that an entry of a calibration file stands for.
///
/// # Errors
/// What is wrong with the entry, in words.
pub fn from_entry(
    entry: &EffectEntry,
    registry: Registry,
) -> Result<FittedEffect<f64, Made<ColumnName>>, String> {
    let id = &entry.id;
    let named = registry.parse(id).ok_or_else(|| format!("there is no effect {id}"))?;
    let named = named.of_coefficients(entry.coefficients.len());
    let form = named.form;
    let mut parts = Parts::<ColumnName>::of(form);
    if form.column {
        parts.column = ColumnName::new(named.column).map_err(|error| format!("{id}: {error}"))?;
    }
    if form.zero != Zero::None {
        let columns =
            named.family.columns(&Parts { form, column: named.column, reference: 0.0, parameter: 0.0 });
        let column = columns.into_iter().flatten().next().map_or("", |column| column.name);
        let value = entry.reference.get(column).copied();
        let value = value.ok_or_else(|| format!("{id} has no reference for {column}"))?;
        parts.reference = if form.is_squared() { value * value } else { value };
    }
    if let Some(searched) = form.searched {
        let name = searched.name();
        parts.parameter = entry.parameters.get(name).copied().ok_or_else(|| format!("{id} has no {name}"))?;
    }
    let effect = Made::new(named.family, parts).ok_or_else(|| format!("there is no effect {id}"))?;
    let k = effect.coefficients();
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
    let mut ranges = [None; MAX_INPUTS];
    for (range, column) in ranges.iter_mut().zip(effect.columns()) {
        *range = column.zip(entry.range.as_ref()).and_then(|(column, known)| known.get(column.name).copied());
    }
    Ok(FittedEffect::new(effect, coefficients, std_errors).over(ranges).bending(entry.bends))
}
