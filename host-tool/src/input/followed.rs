//! Names that the id of an effect, and a calibration, can hold: what a column is called that has another.

use crate::input::log::Log;
use crate::registry::REGISTRY;
use ironout::effect::{ColumnName, MAX_COLUMN_NAME};

/// A name of letters, digits and low lines for any header; the words stay.
pub fn plain(header: &str) -> String {
    let mut name = String::with_capacity(header.len());
    for c in header.chars() {
        if c.is_ascii_alphanumeric() || c == '_' {
            name.push(c);
        } else if !name.ends_with('_') && !name.is_empty() {
            name.push('_');
        }
    }
    let trimmed = name.trim_end_matches('_');
    if trimmed.is_empty() { "column".to_string() } else { trimmed.to_string() }
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
    for index in 0..log.covariates.len() {
        if is_followed(&log.covariates[index].name) {
            continue;
        }
        let old = log.covariates[index].name.clone();
        let plain = plain(&old);
        let cut = |tail: &str| -> String {
            plain.chars().take(MAX_COLUMN_NAME - tail.len()).chain(tail.chars()).collect()
        };
        let tails = (2..).map(|number| format!("_{number}"));
        let mut names = std::iter::once(String::new()).chain(tails).map(|tail| cut(&tail));
        let Some(new) = names.find(|name| log.covariate(name).is_none()) else { continue };
        match log.read_as.columns.iter_mut().find(|column| column.name == old) {
            Some(column) => column.name.clone_from(&new),
            None => log.notices.push(format!("column {old} is read as {new}")),
        }
        log.covariates[index].name = new;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::log::Covariate;

    #[test]
    fn every_name_is_one_that_a_calibration_holds() {
        let headers = [
            "temp_c",
            "x^2",
            "x_2",
            "motor current [A]",
            "Température du capteur",
            "v@delay",
            "vehicle_air_data.baro_temperature_celsius",
            "vehicle_air_data.baro_temperature_kelvin",
            "",
            "电流",
        ];
        let mut log = Log::default();
        log.covariates = headers
            .map(|name| Covariate { name: name.into(), values: Vec::new(), empty: 0, not_finite: 0 })
            .into();
        rename(&mut log);
        let names: Vec<&str> = log.covariates.iter().map(|covariate| covariate.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "temp_c",
                "x_2_2",
                "x_2",
                "motor_current_A",
                "Temp_rature_du_capteur",
                "v_delay",
                "vehicle_air_data_baro_temperatur",
                "vehicle_air_data_baro_temperat_2",
                "column",
                "column_2"
            ]
        );
        assert!(names.iter().all(|name| is_followed(name)));
    }
}
