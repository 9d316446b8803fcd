//! What tells effects of columns from others.

use super::columns::ColumnKind;
use super::family::{Advice, Follows, Subject};

/// The recording that tells an effect of a column from another one.
pub(super) fn apart<'a>(own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
    use ColumnKind::{Current, Temperature};
    let (kind, column) = (ColumnKind::behind(own.column), own.column);
    let told = |text| Some(Advice { text, names: [column, other.column] });
    match other.follows {
        Follows::Column if other.column == column => told(same_column(own, other)),
        Follows::Column => match (kind, ColumnKind::behind(other.column)) {
            (Temperature, Current) => told(
                "{0} follows {1}. Warm the board with {1} at zero (a hair dryer), or switch {1} on and off faster than the \
                 board warms, and log that.",
            ),
            // The temperature tells it.
            (Current, Temperature) => None,
            _ => told("log again, changing {0} while {1} stays, and then {1} while {0} stays."),
        },
        Follows::Time => match (kind, other.is_sudden()) {
            (Temperature, false) => told(
                "{0} only ever went one way, as the clock does. Log while it warms up and while it cools down again; \
                 or warm the board up first and then turn it at constant temperature: an error that goes on is drift.",
            ),
            (Temperature, true) => told(
                "let {0} change slowly and go back to where it began: what stays afterwards is a step, what goes away \
                 is temperature.",
            ),
            (Current, _) => told(
                "switch {0} on and off several times in one log, at uneven intervals, while the board turns: only what \
                 comes and goes with it is {0}.",
            ),
            (_, false) => {
                told("log again, taking {0} up and down several times: a drift does not turn back.")
            }
            (_, true) => told("log again, changing {0} several times: a step does not happen again."),
        },
        Follows::Tone | Follows::Attitude | Follows::Turning => None,
    }
}

fn same_column(own: &Subject, other: &Subject) -> &'static str {
    if own.form.is_late() && other.form.is_late() {
        "change {0} abruptly, several times, and wait: what is late jumps later, what goes through a low-pass creeps."
    } else if own.form.is_late() != other.form.is_late() {
        "change {0} abruptly, several times: a late effect then trails visibly behind it."
    } else if own.form.is_squared() != other.form.is_squared() {
        "take {0} through its whole range, and both signs if it has two: a square does not change sign."
    } else {
        "turn the board through all directions at the lowest {0}, and again at the highest: an offset is the same in \
         every direction, a gain or a change of the field is not."
    }
}
