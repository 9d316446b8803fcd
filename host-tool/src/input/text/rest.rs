//! Every other column: a covariate of its own, or left out with a reason.

use crate::input::followed::name_of;
use crate::input::names::{Kind, Meaning};
use crate::input::text::choice::{Choice, FIELD_COUNTS, FIELD_UT, Taken};
use crate::input::text::grid::{Grid, GridColumn};
use crate::input::text::vectors::Vector;
use crate::input::unit::Quantity;

/// Takes what is numeric and can be a cause; says what is not read.
pub fn covariates(grid: &Grid, meanings: &[Meaning], vectors: &[Vector], choice: &mut Choice) {
    let others =
        vectors.iter().filter(|vector| matches!(vector.kind, Kind::Field | Kind::Accel | Kind::Gyro));
    let sensors: Vec<usize> = others.flat_map(|vector| vector.columns).collect();
    let said: String = choice.not_read.join("; ");
    let mut found: Vec<Taken> = Vec::new();
    let of_field = |taken: &&Taken| FIELD_UT.iter().chain(&FIELD_COUNTS).any(|name| *name == taken.name);
    let field: Vec<usize> = choice.taken.iter().filter(of_field).map(|taken| taken.column).collect();
    let added: Vec<usize> = choice.added.iter().flatten().copied().collect();
    for (index, (column, meaning)) in grid.columns.iter().zip(meanings).enumerate() {
        if choice.has(index)
            || sensors.contains(&index)
            || added.contains(&index)
            || choice.set_aside.contains(&index)
        {
            continue;
        }
        let header = &column.header;
        let finite =
            choice.rows.iter().filter(|row| column.values.get(**row).is_some_and(|v| v.is_finite())).count();
        let why = if is_magnitude(grid, &field, column, &choice.rows) {
            Some("the magnitude of the field")
        } else if column.texts > 0 && column.texts * 2 > finite {
            Some("text")
        } else if finite == 0 {
            Some("empty")
        } else {
            match meaning.kind {
                Kind::Time => Some("another time"),
                Kind::Derived => Some("computed from the field itself"),
                Kind::Field => Some("a part of a field"),
                Kind::Attitude if header != "heading_deg" => Some("attitude, computed from the field"),
                Kind::Counter | Kind::Instance => counts_rows(column, &choice.rows).then_some("a row number"),
                Kind::Other if header.starts_with("column ") => {
                    counts_rows(column, &choice.rows).then_some("increases with the rows")
                }
                _ => None,
            }
        };
        match why {
            Some(why) if !said.contains(header.as_str()) => choice.not_read.push(format!("{header} ({why})")),
            Some(_) => {}
            None => {
                let by_program = choice.program.and_then(|program| program.unit(meaning.kind, header));
                let unit = meaning.unit.clone().or(by_program);
                let unit = unit.filter(|unit| {
                    matches!(
                        unit.quantity,
                        Some(Quantity::Temperature | Quantity::Current | Quantity::Voltage)
                    )
                });
                let mut name = name_of(header, meaning, unit.as_ref());
                while choice.has_name(&name) || found.iter().any(|taken| taken.name == name) {
                    name.push('_');
                }
                found.push(Taken { column: index, name, unit });
            }
        }
    }
    choice.taken.extend(found);
}

/// Whether a column is the length of the field in every row, in any unit.
pub fn is_magnitude(grid: &Grid, field: &[usize], column: &GridColumn, rows: &[usize]) -> bool {
    let ratio = |row: &usize| -> Option<f64> {
        let square = |index: &usize| grid.columns.get(*index)?.values.get(*row).map(|value| value * value);
        let norm = field.iter().filter_map(square).sum::<f64>().sqrt();
        Some(column.values.get(*row)? / norm).filter(|ratio| ratio.is_finite())
    };
    let ratios: Vec<f64> = rows.iter().filter_map(ratio).collect();
    let [least, most] = [f64::min, f64::max].map(|pick| ratios.iter().copied().reduce(pick).unwrap_or(0.0));
    let [short, long] = [f64::min, f64::max].map(|pick| {
        rows.iter()
            .filter_map(|row| column.values.get(*row))
            .copied()
            .filter(|v| v.is_finite())
            .reduce(pick)
            .unwrap_or(0.0)
    });
    // A constant next to a constant magnitude proves nothing.
    ratios.len() > 10 && least > 0.0 && most < 1.01 * least && long > 1.03 * short
}

/// Whether a column only counts: whole numbers that never fall, and rise by one or by a step that is always the same.
fn counts_rows(column: &GridColumn, rows: &[usize]) -> bool {
    let values: Vec<f64> =
        rows.iter().filter_map(|row| column.values.get(*row)).copied().filter(|v| v.is_finite()).collect();
    values.len() > 2 && values.windows(2).all(|pair| pair[1] > pair[0] && pair[1].fract() == 0.0)
}

/// A number for a sentence: three digits.
pub fn rounded(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    match digits {
        0..=6 => format!("{value:.*}", digits as usize),
        -3..0 => format!("{value:.0}"),
        _ => format!("{value:.2e}"),
    }
}
