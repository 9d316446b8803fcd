//! What tells effects that turn with the board, functions of the reading alone, from others.

use super::family::{Advice, Follows, Subject};

/// The recording that tells such an effect from another one.
pub(super) fn apart<'a>(_: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
    let text = match other.follows {
        Follows::Attitude => {
            "record all directions evenly, then again with a small magnet fixed near the sensor (a large offset): squares \
             and products of axes grow differently with it."
        }
        Follows::Column => {
            "keep {0} constant in one log of all directions: the remaining error comes from the sensor itself."
        }
        Follows::Time => {
            "move through all directions twice in one log: the sensor's own errors repeat, errors that depend on time do \
             not."
        }
        Follows::Tone | Follows::Turning => return None,
    };
    Some(Advice { text, names: [other.column, ""] })
}
