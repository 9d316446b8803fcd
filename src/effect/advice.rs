//! The recording that would tell two effects of this crate apart, without the families: firmware carries none of them.

use super::apart::apart;
use super::column_name::ColumnName;
use super::family::{Follows, Subject};
use super::parts::Parts;
use super::registry::BuiltIn;
use core::fmt;

/// What is said where nothing better is known.
const RECORD_AGAIN: &str =
    "record again for longer, in more orientations and at different speeds, with pauses";

/// Hands on the recording that would tell two effects of this crate apart, whichever of the two knows one.
pub(crate) fn advice(one: &BuiltIn<f64>, other: &BuiltIn<f64>, mut use_it: impl FnMut(&dyn fmt::Display)) {
    let parts = [one.parts(), other.parts()];
    let subject = |parts: &'_ Parts<ColumnName>| {
        let follows = if parts.form.column { Follows::Column } else { Follows::Time };
        (follows, parts.form)
    };
    let [(f, form_f), (g, form_g)] = [subject(&parts[0]), subject(&parts[1])];
    let first = Subject { follows: f, column: parts[0].column.as_str(), form: form_f };
    let second = Subject { follows: g, column: parts[1].column.as_str(), form: form_g };
    // In one order, whichever comes first.
    let swap = first.column > second.column;
    let (first, second) = if swap { (second, first) } else { (first, second) };
    let advises = |own: &Subject<'_>, other: &Subject<'_>, use_it: &mut dyn FnMut(&dyn fmt::Display)| {
        if own.follows != Follows::Column {
            return false;
        }
        apart(own, other).inspect(|advice| use_it(advice)).is_some()
    };
    if !advises(&first, &second, &mut use_it) && !advises(&second, &first, &mut use_it) {
        use_it(&RECORD_AGAIN);
    }
}
