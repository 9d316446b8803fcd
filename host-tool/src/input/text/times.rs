//! Which column is time, and in which unit.

use crate::failure::Outcome;
use crate::input::names::{Kind, Meaning};
use crate::input::text::asked;
use crate::input::text::choice::{Choice, Taken};
use crate::input::text::grid::{Grid, GridColumn};
use crate::input::text::magnitude::{self, Clock};
use crate::input::text::rest::rounded;
use crate::input::text::table::MONITOR;
use crate::input::unit::{Quantity, Unit};

/// Two times of one log go equally far within this share: one is in whole seconds, and clocks drift.
const SAME_SPAN: f64 = 0.02;
/// Seconds since 1970 of this century's logs.
const SINCE_1970_S: std::ops::RangeInclusive<f64> = 1e9..=4e9;

/// Chooses the column of time; a table without one has none.
///
/// # Errors
/// A unit that may be one or another.
pub fn time(grid: &Grid, meanings: &[Meaning], choice: &mut Choice) -> Outcome<()> {
    let is_joined = |index: usize| {
        let header = grid.columns.get(index).map(|column| &column.header);
        grid.joined_time.as_ref().is_some_and(|(seconds, ..)| header == Some(seconds))
    };
    let named: Vec<usize> = meanings
        .iter()
        .enumerate()
        .filter(|(index, meaning)| (meaning.kind == Kind::Time || is_joined(*index)) && !choice.has(*index))
        .map(|(index, _)| index)
        .collect();
    if let Some((seconds, part, unit)) = &grid.joined_time {
        choice.reasons.push(format!("{seconds} and {part} form one time: seconds and {unit}"));
    }
    if choice.has_name("t_s") {
        return Ok(());
    }
    let mut found: Vec<Candidate> = Vec::new();
    let mut backward: Vec<String> = Vec::new();
    for index in named {
        let (Some(column), Some(meaning)) = (grid.columns.get(index), meanings.get(index)) else { continue };
        let Some(clock) = magnitude::clock(&column.values, &choice.rows) else {
            backward.extend(runs_backward(column, &choice.rows));
            continue;
        };
        let dated = column.dates * 2 > choice.rows.len();
        let monitor = column.header == MONITOR;
        let by_program = choice.program.and_then(|program| program.unit(Kind::Time, &column.header));
        let unit = match (dated, &meaning.unit, by_program) {
            (true, _, _) => Unit::of("ISO", Quantity::Time),
            (false, Some(unit), _) => Some(unit.clone()),
            // A clock's time is read as seconds.
            (false, None, None) if monitor => Unit::of("s", Quantity::Time),
            (false, None, program) => program.or_else(|| since_1970(grid, index, &choice.rows)),
        };
        // A sensor's own stamp before the time of writing, a known unit before one that is not; the monitor's time last.
        let stamp = column.header.contains("stamp") && column.header.contains("header");
        let rank = 4 * i32::from(unit.is_some()) + 2 * i32::from(stamp) + i32::from(!dated)
            - 16 * i32::from(monitor);
        found.push(Candidate { rank, column: index, unit, clock });
    }
    let Some(best) = found.iter().rev().max_by_key(|candidate| candidate.rank) else {
        choice.not_read.extend(backward);
        return Ok(());
    };
    if let Some((column, unit, why)) = finer(grid, best, &found, &choice.rows) {
        choice.reasons.push(why);
        choice.taken.push(Taken { column, name: "t_s".into(), unit: Some(unit) });
        return Ok(());
    }
    let Candidate { column, unit, clock, .. } = best;
    let header = grid.columns.get(*column).map(|column| column.header.clone()).unwrap_or_default();
    let unit = match (unit, clock.units.as_slice()) {
        (Some(unit), _) => unit.clone(),
        (None, [only]) => {
            let why = if clock.epoch {
                "that makes it a date of this century"
            } else {
                "in which its steps are plausible"
            };
            choice.reasons.push(format!("{header} is in {} (the only unit {why})", only.name));
            only.clone()
        }
        (None, []) => {
            choice.not_read.push(format!(
                "{header} (it steps by {}, which is implausible in s, ms, us and ns. ironout reads the log without time)",
                rounded(clock.step)
            ));
            return Ok(());
        }
        (None, units) => return Err(asked::time_unit(grid, *column, units, clock.step)),
    };
    choice.taken.push(Taken { column: *column, name: "t_s".into(), unit: Some(unit) });
    Ok(())
}

/// What is said of a column named as a time that runs backward; `None` where it does not.
fn runs_backward(column: &GridColumn, rows: &[usize]) -> Option<String> {
    let times: Vec<f64> = rows.iter().filter_map(|row| column.values.get(*row).copied()).collect();
    let backward = times.windows(2).filter(|pair| pair[1] < pair[0]).count();
    (backward > 0).then(|| {
        format!(
            "{} (it decreases in {backward} of {} rows. ironout reads the log without time. To use it, sort the log)",
            column.header,
            rows.len()
        )
    })
}

/// A column that can be time.
struct Candidate {
    rank: i32,
    column: usize,
    unit: Option<Unit>,
    clock: Clock,
}

/// The unit of a time whose name says that it counts from 1970, however far its rows are apart.
fn since_1970(grid: &Grid, column: usize, rows: &[usize]) -> Option<Unit> {
    let column = grid.columns.get(column)?;
    let name = column.header.to_lowercase();
    let first = *column.values.get(*rows.first()?)?;
    let is = ["unix", "epoch", "posix"].iter().any(|word| name.contains(word));
    Unit::all(Quantity::Time).filter(|_| is).find(|unit| SINCE_1970_S.contains(&unit.convert(first)))
}

/// A time without a known unit that goes with the known one, and is finer than its whole seconds.
fn finer(grid: &Grid, best: &Candidate, all: &[Candidate], rows: &[usize]) -> Option<(usize, Unit, String)> {
    let known = best.unit.as_ref()?;
    let span = |column: usize| {
        let values = &grid.columns.get(column)?.values;
        let finite = |row: &&usize| values.get(**row).is_some_and(|value| value.is_finite());
        let (first, last) = (rows.iter().find(finite)?, rows.iter().rev().find(finite)?);
        Some(values.get(*last)? - values.get(*first)?)
    };
    let whole = |column: usize, unit: &Unit| {
        let values = grid.columns.get(column).map(|column| column.values.as_slice()).unwrap_or_default();
        rows.iter().filter_map(|row| values.get(*row)).all(|value| unit.convert(*value).fract() == 0.0)
    };
    if !whole(best.column, known) {
        return None;
    }
    let seconds = known.convert(span(best.column)?);
    let others = all.iter().filter(|other| other.column != best.column && other.unit.is_none());
    others.into_iter().find_map(|other| {
        let own = span(other.column)?;
        let agrees = |unit: &Unit| (unit.convert(own) / seconds - 1.0).abs() < SAME_SPAN;
        let unit = Unit::all(Quantity::Time).find(agrees).filter(|unit| !whole(other.column, unit))?;
        let name = |column: usize| grid.columns.get(column).map(|c| c.header.clone()).unwrap_or_default();
        let why = format!(
            "{} is in {}: in that unit it agrees with {}, which has whole seconds only",
            name(other.column),
            unit.name,
            name(best.column)
        );
        Some((other.column, unit, why))
    })
}
