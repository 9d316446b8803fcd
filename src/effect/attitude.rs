//! What tells effects that turn with the board, functions of the reading alone, from others.

use super::family::{Advice, Follows, Subject};

/// The recording that tells such an effect from another one.
pub(super) fn apart<'a>(_: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
    let text = match other.follows {
        Follows::Attitude => {
            "record every direction evenly, then again with a small magnet fixed near the sensor (a large offset): \
             squares and products of axes grow differently with it."
        }
        Follows::Column => {
            "hold {0} constant through one log of all directions: what is left is the sensor itself."
        }
        Follows::Time => {
            "go through all directions twice in one log: the sensor's own errors repeat, what depends on time does \
             not."
        }
        Follows::Tone | Follows::Turning => return None,
    };
    Some(Advice { text, names: [other.column, ""] })
}
