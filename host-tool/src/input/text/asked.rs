//! Where two readings are possible: the question, with both of them as options that can be pasted.

use crate::failure::{Choice, Failure, Question};
use crate::input::map::entry;
use crate::input::text::choice::{FIELD_COUNTS, FIELD_UT};
use crate::input::text::grid::Grid;
use crate::input::text::magnitude;
use crate::input::text::rest::rounded;
use crate::input::unit::Unit;
use crate::input::words::shorten;
use crate::shell::quoted;
use ironout_analysis::plausible::field::{EARTH_UT, FieldSize};

/// Names shown of a table.
const SHOWN: usize = 40;

/// `mx_ut=MagX[mG],…` for three columns.
fn entries(grid: &Grid, columns: [usize; 3], names: [&str; 3], unit: Option<&Unit>) -> String {
    let parts: Vec<String> = columns
        .iter()
        .zip(names)
        .map(|(column, name)| entry(name, header(grid, *column), unit.map(|unit| unit.name.as_ref())))
        .collect();
    parts.join(",")
}

/// `--map 'mx_ut=MagX[mG],…'` for three columns.
pub fn map_of(grid: &Grid, columns: [usize; 3], names: [&str; 3], unit: Option<&Unit>) -> String {
    format!("--map {}", quoted(&entries(grid, columns, names, unit)))
}

fn choice(label: String, map: String) -> Choice {
    Choice { label, options: vec![("--map".to_string(), map)] }
}

/// Three columns in one of these units, each an answer; in counts if there are none.
fn in_units(grid: &Grid, columns: [usize; 3], units: &[Unit], counts: bool) -> Vec<Choice> {
    let label = |unit: &str| format!("{} in {unit}", names(grid, columns));
    let mut all: Vec<Choice> = units
        .iter()
        .map(|unit| choice(label(unit.name.as_ref()), entries(grid, columns, FIELD_UT, Some(unit))))
        .collect();
    if counts || units.is_empty() {
        all.push(choice(label("counts of the chip"), entries(grid, columns, FIELD_COUNTS, None)));
    }
    all
}

fn header(grid: &Grid, column: usize) -> &str {
    grid.columns.get(column).map(|column| column.header.as_str()).unwrap_or_default()
}

/// The column's name, or its number where it has none.
fn place_of(grid: &Grid, column: usize) -> &str {
    let name = header(grid, column);
    name.strip_prefix("column ").unwrap_or(name)
}

fn place(grid: &Grid, failure: Failure) -> Failure {
    match grid.header_line.or(grid.lines.first().copied()) {
        Some(line) => failure.at_line(line),
        None => failure,
    }
}

/// The unit of the magnetometer is not known: `units` are those that fit.
pub fn field_unit(grid: &Grid, columns: [usize; 3], units: &[Unit], counts: bool, why: &str) -> Failure {
    let mut lines = vec![format!(
        "the unit of the magnetometer ({}) is unknown:\n  {why}. State it:",
        names(grid, columns)
    )];
    for unit in units {
        lines.push(format!("  {}", map_of(grid, columns, FIELD_UT, Some(unit))));
    }
    if counts || units.is_empty() {
        let between = scale_bounds(grid, columns).map_or(String::new(), |[least, most]| {
            format!(", between {} and {}", rounded(least), rounded(most))
        });
        lines.push(format!(
            "  {} --ut-per-count UT   (UT is the scale in the data sheet, in µT per count{between})",
            map_of(grid, columns, FIELD_COUNTS, None)
        ));
    }
    let question = Question {
        text: format!("What is the unit of the magnetometer ({})?", names(grid, columns)),
        choices: in_units(grid, columns, units, counts),
        needs_scale: counts || units.is_empty(),
        ..Question::default()
    };
    place(grid, Failure::usage(lines.join("\n")).at_column(place_of(grid, columns[0])).asking(question))
}

/// The scales that make the radius a field of the Earth.
fn scale_bounds(grid: &Grid, columns: [usize; 3]) -> Option<[f64; 2]> {
    let rows: Vec<usize> = (0..grid.rows()).collect();
    let field = magnitude::size(grid, columns, &rows)?.field.filter(FieldSize::is_radius)?;
    Some([EARTH_UT.start() / field.field_ut, EARTH_UT.end() / field.field_ut])
}

/// Every magnitude is the same: no unit makes that a field.
pub fn directions(grid: &Grid, columns: [usize; 3], magnitude: f64) -> Failure {
    let text = format!(
        "the magnetometer ({}) has the same magnitude in every row, {}: the vectors are normalised,\n  so offset and matrix \
         cannot be determined.\n  Fix: log the field as the sensor measures it, before normalisation",
        names(grid, columns),
        rounded(magnitude)
    );
    place(grid, Failure::usage(text).at_column(place_of(grid, columns[0])))
}

/// Counts without a scale.
pub fn scale(grid: &Grid, columns: [usize; 3]) -> Failure {
    let text = format!(
        "the magnetometer ({}) is in counts: give its scale with --ut-per-count UT,\n  one number or three comma-separated \
         for \
         x,y,z (see the data sheet: 0.0917 for an HMC5883L at 1090 counts per gauss,\n  0.0333 for a QMC5883L at 8 G, 0.15 for an \
         AK8963 or AK09916)",
        names(grid, columns)
    );
    let question = Question {
        text: format!("The magnetometer ({}) is in counts. How many µT is one count?", names(grid, columns)),
        needs_scale: true,
        ..Question::default()
    };
    place(grid, Failure::usage(text).at_column(place_of(grid, columns[0])).asking(question))
}

/// Several columns can be the magnetometer, and nothing tells which.
pub fn which_vector(grid: &Grid, candidates: &[[usize; 3]], units: &[Vec<Unit>]) -> Failure {
    let mut lines = vec!["which columns are the magnetometer? Possible columns:".to_string()];
    for (columns, units) in candidates.iter().zip(units) {
        match units.as_slice() {
            [] => lines.push(format!("  {} --ut-per-count UT", map_of(grid, *columns, FIELD_COUNTS, None))),
            units => lines.extend(
                units.iter().map(|unit| format!("  {}", map_of(grid, *columns, FIELD_UT, Some(unit)))),
            ),
        }
    }
    let each = candidates.iter().zip(units);
    let question = Question {
        text: "Which columns are the magnetometer?".to_string(),
        choices: each.flat_map(|(columns, units)| in_units(grid, *columns, units, false)).collect(),
        needs_scale: units.iter().any(Vec::is_empty),
        ..Question::default()
    };
    place(grid, Failure::usage(lines.join("\n")).asking(question))
}

/// The unit of time is not known.
pub fn time_unit(grid: &Grid, column: usize, units: &[Unit], step: f64) -> Failure {
    let name = header(grid, column);
    let mut lines = vec![if units.is_empty() {
        format!(
            "the unit of time is unknown: {} steps by {step}, which is implausible in s, ms, us and ns. State \
             it:",
            shorten(name)
        )
    } else {
        format!(
            "the unit of time is unknown: {} steps by {step}, and two units fit. State it:",
            shorten(name)
        )
    }];
    let all = ["s", "ms"];
    let units: Vec<&str> =
        if units.is_empty() { all.to_vec() } else { units.iter().map(|unit| unit.name.as_ref()).collect() };
    let map = |unit: &&str| entry("t_s", name, Some(unit));
    lines.extend(units.iter().map(|unit| format!("  --map {}", quoted(&map(unit)))));
    let question = Question {
        text: format!("What is the unit of the time in {}?", shorten(name)),
        choices: units.iter().map(|unit| choice(format!("{} in {unit}", shorten(name)), map(unit))).collect(),
        ..Question::default()
    };
    place(grid, Failure::usage(lines.join("\n")).at_column(place_of(grid, column)).asking(question))
}

/// No magnetometer: what was looked for, what is there.
pub fn no_field(grid: &Grid) -> Failure {
    let mut there: Vec<String> =
        grid.columns.iter().take(SHOWN).map(|column| shorten(&column.header)).collect();
    if grid.columns.len() > SHOWN {
        there.push(format!("… ({} columns)", grid.columns.len()));
    }
    let example =
        example(grid).unwrap_or_else(|| "mx_ut=HEADER[uT],my_ut=HEADER[uT],mz_ut=HEADER[uT]".to_string());
    let text = format!(
        "no magnetometer found in this {}.\n  looked for: three columns x, y, z of a name like mag, MagX, mx_ut, \
         magnetic_field, \
         B, or of a unit like uT\n  there are: {}\n  name them: --map {}",
        grid.format,
        there.join(", "),
        quoted(&example)
    );
    let question = Question {
        text: "Which columns are the magnetometer?".to_string(),
        columns: grid.columns.iter().map(|column| column.header.clone()).collect(),
        ..Question::default()
    };
    place(grid, Failure::usage(text).asking(question))
}

/// Three neighbouring columns whose readings lie on a sphere that is the Earth's field in some unit: nothing else is worth a proposal.
fn example(grid: &Grid) -> Option<String> {
    let rows: Vec<usize> = (0..grid.rows()).collect();
    (0..grid.columns.len().saturating_sub(2)).take(SHOWN).find_map(|first| {
        let columns = [first, first + 1, first + 2];
        let size = magnitude::size(grid, columns, &rows).filter(magnitude::Size::is_field)?;
        let unit = magnitude::field_units(&size).into_iter().next()?;
        let parts = columns.iter().zip(FIELD_UT);
        let parts = parts.map(|(column, name)| entry(name, header(grid, *column), Some(unit.name.as_ref())));
        Some(parts.collect::<Vec<_>>().join(","))
    })
}

/// An instance that is not there.
pub fn no_instance(asked: usize, there: &[(usize, String)]) -> Failure {
    let list: Vec<String> = there.iter().map(|(number, what)| format!("{number} ({what})")).collect();
    let text = match list.as_slice() {
        [] => format!("--instance {asked}: the log has one magnetometer. Omit the option"),
        list => format!(
            "--instance {asked}: there is no such magnetometer in the log; there are {}",
            list.join(", ")
        ),
    };
    Failure::usage(text)
}

/// The headers of three columns.
pub fn names(grid: &Grid, columns: [usize; 3]) -> String {
    columns.map(|column| shorten(header(grid, column))).join(", ")
}
