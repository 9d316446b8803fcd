//! What tells effects of columns from others.

use super::columns::ColumnKind;
use super::family::{Advice, Follows, Subject};

/// The recording that tells an effect of a column from another one.
pub(super) fn apart<'a>(own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
    use ColumnKind::{Current, Temperature};
    let (kind, column) = (ColumnKind::behind(own.column), own.column);
    let advice = |text| Some(Advice { text, names: [column, other.column] });
    match other.follows {
        Follows::Column if other.column == column => advice(same_column(own, other)),
        Follows::Column => match (kind, ColumnKind::behind(other.column)) {
            (Temperature, Current) => advice(
                "{0} depends on {1}. Warm the sensor with {1} at zero (a hair dryer), or switch {1} on and off faster than \
                 the sensor warms up, and log that.",
            ),
            // The temperature tells it.
            (Current, Temperature) => None,
            _ => advice("log again: change {0} while {1} stays constant, then {1} while {0} stays constant."),
        },
        Follows::Time => match (kind, other.is_sudden()) {
            (Temperature, false) => advice(
                "{0} changed in one direction only, like time. Log while it warms up and while it cools down again. Or warm \
                 the sensor up first and then rotate it at constant temperature: an error that continues to grow is drift.",
            ),
            (Temperature, true) => advice(
                "let {0} change slowly and return to its first value: an error that remains is a step, an error that \
                 disappears depends on {0}.",
            ),
            (Current, _) => advice(
                "switch {0} on and off several times in one log, at irregular intervals, while you rotate the sensor: an \
                 error that appears and disappears with it is caused by {0}.",
            ),
            (_, false) => {
                advice("log again, and raise and lower {0} several times: a drift does not reverse.")
            }
            (_, true) => advice("log again, and change {0} several times: a step does not repeat."),
        },
        Follows::Tone | Follows::Attitude | Follows::Turning => None,
    }
}

fn same_column(own: &Subject, other: &Subject) -> &'static str {
    if own.form.is_late() && other.form.is_late() {
        "change {0} abruptly, several times, and wait: a delayed effect jumps later, a low-pass filtered one changes gradually."
    } else if own.form.is_late() != other.form.is_late() {
        "change {0} abruptly, several times: a delayed effect then trails visibly behind it."
    } else if own.form.is_squared() != other.form.is_squared() {
        "move {0} through its whole range, and through both signs if it has two: a square does not change sign."
    } else {
        "rotate the sensor through all directions at the lowest {0}, and again at the highest: an offset is the same in \
         every direction, a gain or a change of the field is not."
    }
}
