//! Names that the id of an effect, and a calibration, can hold: what a column is called that has another.
//!
//! A name depends on the header alone, so that the same column of two logs has the same name.

use crate::input::log::Log;
use crate::input::map::entry;
use crate::input::names::{Meaning, meaning};
use crate::input::unit::{Quantity, Unit};
use crate::registry::REGISTRY;
use ironout::effect::{ColumnName, MAX_COLUMN_NAME};

/// A plain name, with the unit of the contract at its end.
pub fn name_of(header: &str, meaning: &Meaning, unit: Option<&Unit>) -> String {
    marked(header, meaning, unit, false)
}

/// The same with the mark of the header, if `always` or where the name is not all that the header says.
fn marked(header: &str, meaning: &Meaning, unit: Option<&Unit>, always: bool) -> String {
    let suffix = match unit.and_then(|unit| unit.quantity) {
        Some(Quantity::Temperature) => "_c",
        Some(Quantity::Current) => "_a",
        Some(Quantity::Voltage) => "_v",
        _ => return fitting(header, header, "", always),
    };
    let stem = if meaning.stem.is_empty() { header } else { &meaning.stem };
    let axis = meaning.axis.map_or(String::new(), |axis| format!("_{axis}"));
    fitting(stem, header, &format!("{axis}{suffix}"), always)
}

/// Letters, digits and low lines of a stem, with an end.
fn fitting(stem: &str, header: &str, end: &str, always: bool) -> String {
    let name = plain(stem);
    let is_lost = always || stem.chars().any(|c| c.is_alphanumeric() && !c.is_ascii());
    if !is_lost && name.len() + end.len() <= MAX_COLUMN_NAME {
        return name + end;
    }
    let end = format!("{}{end}", mark(header));
    let room = MAX_COLUMN_NAME.saturating_sub(end.len());
    let cut: String = name.chars().take(room).collect();
    format!("{}{end}", cut.trim_end_matches('_'))
}

fn plain(text: &str) -> String {
    let mut name = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_ascii_alphanumeric() || c == '_' {
            name.push(c);
        } else if !name.ends_with('_') && !name.is_empty() {
            name.push('_');
        }
    }
    let trimmed = name.trim_end_matches('_');
    if trimmed.is_empty() { "column".to_string() } else { trimmed.to_string() }
}

/// Four digits that another header hardly has (FNV-1a).
fn mark(header: &str) -> String {
    let hash =
        header.bytes().fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    format!("_{:04x}", (hash >> 16) ^ (hash & 0xffff))
}

/// Whether a calibration can hold the name, and the ids of its effects are told from those of other columns and forms.
fn is_followed(name: &str) -> bool {
    ColumnName::new(name).is_ok()
        && REGISTRY.families().filter(|family| family.forms().iter().any(|form| form.column)).all(|family| {
            let id = format!("{}:{name}", family.kind());
            REGISTRY.parse(&id).is_some_and(|named| named.column == name)
        })
}

/// Gives every covariate a name that effects can follow: a diagnosis names none that a fit would refuse.
pub fn rename(log: &mut Log) {
    let mut pins = Vec::new();
    for index in 0..log.covariates.len() {
        let old = log.covariates[index].name.clone();
        if is_followed(&old) {
            continue;
        }
        // Numbers stay as they are, and so does a unit that is not the contract's own.
        let meaning = meaning(&old);
        let unit = meaning.unit.as_ref().filter(|unit| unit.is_own());
        let mut new = name_of(&old, &meaning, unit);
        if log.covariate(&new).is_some() {
            new = marked(&old, &meaning, unit, true);
        }
        match log.read_as.columns.iter_mut().find(|column| column.name == old) {
            Some(column) => column.name.clone_from(&new),
            None => log.notices.push(format!("ironout reads column {old} as {new}")),
        }
        pins.push(entry(&new, &old, None));
        log.covariates[index].name = new;
    }
    // Another log is read by the same names.
    if log.read_as.own_csv && !pins.is_empty() {
        match log.read_as.pins.iter_mut().find(|(option, _)| option == "--map") {
            Some((_, all)) => *all = format!("{all},{}", pins.join(",")),
            None => log.read_as.pins.push(("--map".into(), pins.join(","))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::log::Covariate;

    fn named(headers: &[&str]) -> Vec<String> {
        let covariate =
            |name: &&str| Covariate { name: (*name).into(), values: Vec::new(), empty: 0, not_finite: 0 };
        let mut log = Log { covariates: headers.iter().map(covariate).collect(), ..Log::default() };
        rename(&mut log);
        log.covariates.into_iter().map(|covariate| covariate.name).collect()
    }

    #[test]
    fn every_name_is_one_that_a_calibration_holds() {
        let headers = [
            "temp_c",
            "x^2",
            "x_2",
            "motor current [A]",
            "motor current [mA]",
            "Temp [°C]",
            "Température du capteur",
            "v@delay",
            "vehicle_air_data.baro_temperature_celsius",
            "vehicle_air_data.baro_temperature_kelvin",
            "电流",
            "高度",
        ];
        let names = named(&headers);
        let ends = |name: &str| name.rsplit_once('_').map_or("", |(start, _)| start).to_string();
        assert_eq!(names[0], "temp_c");
        assert_eq!(names[2..5], ["x_2", "motor_current_a", "motor_current_mA"].map(String::from));
        assert!(names[5].starts_with("temp_") && names[5].ends_with("_c"), "{}", names[5]);
        assert!(names.iter().all(|name| is_followed(name)), "{names:?}");
        assert_eq!((ends(&names[1]), ends(&names[6])), ("x_2".into(), "Temp_rature_du_capteur".into()));
        let distinct: std::collections::BTreeSet<&String> = names.iter().collect();
        assert_eq!(distinct.len(), names.len(), "{names:?}");
    }

    #[test]
    fn a_name_does_not_depend_on_the_columns_beside_it() {
        for header in ["电流", "a_long_column_name_that_goes_on_and_on_current", "Température", "Fan [A]"]
        {
            let others = ["高度", "a_long_column_name_that_goes_on_and_on_height", "temp_c", header];
            assert_eq!(named(&[header])[0], named(&others)[3]);
        }
    }
}
