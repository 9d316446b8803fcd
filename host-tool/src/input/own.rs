//! Which header is that of the program's own CSV.

use crate::input::columns::{self, Role};
use crate::input::log::ReadOptions;
use crate::input::map;
use crate::input::names::{Kind, meaning};

/// Whether a header is that of this program's own CSV. `number` is its line.
pub fn is_own(header: &[String], options: &ReadOptions, number: u64) -> bool {
    // A table of several sensors is split, which the strict reader does not.
    if header.iter().any(|cell| meaning(cell).kind == Kind::Instance) {
        return false;
    }
    let stated = options
        .map
        .iter()
        .any(|(_, from)| map::resolve(from, header).is_some_and(|(_, unit)| unit.is_some()));
    let is_own = |map: &[(String, String)]| {
        // A column twice is an error of the format, not another format.
        let names: Vec<Role> = match columns::interpret(header, map, number) {
            Ok(found) => found.iter().map(|column| column.role).collect(),
            Err(_) => header.iter().map(|cell| Role::of(cell).1).collect(),
        };
        let whole = |make: fn(usize) -> Role| (0..3).all(|axis| names.contains(&make(axis)));
        let timed =
            names.contains(&Role::Time) || !header.iter().any(|cell| meaning(cell).kind == Kind::Time);
        (whole(Role::FieldUt) || whole(Role::FieldCounts)) && timed
    };
    is_own(&[]) || (!stated && is_own(&options.map))
}
