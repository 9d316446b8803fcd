//! Which column is what: by what the user states, by its name, by the program that wrote it, and by what its numbers rule out.

use crate::failure::{Failure, Outcome};
use crate::input::columns::Role;
use crate::input::log::ReadOptions;
use crate::input::map::{missing, no_unit, resolve};
use crate::input::names::{Kind, Meaning};
use crate::input::text::asked;
use crate::input::text::bare;
use crate::input::text::choice::{ACCEL, Choice, FIELD_COUNTS, FIELD_UT, GYRO, Taken};
use crate::input::text::grid::Grid;
use crate::input::text::instances;
use crate::input::text::magnitude::{self, Size};
use crate::input::text::program::{Program, is_sensor_mag};
use crate::input::text::rest;
use crate::input::text::times;
use crate::input::text::vectors::{Vector, meanings, vectors};
use crate::input::unit::{Quantity, Unit};

/// A sphere of radius one within this is of directions, or of an accelerometer in g.
const ONE: f64 = 0.1;

/// Decides everything about a table.
///
/// # Errors
/// No magnetometer, or two readings that are both possible.
pub fn choose(grid: &Grid, options: &ReadOptions) -> Outcome<Choice> {
    let meanings = meanings(grid);
    let mut choice = Choice { program: Program::of(grid), ..Choice::default() };
    stated(grid, options, &meanings, &mut choice)?;
    instances::rows(grid, &meanings, options, &mut choice)?;
    let mut vectors = vectors(&meanings);
    if !grid.named {
        bare::without_names(grid, &mut vectors, &mut choice)?;
    }
    field(grid, options, &meanings, &mut vectors, &mut choice)?;
    times::time(grid, &meanings, &mut choice)?;
    if let Some(program) = choice.program {
        choice.added = program.added(grid);
        choice.added.iter().flatten().for_each(|column| {
            if let Some(column) = grid.columns.get(*column) {
                choice.not_read.push(format!("{} (removed from the field)", column.header));
            }
        });
    }
    motion(grid, &vectors, &mut choice);
    rest::covariates(grid, &meanings, &vectors, &mut choice);
    Ok(choice)
}

/// `--map`.
fn stated(grid: &Grid, options: &ReadOptions, meanings: &[Meaning], choice: &mut Choice) -> Outcome<()> {
    let headers = grid.headers();
    for (name, from) in &options.map {
        let (column, unit) = resolve(from, &headers).ok_or_else(|| {
            let failure = missing(name, from, &headers);
            match grid.header_line {
                Some(line) => failure.at_line(line),
                None => failure,
            }
        })?;
        let (name, role, own) = Role::of(name);
        let quantity = role.quantity();
        let unit = match unit {
            Some(text) if matches!(role, Role::FieldCounts(_)) => return Err(no_unit(&name, text)),
            Some(text) => Some(Unit::stated(text, quantity).ok_or_else(|| no_unit(&name, text))?),
            None => {
                let meaning = meanings.get(column);
                let by_name = meaning.and_then(|m| m.unit.clone()).filter(|unit| unit.quantity == quantity);
                let dated = grid.columns.get(column).is_some_and(|c| c.dates * 2 > grid.rows());
                match quantity {
                    Some(Quantity::Time) if dated => Unit::of("ISO", Quantity::Time),
                    Some(quantity) => by_name.or(own).or_else(|| Some(Unit::own(quantity))),
                    None => None,
                }
            }
        };
        choice.taken.push(Taken { column, name, unit });
    }
    for (index, taken) in choice.taken.iter().enumerate() {
        let twice = choice
            .taken
            .iter()
            .skip(index + 1)
            .any(|other| other.name == taken.name || other.column == taken.column);
        if twice {
            return Err(Failure::usage(format!("--map: \"{}\" or its column is mapped twice", taken.name)));
        }
    }
    Ok(())
}

/// The magnetometer and its unit.
fn field(
    grid: &Grid,
    options: &ReadOptions,
    meanings: &[Meaning],
    vectors: &mut [Vector],
    choice: &mut Choice,
) -> Outcome<()> {
    for names in [FIELD_UT, FIELD_COUNTS] {
        let found = names.map(|name| choice.taken.iter().position(|taken| taken.name == name));
        if let [Some(x), Some(y), Some(z)] = found {
            let columns = [x, y, z].map(|at| choice.taken.get(at).map_or(0, |taken| taken.column));
            return instances::of_vectors(grid, options, vectors, Some(columns), choice).map(|_| ());
        }
        if found.iter().any(Option::is_some) {
            let lacking: Vec<&str> =
                names.iter().zip(found).filter(|(_, at)| at.is_none()).map(|(name, _)| *name).collect();
            return Err(Failure::usage(format!(
                "--map names only a part of the magnetometer, without {}. Name all three; {}",
                lacking.join(" and "),
                crate::input::words::listing(&grid.headers())
            )));
        }
    }
    if !vectors.iter().any(|vector| vector.kind == Kind::Field) {
        // x, y and z and no more: PX4's sensor_mag, or what the numbers say.
        let sensor_mag = is_sensor_mag(grid);
        let free =
            |vector: &Vector| vector.kind == Kind::Other && !vector.columns.iter().any(|c| choice.has(*c));
        if let Some(vector) = vectors.iter_mut().find(|vector| free(vector)) {
            let size = magnitude::size(grid, vector.columns, &choice.rows);
            if let (false, Some(size)) = (sensor_mag, &size)
                && magnitude::accel_unit(size).is_some()
                && !size.is_field()
            {
                return Err(asked::field_unit(
                    grid,
                    vector.columns,
                    &[],
                    false,
                    "their magnitude is 1 g, as of an accelerometer",
                ));
            }
            vector.kind = Kind::Field;
            if !sensor_mag {
                choice.reasons.push(format!(
                    "ironout uses {} as the magnetometer: there are no other three axes",
                    asked::names(grid, vector.columns)
                ));
            }
        }
    }
    let taken = instances::of_vectors(grid, options, vectors, None, choice)?;
    let Some(vector) = taken else {
        return Err(lacking(grid, meanings));
    };
    let (unit, counts) = field_unit(grid, options, &vector, choice)?;
    let names = if counts { FIELD_COUNTS } else { FIELD_UT };
    choice.take(vector.columns, names, unit.as_ref());
    Ok(())
}

/// No magnetometer, or a part of one.
fn lacking(grid: &Grid, meanings: &[Meaning]) -> Failure {
    let part = meanings.iter().find(|meaning| meaning.kind == Kind::Field && meaning.axis.is_some());
    let Some(part) = part else { return asked::no_field(grid) };
    let of_part = |axis: usize| {
        meanings.iter().any(|m| m.kind == Kind::Field && m.stem == part.stem && m.axis == Some(axis))
    };
    let lacking: Vec<&str> =
        FIELD_UT.iter().enumerate().filter(|(axis, _)| !of_part(*axis)).map(|(_, name)| *name).collect();
    let there = if lacking.len() == 1 { "is" } else { "are" };
    let failure = Failure::usage(format!(
        "{} {there} missing: {}.\n  Other headers are named with --map \
         mx_ut=HEADER[uT],my_ut=HEADER[uT],mz_ut=HEADER[uT]",
        lacking.join(", "),
        crate::input::words::listing(&grid.headers())
    ))
    .at_column(lacking.first().copied().unwrap_or_default());
    match grid.header_line {
        Some(line) => failure.at_line(line),
        None => failure,
    }
}

/// The unit of the magnetometer: stated, in the name, by the program, or the only one that the numbers can be in. `true` is
/// for counts.
fn field_unit(
    grid: &Grid,
    options: &ReadOptions,
    vector: &Vector,
    choice: &mut Choice,
) -> Outcome<(Option<Unit>, bool)> {
    if vector.unit.is_some() {
        return Ok((vector.unit.clone(), false));
    }
    let scale = options.ut_per_count.or(options.default_ut_per_count);
    let size = magnitude::size(grid, vector.columns, &choice.rows);
    let Some(size) = size else {
        return Err(asked::field_unit(grid, vector.columns, &[], false, "no row has a number in all three"));
    };
    if options.ut_per_count.is_some() {
        return Ok((None, true));
    }
    if let Some(magnitude) = size.equal_magnitude {
        return Err(asked::directions(grid, vector.columns, magnitude));
    }
    let units = magnitude::field_units(&size);
    let program = choice.program.and_then(|program| Some((program, program.unit(Kind::Field, "")?)));
    if let Some((program, unit)) = program {
        if magnitude::can_be_field(&size, &unit) {
            choice.reasons.push(format!("the unit {} is that of {}", unit.name, program.name()));
            return Ok((Some(unit), false));
        }
        let why = format!(
            "{} write {}, but {}, which does not fit the Earth's field in that unit",
            program.name(),
            unit.name,
            size.words()
        );
        return Err(asked::field_unit(grid, vector.columns, &units, false, &why));
    }
    if vector.counts {
        return if scale.is_some() { Ok((None, true)) } else { Err(asked::scale(grid, vector.columns)) };
    }
    match units.as_slice() {
        // Whole numbers may be counts, whatever their size.
        [unit] if !size.whole => {
            choice.reasons.push(format!(
                "{}, which fits the Earth's field only in {}",
                size.words(),
                unit.name
            ));
            Ok((Some(unit.clone()), false))
        }
        _ if size.whole && scale.is_some() => Ok((None, true)),
        [] if !size.whole => {
            let one_g =
                size.field.as_ref().filter(|field| field.is_radius() && (field.field_ut - 1.0).abs() < ONE);
            let what = if one_g.is_some() { ": an accelerometer in g, or directions" } else { "" };
            let why = format!("{}, which fits the Earth's field in no unit{what}", size.words());
            Err(asked::field_unit(grid, vector.columns, &[], true, &why))
        }
        units => {
            let why = if size.whole {
                format!("{}, in whole numbers, so they may be raw counts", size.words())
            } else {
                format!("{}: several units fit", size.words())
            };
            Err(asked::field_unit(grid, vector.columns, units, size.whole, &why))
        }
    }
}

fn shown(size: &Size) -> String {
    crate::input::text::rest::rounded(size.median)
}

/// Accelerometer and gyroscope: taken where their unit is known; a calibration can do without.
fn motion(grid: &Grid, vectors: &[Vector], choice: &mut Choice) {
    for (kind, names, what) in [(Kind::Accel, ACCEL, "accelerometer"), (Kind::Gyro, GYRO, "gyroscope")] {
        if names.iter().any(|name| choice.has_name(name)) {
            continue;
        }
        let free: Vec<&Vector> = vectors
            .iter()
            .filter(|vector| vector.kind == kind && !vector.columns.iter().any(|column| choice.has(*column)))
            .collect();
        let mut free = free.into_iter();
        let Some(vector) = free.next() else { continue };
        for other in free {
            choice.not_read.push(format!("{} (another {what})", asked::names(grid, other.columns)));
        }
        let listed = asked::names(grid, vector.columns);
        let Some(size) = magnitude::size(grid, vector.columns, &choice.rows) else {
            choice.not_read.push(format!("{listed} (no numbers)"));
            continue;
        };
        if size.constant && size.median == 0.0 {
            choice.not_read.push(format!("{listed} (always zero: there is no {what})"));
            continue;
        }
        let by_program = choice.program.and_then(|program| program.unit(kind, ""));
        if let Some(unit) = vector.unit.clone().or(by_program) {
            choice.take(vector.columns, names, Some(&unit));
            continue;
        }
        let units = match kind {
            Kind::Accel => magnitude::accel_unit(&size).into_iter().collect(),
            _ => magnitude::rate_units(grid, vector.columns, &choice.rows),
        };
        match units.as_slice() {
            [unit] => {
                choice.reasons.push(format!("{listed}: {} is the only unit that fits their size", unit.name));
                choice.take(vector.columns, names, Some(unit));
            }
            [] => choice.not_read.push(format!(
                "{listed}: the {what}'s median magnitude {} is not 1 g in any unit. To use it, state its scale to \
                 m/s2:\n      {}",
                shown(&size),
                asked::map_of(grid, vector.columns, names, Some(&Unit::scale(scale_of(kind, size.median))))
            )),
            units => {
                let options: Vec<String> = units
                    .iter()
                    .map(|unit| format!("\n      {}", asked::map_of(grid, vector.columns, names, Some(unit))))
                    .collect();
                choice.not_read.push(format!("{listed}: the unit of the {what} is unknown. To use it:{}", options.concat()));
            }
        }
    }
}

/// A scale that makes the median one g, to four digits: a proposal.
fn scale_of(kind: Kind, median: f64) -> f64 {
    let factor = if kind == Kind::Accel && median > 0.0 { 9.806_65 / median } else { 1.0 };
    format!("{factor:.3e}").parse().unwrap_or(factor)
}
