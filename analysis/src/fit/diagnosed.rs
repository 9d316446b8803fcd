//! A diagnosis that the fit bears out: where it says that nothing is missing, or what is, `fit` with that accepts.

use crate::base::ground::Ground;
use crate::fit::fitted::Fitted;
use crate::fit::run::of_ground;
use crate::fit::{ids, pair, recordings};
use crate::outcome::contradiction::freed;
use crate::outcome::outcome::{Diagnosis, Verdict};
use crate::outcome::request::{Options, Refusal};
use crate::outcome::study::study;
use crate::plausible::causes::no_causes;
use crate::reason::Reason;
use crate::table::Table;
use crate::threads::with_room;
use crate::unlogged::pair::Pair;
use std::borrow::Cow;

/// The diagnosis of a log.
///
/// # Errors
/// Only where `options` ask for an effect that is not known or that this log does not allow.
pub fn diagnose(table: &Table, options: &Options) -> Result<Diagnosis, Refusal> {
    with_room(|| {
        let (diagnosis, recordings) = recordings::of_one_offset(table, options, |mut ground| {
            leave_out(&mut ground, options);
            of_ground_searched(&ground, options)
        })?;
        let found = recordings.is_some();
        Ok(Diagnosis { recordings, pair: other(table, options, found), ..diagnosis })
    })
}

/// The fit and the diagnosis of a log, of the same samples.
///
/// # Errors
/// As [`diagnose`].
pub fn fit_and_diagnose(table: &Table, options: &Options) -> Result<(Fitted, Diagnosis), Refusal> {
    ids::check(table, &options.add, options.registry)?;
    with_room(|| {
        let ((fitted, diagnosis), recordings) = recordings::of_one_offset(table, options, |mut ground| {
            let fitted = of_ground(&ground, options)?;
            leave_out(&mut ground, options);
            let kept = Options { force_effect: true, ..options.clone() };
            Ok((fitted, of_ground_searched(&ground, &kept)?))
        })?;
        let found = recordings.is_some();
        Ok((
            fitted.of_recordings(table, recordings.clone()),
            Diagnosis { recordings, pair: other(table, options, found), ..diagnosis },
        ))
    })
}

/// What the log's other magnetometer shows; nothing where the offsets of recordings differ, which is no disturbance of one sensor.
fn other(table: &Table, options: &Options, offsets_differ: bool) -> Option<Pair> {
    if offsets_differ { None } else { pair::of_table(table, options) }
}

/// Leaves the columns that cause nothing out of a search, but for those that `options` name.
pub(crate) fn leave_out(ground: &mut Ground, options: &Options) {
    if !options.search {
        return;
    }
    let table = ground.counted.table;
    let named: Vec<_> = options.add.iter().filter_map(|id| options.registry.parse(id)).collect();
    for one in no_causes(table) {
        let Some(name) = table.covariates.get(one.covariate).map(|covariate| covariate.name) else {
            continue;
        };
        if named.iter().any(|named| named.columns().any(|column| column == name)) {
            continue;
        }
        let counted = &mut ground.counted;
        for samples in [Some(&mut counted.samples), counted.with_bursts.as_mut()].into_iter().flatten() {
            for column in samples.columns.iter_mut().filter(|column| column.name == name) {
                column.problem = Some(format!("{name} is not a candidate: it is {}", one.what));
                column.causes_nothing = true;
            }
        }
    }
}

/// The same of a log whose samples are sorted out, with `with_room` to work in.
pub(crate) fn of_ground_searched(ground: &Ground, options: &Options) -> Result<Diagnosis, Refusal> {
    let Believed { mut diagnosis, options } = believed(ground, options)?;
    let options = options.as_ref();
    if let Some(why) = refused(ground, options, &diagnosis) {
        let instead = match diagnosis.verdict {
            // What is at the end of the range is told among the faults, and the model is what it is.
            _ if why.of_data => None,
            Verdict::Complete => Some(Verdict::Undetermined),
            Verdict::Missing => Some(Verdict::Unexplained),
            Verdict::Confounded | Verdict::Unexplained | Verdict::Undetermined => None,
        };
        if let Some(instead) = instead {
            // What was found was held to explain all.
            diagnosis.only_unsure = diagnosis.verdict == Verdict::Missing;
            diagnosis.verdict = instead;
            diagnosis.reasons.push(why.reason.clone());
        }
        diagnosis.fit_refuses = Some(why.reason.words);
    }
    Ok(diagnosis)
}

/// A diagnosis with what of an earlier calibration it builds on.
struct Believed<'o> {
    diagnosis: Diagnosis,
    options: Cow<'o, Options>,
}

/// The diagnosis on top of as much of the earlier calibration as the log bears out. What contradicts it may be an effect that was not
/// there then: the earlier calibration stands where the effects that are named agree with it, and the log names as many without it or
/// is undetermined.
fn believed<'o>(ground: &Ground, options: &'o Options) -> Result<Believed<'o>, Refusal> {
    let diagnosis = study(ground, options)?;
    let Some((without, contradiction)) = freed(ground, options)? else {
        return Ok(Believed { diagnosis, options: Cow::Borrowed(options) });
    };
    let mut anew = study(ground, &without)?;
    let named = |one: &Diagnosis| one.steps.iter().filter_map(|step| step.added.clone()).collect::<Vec<_>>();
    let effects = named(&diagnosis);
    let as_many = effects.len() <= named(&anew).len() || anew.verdict == Verdict::Undetermined;
    if effects.len() > options.add.len() && as_many {
        let with = Options { add: effects, ..options.clone() };
        if freed(ground, &with)?.is_none() {
            return Ok(Believed { diagnosis, options: Cow::Borrowed(options) });
        }
    }
    anew.reasons.push(Reason::new("contradicts-prior", contradiction.words()));
    anew.contradiction = Some(contradiction);
    Ok(Believed { diagnosis: anew, options: Cow::Owned(without) })
}

/// Why a fit is refused.
struct Why {
    reason: Reason,
    /// For a fault of the data, and not for the model.
    of_data: bool,
}

/// Why `fit` refuses the calibration that the diagnosis leads to; `None` where it accepts, or where none is led to.
fn refused(ground: &Ground, options: &Options, diagnosis: &Diagnosis) -> Option<Why> {
    // Of a resting board, of a sensor that is taken as calibrated, and before the axes are in order there is none.
    let leads = diagnosis.calibration.is_some() && !ground.counted.rests && diagnosis.axis_order().is_none();
    let (add, _) = diagnosis.to_add(&options.add);
    let claims = matches!(diagnosis.verdict, Verdict::Complete | Verdict::Missing);
    if !leads || !(claims || !add.is_empty() && diagnosis.verdict == Verdict::Unexplained) {
        return None;
    }
    let asked = Options { add, search: false, chances: diagnosis.chances.clone(), ..options.clone() };
    match of_ground(ground, &asked) {
        Ok(Fitted { accepted: true, .. }) => None,
        Ok(Fitted { reasons, only_saturated: of_data, .. }) => {
            let reason = reasons.into_iter().find(|reason| !reason.starts_with("note:"));
            Some(Why {
                reason: reason.unwrap_or_else(|| Reason::new("fit-refused", "the fit refuses this log")),
                of_data,
            })
        }
        Err(refusal) => Some(Why { reason: Reason::new("fit-refused", refusal.to_string()), of_data: false }),
    }
}
