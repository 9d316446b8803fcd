//! Which column is time, and in which unit.

use crate::failure::Outcome;
use crate::input::names::{Kind, Meaning};
use crate::input::text::asked;
use crate::input::text::choice::{Choice, Taken};
use crate::input::text::grid::Grid;
use crate::input::text::magnitude::{self, Clock};
use crate::input::text::table::MONITOR;
use crate::input::unit::{Quantity, Unit};

/// Chooses the column of time; a table without one has none.
///
/// # Errors
/// A unit that may be one or another.
pub fn time(grid: &Grid, meanings: &[Meaning], choice: &mut Choice) -> Outcome<()> {
    let named: Vec<usize> = meanings
        .iter()
        .enumerate()
        .filter(|(index, meaning)| meaning.kind == Kind::Time && !choice.has(*index))
        .map(|(index, _)| index)
        .collect();
    if choice.has_name("t_s") {
        return Ok(());
    }
    let mut best: Option<(i32, usize, Option<Unit>, Clock)> = None;
    for index in named {
        let (Some(column), Some(meaning)) = (grid.columns.get(index), meanings.get(index)) else { continue };
        let Some(clock) = magnitude::clock(&column.values, &choice.rows) else { continue };
        let dated = column.dates * 2 > choice.rows.len();
        let by_program = choice.program.and_then(|program| program.unit(Kind::Time, &column.header));
        let unit = match (dated, &meaning.unit, by_program) {
            (true, _, _) => Unit::of("ISO", Quantity::Time),
            (false, Some(unit), _) => Some(unit.clone()),
            (false, None, program) => program,
        };
        // A sensor's own stamp before the time of writing, a known unit before one that is not; the monitor's time last.
        let stamp = column.header.contains("stamp") && column.header.contains("header");
        let rank = 4 * i32::from(unit.is_some()) + 2 * i32::from(stamp) + i32::from(!dated)
            - 16 * i32::from(column.header == MONITOR);
        if best.as_ref().is_none_or(|(known, ..)| rank > *known) {
            best = Some((rank, index, unit, clock));
        }
    }
    let Some((_, column, unit, clock)) = best else { return Ok(()) };
    let unit = match (unit, clock.units.as_slice()) {
        (Some(unit), _) => unit,
        (None, [only]) => {
            let header = grid.columns.get(column).map(|column| column.header.clone()).unwrap_or_default();
            let why = if clock.epoch {
                "that makes it a date of this century"
            } else {
                "in which its steps are a sensor's"
            };
            choice.reasons.push(format!("{header} is in {}, the only unit {why}", only.name));
            only.clone()
        }
        (None, units) => return Err(asked::time_unit(grid, column, units, clock.step)),
    };
    choice.taken.push(Taken { column, name: "t_s".into(), unit: Some(unit) });
    Ok(())
}
