//! Whether the effects that were asked for are ones that this log allows.

use crate::effects::Id;
use crate::outcome::request::Refusal;
use crate::table::Table;
use ironout::effect::ColumnName;
use ironout::extended::MAX_EFFECTS;

/// Every id must be one that a calibration can carry, at most once, with its column in the log.
///
/// # Errors
/// The first that is not.
pub fn check(table: &Table, ids: &[String]) -> Result<(), Refusal> {
    if ids.len() > MAX_EFFECTS {
        return Err(Refusal::TooMany { given: ids.len(), most: MAX_EFFECTS });
    }
    for (index, id) in ids.iter().enumerate() {
        if id == "misalignment" || id == "axis-order" {
            return Err(Refusal::cannot_add(
                id,
                "this is no effect to add: with an accelerometer in the log (ax_mps2,ay_mps2,az_mps2) the alignment is always \
                 part of the fit",
            ));
        }
        let Some(parts) = Id::parse(id) else {
            let why = format!("unknown effect; this log allows {}", known(table).join(", "));
            return Err(Refusal::cannot_add(id, why));
        };
        let at = |column: &str, why: String| {
            Err(Refusal::CannotAdd { id: id.clone(), column: Some(column.to_string()), why })
        };
        let timed = parts.delayed || ["drift", "step", "periodic"].contains(&parts.kind);
        let missing = [
            (timed && table.time_s.is_none(), "t_s", "it needs the time, and the log has no time column"),
            (
                parts.kind == "lag" && table.gyro_radps.is_none(),
                "gx_radps",
                "it needs the rate of turn, which is not in the log",
            ),
        ];
        if let Some((_, column, why)) = missing.into_iter().find(|(is_missing, ..)| *is_missing) {
            return at(column, why.into());
        }
        if ids[..index].contains(id) {
            return Err(Refusal::cannot_add(id, "given twice"));
        }
        let Some(column) = parts.column else { continue };
        let bad = |why: String| at(column, why);
        let Some(covariate) = table.covariate(column) else {
            let names: Vec<&str> = table.covariates.iter().map(|c| c.name).collect();
            return bad(format!(
                "the log has no such column; the columns that effects may follow are {}",
                if names.is_empty() { "none".to_string() } else { names.join(", ") }
            ));
        };
        let values = || covariate.values.iter().copied().filter(|value| value.is_finite());
        let least = values().fold(f64::INFINITY, f64::min);
        let most = values().fold(f64::NEG_INFINITY, f64::max);
        if covariate.not_finite > 0 {
            return bad(format!("{} of its cells are NaN or infinite", covariate.not_finite));
        }
        let empty = covariate.values.iter().filter(|value| !value.is_finite()).count();
        if 2 * empty > table.rows() {
            return bad(format!("it is empty in {empty} of {} rows", table.rows()));
        }
        if most - least <= 1e-9 * most.abs().max(least.abs()) {
            return bad(format!("it is constant ({least}): record a log in which it changes"));
        }
        if let Err(error) = ColumnName::new(column) {
            return bad(format!("{error}; take it by another name with --map"));
        }
    }
    Ok(())
}

/// The ids that the columns of this log allow.
pub fn known(table: &Table) -> Vec<String> {
    let mut known = Vec::new();
    for column in &table.covariates {
        let name = column.name;
        known.extend([format!("offset:{name}"), format!("offset:{name}^2")]);
        if table.time_s.is_some() {
            known.push(format!("offset:{name}@delay"));
        }
        known.extend([format!("gain:{name}"), format!("field:{name}")]);
    }
    if table.time_s.is_some() {
        known.extend(["drift", "step", "periodic"].map(String::from));
    }
    if table.gyro_radps.is_some() {
        known.push("lag".into());
    }
    known.extend(["nonlinearity", "cross-axis"].map(String::from));
    known
}
