//! The end of the explanation: the verdict in a sentence, and what to do about it.

use crate::cli::{DiagnoseArgs, typed_option};
use crate::diagnosis_words::numbers::{degrees, microtesla, wrap};
use crate::diagnosis_words::told::{Told, WIDTH, at_rest, groups, listed, name_of, title};
use crate::diagnosis_words::{found, next};
use crate::log_args::SAVED;
use ironout_analysis::base::mounting;
use ironout_analysis::outcome::outcome::{Diagnosis, Status, Verdict};
use ironout_analysis::samples::faults::FaultKind;
use std::path::Path;

/// Whether the last step leaves what the noise leaves.
fn at_the_noise(diagnosis: &Diagnosis) -> bool {
    let last = diagnosis.steps.last().zip(diagnosis.residual_floor_ut);
    last.is_some_and(|(last, floor)| last.rms_ut <= 1.1 * floor)
}

/// Whether nothing is left to look for in this log, though its calibration is not sure enough.
fn is_only_unsure(diagnosis: &Diagnosis) -> bool {
    diagnosis.only_unsure && at_the_noise(diagnosis) && diagnosis.field_varies.is_none()
}

/// What the error does from the first step to the last, in words; empty where it does nothing.
fn fall(diagnosis: &Diagnosis) -> String {
    let (Some(first), Some(last)) = (diagnosis.steps.first(), diagnosis.steps.last()) else {
        return String::new();
    };
    if first.rms_ut > 1.02 * last.rms_ut {
        // Where structure is left beside the noise it is not only that.
        let all = diagnosis.verdict != Verdict::Unexplained || is_only_unsure(diagnosis);
        let noise = if all && at_the_noise(diagnosis) { ", which is what the noise leaves" } else { "" };
        return format!(
            "the error falls from {} to {} µT{noise}",
            microtesla(first.rms_ut),
            microtesla(last.rms_ut)
        );
    }
    match (first.dip_rms_deg, last.dip_rms_deg) {
        (Some(before), Some(after)) if before > 1.02 * after => {
            format!("the spread of the dip falls from {} to {}", degrees(before), degrees(after))
        }
        _ => String::new(),
    }
}

/// The verdict in one sentence, or two.
pub fn sentence(diagnosis: &Diagnosis) -> String {
    let names: Vec<String> = diagnosis
        .steps
        .iter()
        .filter_map(|step| step.added.as_deref())
        .map(|id| name_of(diagnosis, id))
        .collect();
    let (it, they) = if names.len() == 1 { ("it", "it") } else { ("them", "they") };
    let fall = fall(diagnosis);
    let reasons = diagnosis.reasons.join("; ");
    match diagnosis.verdict {
        Verdict::Complete if at_rest(diagnosis) => {
            "COMPLETE: the resting board's reading is constant but for noise; no column moves it.".to_string()
        }
        Verdict::Complete => {
            "COMPLETE: nothing is missing. Offset and matrix explain this log down to the sensor's noise."
                .to_string()
        }
        Verdict::Missing => {
            let with =
                if fall.is_empty() { String::new() } else { format!(" With {it} in the model, {fall}.") };
            let axes = match found::axis_order(diagnosis) {
                Some(standing) if standing.by_gyro => {
                    " The field turns as the gyro says only when the axes are put in order."
                }
                Some(_) => " The field and gravity agree only when the axes are put in order.",
                None => "",
            };
            format!("MISSING: {}.{with}{axes}", listed(&names))
        }
        Verdict::Confounded => {
            let each: Vec<String> = groups(diagnosis)
                .iter()
                .map(|group| {
                    let names: Vec<String> = group.iter().map(|id| name_of(diagnosis, id)).collect();
                    format!("{} explain the error equally well", listed(&names))
                })
                .collect();
            let known = if names.is_empty() {
                String::new()
            } else {
                format!(" Missing besides: {}.", listed(&names))
            };
            format!("CONFOUNDED: {}, and this log cannot tell which it is.{known}", each.join("; "))
        }
        Verdict::Unexplained => {
            let besides = match (names.is_empty(), fall.is_empty()) {
                (true, _) => String::new(),
                (false, true) => format!(" Found, but not enough: {}.", listed(&names)),
                (false, false) if is_only_unsure(diagnosis) => format!(
                    " With {} {fall}. Nothing else is left to look for in this log; whether that is all, a longer one tells.",
                    listed(&names)
                ),
                (false, false) => format!(
                    " With {} {fall}, but that is not all, and {they} may stand in for something that the log lacks.",
                    listed(&names)
                ),
            };
            format!(
                "UNEXPLAINED: {}.{besides}",
                reasons_or(&reasons, "an error remains that no effect explains")
            )
        }
        Verdict::Undetermined => {
            format!("UNDETERMINED: {}.", reasons_or(&reasons, "this log does not determine a calibration"))
        }
    }
}

fn reasons_or<'a>(reasons: &'a str, otherwise: &'a str) -> &'a str {
    if reasons.is_empty() { otherwise } else { reasons }
}

/// What the error is held against that is no column of the log.
const NO_COLUMNS: [&str; 4] = ["time", "spectrum", "attitude", "rate of turn"];
/// A column is said to go with most of the error from this share of its square on ...
const MOST_OF_IT: f64 = 0.5;
/// ... and below this probability of chance.
const SURELY: f64 = 1e-6;

/// The column that most of the error goes with, where none of its effects is in the model. Says whether there is one.
fn goes_with(diagnosis: &Diagnosis, add: &[String], out: &mut Vec<String>) -> bool {
    let is_column = |name: &str| !NO_COLUMNS.contains(&name);
    let named = |column: &str| add.iter().any(|id| id.contains(&format!(":{column}")));
    let mut columns = diagnosis.shows.iter().filter(|shown| is_column(&shown.against));
    let most = columns.find(|shown| shown.explained > MOST_OF_IT && shown.p_value < SURELY);
    let Some(shown) = most.filter(|shown| !named(&shown.against)) else { return false };
    let why = match diagnosis.verdict {
        Verdict::Undetermined => "but where offset and matrix are not determined nobody is named",
        _ => "though not so surely beside the rest that it is named",
    };
    out.extend(wrap(
        &format!(
            "{:.0} % of the base model's squared error goes with {}, {why}. Record a log in which it changes at many attitudes, \
             up and down again, and diagnose that.",
            100.0 * shown.explained,
            shown.against
        ),
        "  ",
        WIDTH,
    ));
    true
}

/// The verdict.
pub fn verdict(told: &Told, out: &mut Vec<String>) {
    out.push(String::new());
    out.extend(wrap(&sentence(told.diagnosis), "", WIDTH));
    for id in &told.arguments.add {
        let row = told.diagnosis.candidates.iter().find(|row| row.id == *id);
        if let Some(row) = row.filter(|row| row.status == Status::NotNeeded) {
            out.extend(wrap(&format!("{id} was {}.", row.why), "", WIDTH));
        }
    }
}

/// The effects that `fit --add` takes: those in the steps, in their order.
pub fn to_add(diagnosis: &Diagnosis, arguments: &DiagnoseArgs) -> Vec<String> {
    let mut ids: Vec<String> = Vec::new();
    let found = diagnosis.steps.iter().filter_map(|step| step.added.clone());
    for id in arguments.add.iter().filter(|id| !diagnosis.is_not_needed(id)).cloned().chain(found) {
        // These two belong to the alignment, which every fit has.
        if !ids.contains(&id) && !mounting::is_one(&id) {
            ids.push(id);
        }
    }
    ids
}

/// The commands, or the recording, that come next.
pub fn what_next(told: &Told, out: &mut Vec<String>) {
    let Told { log, arguments, diagnosis } = told;
    let piped = log.path == Path::new("-");
    let path = if piped { SAVED.to_string() } else { log.path.display().to_string() };
    title(out, "What to do next");
    let command = |out: &mut Vec<String>, text: String| out.push(format!("    {text}"));
    let say = |out: &mut Vec<String>, text: &str| out.extend(wrap(text, "  ", WIDTH));
    let add = to_add(diagnosis, arguments);
    if piped {
        say(out, &format!("The log came from standard input: save it as {SAVED} first."));
    }
    if let Some(standing) = found::axis_order(diagnosis) {
        if standing.is_open() {
            say(
                out,
                "This log does not tell a mounting from a mirror image. Say where it was recorded, or log heading_deg; or, if \
                 you know which it is, say so:",
            );
            command(out, next::diagnose(arguments, &path, "--at LAT,LON,YYYY-MM-DD"));
        } else {
            say(out, "Put the axes in order (in the driver, or with this option) and diagnose again:");
        }
        for (rotate, _) in standing.readings() {
            command(out, next::diagnose(arguments, &path, typed_option("--rotate", &rotate).trim()));
        }
        return;
    }
    if at_rest(diagnosis) && diagnosis.verdict != Verdict::Undetermined {
        say(
            out,
            "A resting board shows disturbances but no calibration. Turn the board through all directions while the same \
             things change, and diagnose that log; it then goes into the calibration.",
        );
        return;
    }
    if diagnosis.calibration.is_none() && diagnosis.verdict != Verdict::Undetermined {
        say(
            out,
            "This log shows the effect but carries no calibration of its own. Put it on top of an earlier one, or turn the \
             board through all directions while the same things change, and diagnose that log:",
        );
        command(out, format!("{} --prior earlier.json", next::diagnose(arguments, &path, "")));
        return;
    }
    match diagnosis.verdict {
        Verdict::Complete => match &diagnosis.fit_refuses {
            None => {
                say(out, "Calibrate with this log:");
                command(out, next::fit(arguments, &add));
                command(out, next::check(arguments));
            }
            Some(why) => {
                say(out, &format!("This log itself carries no calibration, and fit refuses it: {why}."))
            }
        },
        Verdict::Missing => {
            let is_bound = |id: &String| {
                diagnosis.registry.parse(id).is_some_and(|named| named.family.is_bound_to_its_log())
            };
            let (bound, lasting): (Vec<String>, Vec<String>) = add.iter().cloned().partition(is_bound);
            let it = if add.len() == 1 { "it" } else { "them" };
            match &diagnosis.fit_refuses {
                None if !bound.is_empty() => say(out, &format!("Calibrate with {it} in the model:")),
                None => say(out, &format!("Add {it} to the calibration, and check that on a second log:")),
                Some(why) => say(
                    out,
                    &format!(
                        "This log itself carries no calibration, and fit refuses it: {why}. Record another, and add {it} there:"
                    ),
                ),
            }
            command(out, next::fit(arguments, &add));
            if bound.is_empty() {
                command(out, next::check(arguments));
            }
            if !lasting.is_empty() {
                let columns: Vec<String> =
                    found::columns(diagnosis).into_iter().filter(|column| column != "t_s").collect();
                let needs = if bound.is_empty() {
                    "The second log, and the device, need"
                } else {
                    "The device needs"
                };
                if !columns.is_empty() {
                    say(out, &format!("{needs} {} too.", listed(&columns)));
                }
            }
            if !bound.is_empty() {
                let (is, it) = if bound.len() == 1 { ("is", "it") } else { ("are", "they") };
                say(
                    out,
                    &format!(
                        "({} {is} bound to this log's own time: in the model {it} make{} offset and matrix right, but {it} cannot \
                         correct another log. Find and remove the cause, then record again{}.)",
                        listed(&bound),
                        if bound.len() == 1 { "s" } else { "" },
                        if lasting.is_empty() { "" } else { ", and check that log" }
                    ),
                );
            }
        }
        Verdict::Confounded => {
            say(out, "Record the log that separates them (above) and diagnose that:");
            command(out, next::diagnose(arguments, "second.csv", ""));
            say(
                out,
                "Adding one of them now would make this log fit and be wrong wherever the two part. If you know which it is, \
                 say so:",
            );
            for id in groups(diagnosis).first().into_iter().flatten() {
                let mut ids = add.clone();
                ids.push(id.clone());
                command(out, next::fit(arguments, &ids));
            }
        }
        Verdict::Unexplained => {
            if !add.is_empty() {
                say(
                    out,
                    match diagnosis.fit_refuses {
                        Some(_) => "The fit with what was found is refused all the same, and says why:",
                        None => "What was found helps all the same:",
                    },
                );
                let fit = match diagnosis.fit_refuses {
                    Some(_) => next::try_fit,
                    None => next::fit,
                };
                command(out, fit(arguments, &add));
            }
            goes_with(diagnosis, &add, out);
            if diagnosis.field_varies.is_some() {
                say(
                    out,
                    "A calibration needs one field: turn the board about one spot instead of carrying it, in the open, some metres \
                     from iron, walls, cables and magnets, and diagnose that log. Where it has to be carried, log where it was.",
                );
            }
            if is_only_unsure(diagnosis) {
                say(out, "Record longer, through more attitudes, and diagnose that log:");
                command(out, next::diagnose(arguments, "longer.csv", ""));
                return;
            }
            say(
                out,
                &format!(
                    "{} at where it fails (above) and log what changed there: temperature, currents, what moves. Any further numeric \
                     column of the log is tested.",
                    if add.is_empty() { "Look" } else { "For the rest, look" }
                ),
            );
        }
        Verdict::Undetermined
            if diagnosis.data_faults.iter().any(|fault| fault.kind == FaultKind::CopiedAxis) =>
        {
            say(out, "Repair the driver so that each axis is read from its own registers, and record again.");
        }
        Verdict::Undetermined if goes_with(diagnosis, &add, out) => {
            if arguments.prior.is_none() && diagnosis.reasons.iter().any(|reason| reason.contains("attitude"))
            {
                say(out, "An earlier good calibration can stand in for the attitudes that this log lacks:");
                command(out, next::diagnose(arguments, &path, "--prior earlier.json"));
            }
            say(out, "What the fit itself says:");
            command(out, next::try_fit(arguments, &add));
        }
        Verdict::Undetermined
            if diagnosis.reasons.iter().all(|reason| reason.starts_with("the residual is")) =>
        {
            say(
                out,
                "The readings scatter too much for a calibration, however the board is turned: look for loose wires, for \
                 magnets or iron that move near the sensor, for a sensor that is set too fast, and record again. What the \
                 fit itself says:",
            );
            command(out, next::try_fit(arguments, &add));
        }
        Verdict::Undetermined => {
            let turn = "Record again and turn the board through more directions: nose up and down, on both sides, upside down, \
                        each with a full turn.";
            if arguments.prior.is_some() {
                say(out, turn);
            } else {
                say(out, &format!("{turn} An earlier good calibration can stand in for them:"));
                command(out, next::diagnose(arguments, &path, "--prior earlier.json"));
            }
        }
    }
}
