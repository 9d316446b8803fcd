//! What each header of a log stands for.

use crate::failure::{Failure, Outcome};
use crate::input::map::{missing, no_unit, resolve};
use crate::input::names::meaning;
use crate::input::unit::{Quantity, Unit};
use crate::input::words::shorten;

/// More columns than any logger writes; beyond it the file is something else.
pub const MAX_COLUMNS: usize = 1024;

/// What a column holds. `axis` is 0, 1, 2 for x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// `t_s`; also `t_ms`, `t_us`, `t_ns`.
    Time,
    /// `mx_ut`, `my_ut`, `mz_ut`; also in T, mT, nT, G, mG.
    FieldUt(usize),
    /// `mx_counts`, `my_counts`, `mz_counts`.
    FieldCounts(usize),
    /// `ax_mps2`, `ay_mps2`, `az_mps2`; also in g, mg.
    Accel(usize),
    /// `gx_radps`, `gy_radps`, `gz_radps`; also in degrees (`gx_dps`).
    Gyro(usize),
    /// `heading_deg`.
    Heading,
    /// Any other numeric column.
    Covariate,
    /// A header without a name.
    Unnamed,
}

impl Role {
    /// The name in the log, its role, and the unit that the header says, of a header of the format: case aside, and with
    /// other units than the format's own.
    pub fn of(header: &str) -> (String, Role, Option<Unit>) {
        const AXES: [&str; 3] = ["x", "y", "z"];
        let lower = header.to_ascii_lowercase();
        if let Some(unit) =
            lower.strip_prefix("t_").and_then(|unit| Unit::of(unit, Quantity::Time)).filter(|u| !u.is_date)
        {
            return ("t_s".into(), Role::Time, Some(unit));
        }
        for (axis, letter) in AXES.iter().enumerate() {
            let Some(unit) = lower.get(1..).and_then(|rest| rest.strip_prefix(letter)?.strip_prefix('_'))
            else {
                continue;
            };
            let named = |quantity| Unit::of(unit, quantity);
            match &lower[..1] {
                "m" if unit == "counts" => {
                    return (format!("m{letter}_counts"), Role::FieldCounts(axis), None);
                }
                "m" => {
                    if let Some(unit) = named(Quantity::Field) {
                        return (format!("m{letter}_ut"), Role::FieldUt(axis), Some(unit));
                    }
                }
                "a" => {
                    if let Some(unit) = named(Quantity::Acceleration) {
                        return (format!("a{letter}_mps2"), Role::Accel(axis), Some(unit));
                    }
                }
                "g" => {
                    if let Some(unit) = named(Quantity::Rate) {
                        return (format!("g{letter}_radps"), Role::Gyro(axis), Some(unit));
                    }
                }
                _ => {}
            }
        }
        match lower.as_str() {
            "heading_deg" => (lower, Role::Heading, None),
            "" => (lower, Role::Unnamed, None),
            _ => (header.to_string(), Role::Covariate, None),
        }
    }

    /// What its values are of.
    pub fn quantity(self) -> Option<Quantity> {
        match self {
            Role::Time => Some(Quantity::Time),
            Role::FieldUt(_) => Some(Quantity::Field),
            Role::Accel(_) => Some(Quantity::Acceleration),
            Role::Gyro(_) => Some(Quantity::Rate),
            _ => None,
        }
    }
}

/// One column of the log.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name in the log, after `--map`.
    pub name: String,
    /// What it holds.
    pub role: Role,
    /// The unit in the file; `None` for what is read as it is.
    pub unit: Option<Unit>,
}

/// Names and roles for a header line. `line` is its line number, for errors.
pub fn interpret(header: &[String], map: &[(String, String)], line: u64) -> Outcome<Vec<Column>> {
    let fail = |message: String| Failure::usage(message).at_line(line);
    if header.len() > MAX_COLUMNS {
        return Err(fail(format!(
            "{} columns, at most {MAX_COLUMNS} are read: is this the header of a log?",
            header.len()
        )));
    }
    let mut mapped: Vec<(usize, &str, Option<&str>)> = Vec::with_capacity(map.len());
    for (name, from) in map {
        let (index, unit) = resolve(from, header).ok_or_else(|| missing(name, from, header).at_line(line))?;
        mapped.push((index, name, unit));
    }
    let mut columns: Vec<Column> = Vec::with_capacity(header.len());
    for (index, cell) in header.iter().enumerate() {
        let stated = mapped.iter().find(|(column, ..)| *column == index);
        let (name, role, unit) = Role::of(stated.map_or(cell, |(_, name, _)| *name));
        let unit = match stated {
            None => unit,
            Some((_, name, Some(text))) => Some(
                Unit::stated(text, role.quantity())
                    .filter(|_| !matches!(role, Role::FieldCounts(_)))
                    .ok_or_else(|| no_unit(name, text))?,
            ),
            // t_s=t_ms: the header says what it is.
            Some((_, _, None)) => role
                .quantity()
                .and_then(|quantity| meaning(cell).unit.filter(|u| u.quantity == Some(quantity)))
                .or(unit),
        };
        if !name.is_empty() && columns.iter().any(|column| column.name == name) {
            if role == Role::Time {
                let both: Vec<&str> =
                    header.iter().map(String::as_str).filter(|cell| Role::of(cell).1 == Role::Time).collect();
                return Err(fail(format!("both {}. Rename one of them with --map", both.join(" and "))));
            }
            let name = shorten(cell);
            return Err(fail(format!("column \"{name}\" appears twice in the header. Rename or remove one"))
                .at_column(name));
        }
        columns.push(Column { name, role, unit: unit.filter(|unit| !unit.is_own()) });
    }
    Ok(columns)
}

/// The indices of a complete triple; an incomplete one is an error only for the magnetometer, so that is left
/// to the caller.
pub fn triple(columns: &[Column], make: fn(usize) -> Role) -> [Option<usize>; 3] {
    [0, 1, 2].map(|axis| columns.iter().position(|column| column.role == make(axis)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(text: &str) -> Vec<String> {
        text.split(',').map(str::to_string).collect()
    }

    #[test]
    fn roles_follow_the_names() {
        let columns =
            interpret(&header("t_s,my_ut,gz_radps,ax_mps2,heading_deg,temp_c,mx"), &[], 1).expect("valid");
        let roles: Vec<Role> = columns.iter().map(|column| column.role).collect();
        assert_eq!(
            roles,
            [
                Role::Time,
                Role::FieldUt(1),
                Role::Gyro(2),
                Role::Accel(0),
                Role::Heading,
                Role::Covariate,
                Role::Covariate
            ]
        );
        assert!(columns.iter().all(|column| column.unit.is_none()));
    }

    #[test]
    fn other_units_and_capitals_are_of_the_format_too() {
        for (name, own, unit) in [
            ("MX_UT", "mx_ut", "uT"),
            ("mx_nt", "mx_ut", "nT"),
            ("my_mG", "my_ut", "mG"),
            ("t_ms", "t_s", "ms"),
            ("T_US", "t_s", "us"),
            ("gx_dps", "gx_radps", "deg/s"),
            ("az_g", "az_mps2", "g"),
        ] {
            let (found, role, found_unit) = Role::of(name);
            assert_ne!(role, Role::Covariate, "{name}");
            assert_eq!((found.as_str(), found_unit.expect("a unit").name.as_ref()), (own, unit));
        }
    }

    #[test]
    fn names_of_any_letters_are_covariates() {
        for name in ["é", "µx_ut", "m", "mé_ut", "字x", "mx_", "t_", "mx_furlong", "gx_ut"] {
            assert_eq!(Role::of(name), (name.to_string(), Role::Covariate, None));
        }
    }
}
