//! Whether the effects that were asked for are ones that this log allows.

use crate::base::mounting;
use crate::outcome::request::Refusal;
use crate::samples::samples::lacks;
use crate::similar;
use crate::table::Table;
use ironout::effect::{ColumnName, Need, Registry};
use ironout::extended::MAX_EFFECTS;

/// Every id must be one that a calibration can carry, at most once, with its column in the log.
///
/// # Errors
/// The first that is not.
pub fn check(table: &Table, ids: &[String], registry: Registry) -> Result<(), Refusal> {
    if ids.len() > MAX_EFFECTS {
        return Err(Refusal::TooMany { given: ids.len(), most: MAX_EFFECTS });
    }
    for (index, id) in ids.iter().enumerate() {
        if mounting::is_one(id) {
            return Err(Refusal::cannot_add(id, mounting::NOT_TO_ADD));
        }
        let Some(named) = registry.parse(id) else {
            return Err(Refusal::cannot_add(id, similar::unknown_effect(id, &known(table, registry))));
        };
        let at = |column: &str, why: String| {
            Err(Refusal::CannotAdd { id: id.clone(), column: Some(column.to_string()), why })
        };
        if let Some(need) = named.family.need(named.form).filter(|need| !has(table, *need)) {
            return at(need.column(), need.refusal().into());
        }
        if ids[..index].contains(id) {
            return Err(Refusal::cannot_add(id, "given twice"));
        }
        let columns: Vec<&str> = named.columns().collect();
        if named.form.column && columns.is_empty() {
            let why = "expected two columns with a * between them, as in product:servo*current_a";
            return Err(Refusal::cannot_add(id, why));
        }
        for column in columns {
            fits(table, id, column)?;
        }
        if let Err(error) = ColumnName::new(named.column)
            && named.form.column
        {
            return at(named.column, format!("{error}. Fix: rename the columns with --map"));
        }
    }
    Ok(())
}

/// Whether a column may be followed.
fn fits(table: &Table, id: &str, column: &str) -> Result<(), Refusal> {
    let bad =
        |why: String| Err(Refusal::CannotAdd { id: id.to_string(), column: Some(column.to_string()), why });
    let Some(covariate) = table.covariate(column) else {
        let names: Vec<&str> = table.covariates.iter().map(|c| c.name).collect();
        let all = if names.is_empty() { "none".to_string() } else { names.join(", ") };
        let meant = similar::did_you_mean(column, names.iter().copied());
        let meant = meant.map_or(String::new(), |meant| format!(" {meant}"));
        return bad(format!("this log has no such column.{meant} Columns that effects can use: {all}"));
    };
    let values = || covariate.values.iter().copied().filter(|value| value.is_finite());
    let least = values().fold(f64::INFINITY, f64::min);
    let most = values().fold(f64::NEG_INFINITY, f64::max);
    if let Some(why) = lacks(covariate.values, covariate.not_finite) {
        return bad(format!("it {why}"));
    }
    if most - least <= 1e-9 * most.abs().max(least.abs()) {
        return bad(format!("it is constant ({least}). Fix: record a log in which it changes"));
    }
    if let Err(error) = ColumnName::new(column) {
        return bad(format!("{error}. Fix: rename it with --map"));
    }
    Ok(())
}

fn has(table: &Table, need: Need) -> bool {
    match need {
        Need::Time => table.time_s.is_some(),
        Need::Gyro => table.gyro_radps.is_some(),
    }
}

/// The ids that the columns of this log allow.
pub fn known(table: &Table, registry: Registry) -> Vec<String> {
    let mut known = Vec::new();
    let columns = table.covariates.iter().map(|column| column.name);
    registry.known(columns, |need| has(table, need), |named| known.push(named.to_string()));
    known
}
