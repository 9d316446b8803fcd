//! Columns that are the three axes of one vector.

use crate::input::names::{Kind, Meaning, meaning};
use crate::input::text::grid::Grid;
use crate::input::unit::{Quantity, Unit};

/// Three columns of one sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Vector {
    /// What it is of; [`Kind::Other`] where the names are x, y and z and no more.
    pub kind: Kind,
    /// The columns of x, y, z.
    pub columns: [usize; 3],
    /// The unit in the names.
    pub unit: Option<Unit>,
    /// Whether the names speak of counts.
    pub counts: bool,
    /// The name without the axis.
    pub stem: String,
    /// Uncalibrated before calibrated.
    pub rank: i8,
}

/// What every header means, with the unit that the layout knows.
pub fn meanings(grid: &Grid) -> Vec<Meaning> {
    let understood = |column: &crate::input::text::grid::GridColumn| {
        let mut found = meaning(&column.header);
        if found.unit.is_none() {
            found.unit.clone_from(&column.unit);
        }
        let of_field = found.unit.as_ref().and_then(|unit| unit.quantity) == Some(Quantity::Field);
        if found.kind == Kind::Other && found.axis.is_some() && of_field {
            found.kind = Kind::Field;
        }
        found
    };
    grid.columns.iter().map(understood).collect()
}

/// All complete vectors, in the order of the file.
pub fn vectors(meanings: &[Meaning]) -> Vec<Vector> {
    // Kind and stem of a vector, and its axes with their columns.
    type Group<'a> = (Kind, &'a str, Vec<(usize, usize)>);
    let mut groups: Vec<Group<'_>> = Vec::new();
    for (column, meaning) in meanings.iter().enumerate() {
        let Some(axis) = meaning.axis else { continue };
        let bare = meaning.kind == Kind::Other
            && meaning.stem.split('_').all(|word| matches!(word, "" | "raw" | "uncal" | "uncalibrated"));
        if !bare && !matches!(meaning.kind, Kind::Field | Kind::Accel | Kind::Gyro) {
            continue;
        }
        match groups.iter_mut().find(|(kind, stem, _)| *kind == meaning.kind && *stem == meaning.stem) {
            Some((_, _, axes)) => axes.push((axis, column)),
            None => groups.push((meaning.kind, &meaning.stem, vec![(axis, column)])),
        }
    }
    let mut found: Vec<Vector> = groups
        .into_iter()
        .filter_map(|(kind, stem, axes)| {
            // mag_1, mag_2, mag_3 count from one.
            let from_one =
                axes.iter().any(|(axis, _)| *axis == 3) && !axes.iter().any(|(axis, _)| *axis == 0);
            let column = |wanted: usize| {
                axes.iter()
                    .find(|(axis, _)| *axis == wanted + usize::from(from_one))
                    .map(|(_, column)| *column)
            };
            let columns = [column(0)?, column(1)?, column(2)?];
            let unit = columns.iter().find_map(|column| meanings.get(*column)?.unit.clone());
            let counts = columns.iter().all(|column| meanings.get(*column).is_some_and(|m| m.counts));
            let rank =
                columns.iter().filter_map(|column| meanings.get(*column)).map(|m| m.rank).max().unwrap_or(0);
            Some(Vector { kind, columns, unit, counts, stem: stem.to_string(), rank })
        })
        .collect();
    found.sort_by_key(|vector| vector.columns.iter().min().copied());
    found
}
