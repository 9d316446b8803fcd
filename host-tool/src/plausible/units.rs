//! What is said of a magnetometer in another unit, and the options that mend it.

use crate::cli::{LogArgs, typed_option};
use crate::failure::{Choice, Failure, Question};
use crate::input::{Log, Quantity, Unit, map_entry as entry, parse_map};
use ironout_analysis::plausible::field::FieldSize;

/// Every magnitude is the same: nothing is left to be calibrated.
pub fn directions(magnitude_ut: f64) -> Failure {
    Failure::usage(format!(
        "every reading of the magnetometer has the same magnitude, {} µT: the vectors are normalised, so offset and matrix \
         cannot be determined. Fix: log the field as the sensor measures it, before normalisation",
        short(magnitude_ut)
    ))
}

/// The unit of the magnetometer as it was read.
fn read_unit(log: &Log) -> Unit {
    let read = log.read_as.columns.iter().find(|column| column.name == "mx_ut");
    let read = read.and_then(|column| Unit::stated(&column.unit, Some(Quantity::Field)));
    read.unwrap_or_else(|| Unit::own(Quantity::Field))
}

/// The units, or factors, in which the readings are a field of the Earth; the likeliest first.
fn fitting_units(read: &Unit, size: &FieldSize) -> Vec<Unit> {
    let factor = |unit: &Unit| unit.convert(1.0) / read.convert(1.0);
    let can_be = |unit: &Unit| size.can_be_earth(factor(unit));
    let mut units: Vec<Unit> = Unit::all(Quantity::Field).filter(can_be).collect();
    // No unit has a name for it: a power of ten of one that has.
    let decades = [10.0, 100.0, 1000.0, 0.1, 0.01, 0.001];
    if units.is_empty() && size.is_radius() {
        let scaled = decades.map(|decade| {
            Unit::stated(&format!("{} uT", short_power(decade * read.convert(1.0))), Some(Quantity::Field))
        });
        units.extend(scaled.into_iter().flatten().find(can_be));
    }
    let middle = |unit: &Unit| (size.field_ut * factor(unit) / 45.0).ln().abs();
    units.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    units
}

/// Which unit the columns are in, as a question with answers.
pub fn unit_question(log: &Log, arguments: &LogArgs, size: &FieldSize) -> Question {
    let read = read_unit(log);
    let choice = |unit: &Unit| {
        let field_ut = size.field_ut * unit.convert(1.0) / read.convert(1.0);
        let map = ("--map".to_string(), unit_map(log, arguments, unit));
        Choice { label: format!("{} (a field of {} µT)", unit.name, short(field_ut)), options: vec![map] }
    };
    Question {
        text: format!("The readings are not a field of the Earth in {}. Which unit are they in?", read.name),
        choices: fitting_units(&read, size).iter().map(choice).collect(),
        ..Question::default()
    }
}

/// The unit that the columns are rather in, or the factor that they lack, and the options that say so.
pub fn unit_remedy(log: &Log, arguments: &LogArgs, size: &FieldSize) -> String {
    let coil = "If a coil makes the field, give it with --field UT";
    let read = read_unit(log);
    let factor = |unit: &Unit| unit.convert(1.0) / read.convert(1.0);
    let units = fitting_units(&read, size);
    if units.is_empty() {
        return format!("No unit fits. Is this the magnetometer? {coil}");
    }
    let mut text = String::new();
    for unit in units {
        let factor = factor(&unit);
        let (times, how) = if factor > 1.0 { (factor, "small") } else { (1.0 / factor, "large") };
        text.push_str(&format!(
            "In {} it would be {} µT (the numbers are {} times too {how} for {}). To use that unit:\n   {}\n",
            unit.name,
            short(size.field_ut * factor),
            short_power(times),
            read.name,
            typed_option("--map", &unit_map(log, arguments, &unit))
        ));
    }
    text + coil
}

/// The `--map` that reads the magnetometer's columns in this unit, and everything else as it was.
fn unit_map(log: &Log, arguments: &LogArgs, unit: &Unit) -> String {
    let given = parse_map(&arguments.map).unwrap_or_default();
    let names = ["mx_ut", "my_ut", "mz_ut"];
    let source = |name: &str| {
        let read = log.read_as.columns.iter().find(|column| column.name == name);
        read.map(|column| column.source.clone())
            .filter(|source| !source.is_empty())
            .unwrap_or_else(|| name.to_string())
    };
    let field = names.map(|name| entry(name, &source(name), Some(&unit.name)));
    let others = given.iter().filter(|(name, _)| !names.contains(&name.as_str()));
    let others = others.map(|(name, header)| entry(name, header, None));
    let map: Vec<String> = field.into_iter().chain(others).collect();
    map.join(",")
}

/// Three significant digits, without a power of ten.
pub fn short(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return format!("{value}");
    }
    let digits = value.abs().log10().floor() as i32;
    if !(-9..12).contains(&digits) {
        return format!("{value:.2e}");
    }
    format!("{value:.*}", (2 - digits).max(0) as usize)
}

/// A power of ten as it is typed; another number by three digits.
pub fn short_power(value: f64) -> String {
    let power = 10.0_f64.powf(value.log10().round());
    if (value / power - 1.0).abs() < 1e-9 { format!("{power}") } else { short(value) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (48_123.4, "48123"),
            (0.481, "0.481"),
            (59_980.0, "59980"),
            (2e-8, "0.0000000200"),
            (4.567, "4.57"),
        ] {
            assert_eq!(short(value), text);
        }
        assert_eq!(
            (short_power(1e-3), short_power(0.1), short_power(100.0), short_power(1e6)),
            ("0.001".into(), "0.1".into(), "100".into(), "1000000".into())
        );
    }
}
