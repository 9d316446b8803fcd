//! From a log to a judged calibration: the base model that `diagnose` begins with too ([`crate::base::ground`]), coverage, and
//! the core's verdict. With effects or on top of an earlier calibration the study fits the same samples.

use crate::base::ground::Ground;
use crate::fit::fitted::Fitted;
use crate::fit::{confined, extended, ids, recordings, vehicle};
use crate::outcome::contradiction::freed;
use crate::outcome::request::{Options, Refusal};
use crate::reason::Reason;
use crate::table::Table;
use crate::threads::with_room;

/// Fits a log. The fit may be refused; the counts of what was used and set aside are there anyway.
///
/// # Errors
/// Only where `options` ask for an effect that is not known or that this log does not allow.
pub fn fit(table: &Table, options: &Options) -> Result<Fitted, Refusal> {
    ids::check(table, &options.add, options.registry)?;
    with_room(|| {
        let (fitted, recordings) =
            recordings::of_one_offset(table, options, |ground| of_ground(&ground, options))?;
        Ok(fitted.of_recordings(table, recordings))
    })
}

/// The same of a log whose samples are sorted out, with `with_room` to work in; the ids are checked.
pub(crate) fn of_ground(ground: &Ground, options: &Options) -> Result<Fitted, Refusal> {
    let freed = freed(ground, options)?;
    let (options, contradiction) = match &freed {
        Some((freed, contradiction)) => (freed, Some(contradiction)),
        None => (options, None),
    };
    let fitted = Fitted::new(&ground.counted, options);
    let fitted = match options.add.is_empty() && options.prior.is_none() {
        true => fitted.of_base(ground, options.registry),
        false => extended::run(ground, options, fitted)?,
    };
    let fitted = confined::tried(ground, options, fitted);
    let mut fitted = vehicle::advised(ground, options, fitted);
    if let Some(contradiction) = contradiction {
        let words = format!("note: {}", contradiction.words());
        fitted.reasons.push(Reason::new("contradicts-prior", words));
        fitted.contradiction = Some(contradiction.clone());
    }
    Ok(fitted)
}
