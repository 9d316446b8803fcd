//! Tables in memory, as Python hands them over and as Arrow's files hold them: columns with names, read as those of a text log.

use crate::failure::{Failure, Outcome};
use crate::input::columns::{self, Column, MAX_COLUMNS, Role};
use crate::input::followed;
use crate::input::log::{Log, ReadOptions};
use crate::input::map::entry;
use crate::input::own::is_own;
use crate::input::plan::Plan;
use crate::input::reader::backward;
use crate::input::store::Store;
use crate::input::text::{self, Grid, GridColumn, unique};
use crate::input::words::shorten;

/// Row of the first values, as errors name it: it stands below a header.
const FIRST_LINE: u64 = 2;

/// The log of columns of numbers; a missing cell is NaN. Errors name the line that the row would have below a header.
///
/// # Errors
/// As of a text log, and columns that are not equally long.
pub fn from_columns(names: Vec<String>, values: Vec<Vec<f64>>, options: &ReadOptions) -> Outcome<Log> {
    let column = |(name, values): (String, Vec<f64>)| {
        let not_finite = values.iter().filter(|value| value.is_infinite()).count();
        GridColumn { values, not_finite, ..GridColumn::new(name) }
    };
    from_table(names.into_iter().zip(values).map(column).collect(), "columns in memory", options)
}

/// The log of columns of numbers, dates and texts.
///
/// # Errors
/// As [`from_columns`].
pub fn from_table(columns: Vec<GridColumn>, format: &str, options: &ReadOptions) -> Outcome<Log> {
    if columns.len() > MAX_COLUMNS {
        return Err(Failure::usage(format!(
            "{} columns, at most {MAX_COLUMNS} are read: is this a log?",
            columns.len()
        )));
    }
    let rows = columns.iter().map(|column| column.values.len()).max().unwrap_or(0);
    if rows == 0 {
        return Err(Failure::usage("the table has no rows"));
    }
    if let Some(short) = columns.iter().find(|column| column.values.len() != rows) {
        let found = short.values.len();
        return Err(Failure::usage(format!("{found} values, but the longest column has {rows}"))
            .at_column(short.header.clone()));
    }
    let names: Vec<String> = columns.iter().map(|column| column.header.clone()).collect();
    let mut log = if is_own(&names, options, 1) {
        own(columns, rows, options)
    } else {
        foreign(columns, rows, format, options)
    }?;
    followed::rename(&mut log);
    log.read_as.format = format.to_string();
    Ok(log)
}

/// By the names of the program's own CSV: strict.
fn own(table: Vec<GridColumn>, rows: usize, options: &ReadOptions) -> Outcome<Log> {
    let names: Vec<String> = table.iter().map(|column| column.header.clone()).collect();
    let roles = columns::interpret(&names, &options.map, 1)?;
    let mut notices = Vec::new();
    let (mut kept, mut values): (Vec<Column>, Vec<GridColumn>) = (Vec::new(), Vec::new());
    for (mut column, found) in roles.into_iter().zip(table) {
        let is_time = column.role == Role::Time;
        let strict = is_time || matches!(column.role, Role::FieldUt(_) | Role::FieldCounts(_));
        let why = match found.words.first() {
            Some(word) => Some(format!("contains text (\"{}\")", shorten(word))),
            None if found.dates > 0 && !is_time => Some("contains dates".to_string()),
            None => None,
        };
        match why {
            Some(why) if strict => {
                return Err(Failure::usage(format!("the column {why}. Fix: write it as numbers"))
                    .at_column(found.header));
            }
            Some(why) => notices.push(format!("ignored column {}: it {why}", shorten(&found.header))),
            None => {
                // A column of times is in seconds, whatever its name says.
                if is_time && (found.dates > 0 || found.unit.is_some()) {
                    column.unit = None;
                }
                kept.push(column);
                values.push(found);
            }
        }
    }
    let plan = Plan::new(&kept, options, 1)?;
    let mut stores = Vec::new();
    for (index, (column, found)) in kept.into_iter().zip(values).enumerate() {
        let mut store = Store::new(column, found.header, 0);
        store.fill(found.values, plan.strict.contains(&index))?;
        stores.push(store);
    }
    if let Some(store) = plan.time.and_then(|index| stores.get(index)) {
        let back = store.values.windows(2).position(|pair| pair[1] < pair[0]);
        if let Some(row) = back {
            let (time, last) = (store.values[row + 1], store.values[row]);
            return Err(backward(time, last, row as u64 + 1 + FIRST_LINE, &store.header));
        }
    }
    let mut log = plan.finish(stores, rows, options)?;
    log.notices.splice(0..0, notices);
    let pins: Vec<String> = options.map.iter().map(|(name, from)| entry(name, from, None)).collect();
    if !pins.is_empty() {
        log.read_as.pins.push(("--map".into(), pins.join(",")));
    }
    Ok(log)
}

/// By any names: tolerant.
fn foreign(mut table: Vec<GridColumn>, rows: usize, format: &str, options: &ReadOptions) -> Outcome<Log> {
    for column in &mut table {
        column.values.iter_mut().filter(|value| value.is_infinite()).for_each(|value| *value = f64::NAN);
    }
    // A table without names has the numbers of its columns instead.
    let named = !table.iter().all(|column| column.header.parse::<usize>().is_ok());
    let names = table.iter().enumerate().map(|(index, column)| match named {
        true => column.header.clone(),
        false => format!("column {}", index + 1),
    });
    for (name, column) in unique(names.collect()).into_iter().zip(&mut table) {
        column.header = name;
    }
    let lines = (FIRST_LINE..).take(rows).collect();
    text::read_grid(
        Grid {
            format: format.to_string(),
            columns: table,
            lines,
            header_line: Some(1),
            named,
            ..Grid::default()
        },
        options,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions all round, with an offset.
    fn ball() -> [Vec<f64>; 3] {
        let angle = |i: i32| (f64::from(i) * 0.13, f64::from(i) * 1.1);
        let of = |f: fn((f64, f64)) -> f64| (0..400).map(|i| 48.0 * f(angle(i)) + 10.0).collect();
        [of(|(a, b)| a.cos() * b.cos()), of(|(a, b)| a.cos() * b.sin()), of(|(a, _)| a.sin())]
    }

    fn columns(names: [&str; 3]) -> Vec<GridColumn> {
        let column =
            |(name, values): (&str, Vec<f64>)| GridColumn { values, ..GridColumn::new(name.to_string()) };
        names.into_iter().zip(ball()).map(column).collect()
    }

    const OWN: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];

    #[test]
    fn times_are_seconds_whatever_the_name_says_and_other_dates_are_left_out() {
        let time = |name: &str| GridColumn {
            values: (0..400).map(|i| 1.78e9 + f64::from(i) * 0.02).collect(),
            dates: 400,
            ..GridColumn::new(name)
        };
        let mut table = columns(OWN);
        table.push(time("t_us"));
        table.push(time("created"));
        let log = from_table(table, "table", &ReadOptions::default()).expect("a log");
        let times = log.time_s.expect("a time");
        assert!((times[399] - times[0] - 399.0 * 0.02).abs() < 1e-6, "{times:?}");
        assert!(log.covariates.is_empty());
        assert_eq!(log.notices, ["ignored column created: it contains dates"]);
    }

    #[test]
    fn what_the_sensor_needs_is_refused_with_its_column() {
        let mut table = columns(OWN);
        table[1].push("abc", None);
        table[1].values.pop();
        let failure = from_table(table, "table", &ReadOptions::default()).expect_err("text");
        assert_eq!(failure.column.as_deref(), Some("my_ut"));
        let mut table = columns(OWN);
        table[2].values.pop();
        let failure = from_table(table, "table", &ReadOptions::default()).expect_err("too short");
        assert!(failure.message.starts_with("399 values, but the longest column has 400"), "{failure:?}");
        let none = from_columns(Vec::new(), Vec::new(), &ReadOptions::default()).expect_err("no rows");
        assert_eq!(none.message, "the table has no rows");
    }

    #[test]
    fn names_of_others_and_no_names_are_read_as_in_text() {
        let scaled = |names| {
            let mut table = columns(names);
            table.iter_mut().flat_map(|column| &mut column.values).for_each(|value| *value *= 10.0);
            from_table(table, "table", &ReadOptions::default()).expect("a log")
        };
        let close = |log: &Log| (log.field_ut[0][7] - ball()[0][7]).abs() < 1e-9;
        assert!(close(&scaled(["MagX (mG)", "MagY (mG)", "MagZ (mG)"])));
        let bare = from_table(columns(["0", "1", "2"]), "table", &ReadOptions::default()).expect("a log");
        assert!(close(&bare));
    }
}
