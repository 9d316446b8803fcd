//! Several magnetometers in one log: which rows, which columns, and the others that are there.

use crate::failure::Outcome;
use crate::input::log::ReadOptions;
use crate::input::names::{Kind, Meaning, speaks_of_field};
use crate::input::read_as::Instance;
use crate::input::text::asked;
use crate::input::text::choice::Choice;
use crate::input::text::grid::{Grid, GridColumn};
use crate::input::text::vectors::Vector;

/// More sensors than this has no log.
const MOST: usize = 16;

/// The rows of one sensor, where a column says which sensor a row is of.
pub fn rows(grid: &Grid, meanings: &[Meaning], options: &ReadOptions, choice: &mut Choice) -> Outcome<()> {
    choice.rows = (0..grid.rows()).collect();
    let mut columns = grid.columns.iter().enumerate().filter(|(index, _)| !choice.has(*index));
    let found = columns.find_map(|(index, column)| {
        let named = meanings.get(index).is_some_and(|meaning| meaning.kind == Kind::Instance);
        by_number(grid, column, named).or_else(|| by_text(column, named || !grid.named))
    });
    let Some(Sensors { there, of_row, header }) = found else { return Ok(()) };
    let taken = match options.instance {
        None => there.first().map(|(number, _)| *number).unwrap_or_default(),
        Some(asked) if there.iter().any(|(number, _)| *number == asked) => asked,
        Some(asked) => return Err(asked::no_instance(asked, &there)),
    };
    let kept: Vec<usize> = (0..grid.rows()).filter(|row| of_row.get(*row) == Some(&Some(taken))).collect();
    choice.reasons.push(format!("{header} is the sensor of each row"));
    choice.rows = kept;
    if there.len() > 1 {
        choice.pin_instance = true;
        choice.instance = Some(Instance { taken, there });
    }
    Ok(())
}

struct Sensors {
    there: Vec<(usize, String)>,
    of_row: Vec<Option<usize>>,
    header: String,
}

/// Small whole numbers, a few of them.
fn by_number(grid: &Grid, column: &GridColumn, named: bool) -> Option<Sensors> {
    if !named || column.texts > 0 || column.finite() < grid.rows() {
        return None;
    }
    let mut distinct: Vec<(f64, usize)> = Vec::new();
    for value in &column.values {
        if let Some((_, count)) = distinct.iter_mut().find(|(known, _)| known == value) {
            *count += 1;
        } else if distinct.len() < MOST {
            distinct.push((*value, 1));
        } else {
            return None;
        }
    }
    if distinct.len() < 2 || distinct.len() * 3 > grid.rows() {
        return None;
    }
    distinct.sort_by(|a, b| a.0.total_cmp(&b.0));
    let small = distinct.iter().all(|(value, _)| (0.0..=255.0).contains(value) && value.fract() == 0.0);
    let number = |index: usize, value: f64| if small { value as usize } else { index };
    let there = distinct
        .iter()
        .enumerate()
        .map(|(index, (value, count))| {
            let what = if small { format!("{count} rows") } else { format!("{value}, {count} rows") };
            (number(index, *value), what)
        })
        .collect();
    let of_row = column
        .values
        .iter()
        .map(|value| distinct.iter().position(|(known, _)| known == value).map(|index| number(index, *value)))
        .collect();
    Some(Sensors { there, of_row, header: column.header.clone() })
}

/// Names of sensors, one of which is a magnetometer's.
fn by_text(column: &GridColumn, named: bool) -> Option<Sensors> {
    if column.texts * 2 < column.values.len() || column.words.len() > MOST || column.words.is_empty() {
        return None;
    }
    let of_field: Vec<usize> = (0..column.words.len())
        .filter(|word| column.words.get(*word).is_some_and(|w| speaks_of_field(w)))
        .collect();
    // MAG1 and MAG2 under `sensor`; or MAG, ACC and GYR in any column of words. `compass` as the only word of a note is not a choice.
    let wanted = if of_field.is_empty() && named && column.words.len() > 1 {
        (0..column.words.len()).collect()
    } else {
        of_field
    };
    if wanted.is_empty() || column.words.len() == 1 {
        return None;
    }
    let count = |word: usize| column.codes.iter().filter(|code| usize::from(**code) == word + 1).count();
    let there = wanted
        .iter()
        .enumerate()
        .map(|(number, word)| {
            let text = column.words.get(*word).map(String::as_str).unwrap_or_default();
            (number, format!("{text}, {} rows", count(*word)))
        })
        .collect();
    let of_row = (0..column.values.len())
        .map(|row| {
            let code = usize::from(column.codes.get(row).copied().unwrap_or(0));
            wanted.iter().position(|word| word + 1 == code)
        })
        .collect();
    Some(Sensors { there, of_row, header: column.header.clone() })
}

/// The vector of the magnetometer, where several are in each row; uncalibrated before calibrated, else the first.
///
/// # Errors
/// An instance that is not there.
pub fn of_vectors(
    grid: &Grid,
    options: &ReadOptions,
    vectors: &[Vector],
    mapped: Option<[usize; 3]>,
    choice: &mut Choice,
) -> Outcome<Option<Vector>> {
    let fields: Vec<&Vector> = vectors.iter().filter(|vector| vector.kind == Kind::Field).collect();
    let best = fields.iter().map(|vector| vector.rank).max().unwrap_or(0);
    let by_rank = fields.iter().position(|vector| vector.rank == best);
    let by_map = mapped.map(|columns| fields.iter().position(|vector| vector.columns == columns));
    let taken = match (by_map, options.instance) {
        (Some(found), _) => found,
        (None, Some(asked)) if !choice.pin_instance => {
            let there = list(grid, &fields);
            if asked >= fields.len().max(1) {
                return Err(asked::no_instance(asked, if fields.len() > 1 { &there } else { &[] }));
            }
            Some(asked)
        }
        _ => by_rank,
    };
    let only_one = choice.instance.is_none() && mapped.is_some() && fields.len() < 2;
    if only_one && options.instance.is_some_and(|asked| asked > 0) {
        return Err(asked::no_instance(options.instance.unwrap_or_default(), &[]));
    }
    if fields.len() > 1 {
        for (index, vector) in fields.iter().enumerate() {
            if Some(index) != taken {
                choice
                    .not_read
                    .push(format!("{} (another magnetometer)", asked::names(grid, vector.columns)));
            }
        }
        if choice.instance.is_none()
            && let Some(taken) = taken
        {
            choice.instance = Some(Instance { taken, there: list(grid, &fields) });
        }
    }
    Ok(taken.and_then(|index| fields.get(index)).map(|vector| (*vector).clone()))
}

fn list(grid: &Grid, fields: &[&Vector]) -> Vec<(usize, String)> {
    fields.iter().enumerate().map(|(number, vector)| (number, asked::names(grid, vector.columns))).collect()
}
