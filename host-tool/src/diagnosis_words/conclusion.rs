//! The end of the explanation: the verdict in a sentence, and what to do about it.

use crate::cli::typed_option;
use crate::diagnosis_words::diagnosed_log::{DiagnosedLog, at_rest, groups, listed, name_of};
use crate::diagnosis_words::numbers::{degrees, field, microtesla};
use crate::diagnosis_words::{advice, found, next};
use crate::log_args::SAVED;
use ironout::extended::MAX_EFFECTS;
use ironout_analysis::Report;
use ironout_analysis::blocks::{Block, blocks};
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
        // Where structure is left next to the noise it is not only that.
        let all = diagnosis.verdict != Verdict::Unexplained || is_only_unsure(diagnosis);
        let noise = if all && at_the_noise(diagnosis) { ", the noise floor" } else { "" };
        return format!("the error from {} to {}{noise}", microtesla(first.rms_ut), field(last.rms_ut));
    }
    match (first.dip_rms_deg, last.dip_rms_deg) {
        (Some(before), Some(after)) if before > 1.02 * after => {
            format!("the dip spread from {} to {} rms", degrees(before), degrees(after))
        }
        _ => String::new(),
    }
}

/// The verdict in one sentence, or two.
pub fn sentence(diagnosis: &Diagnosis) -> String {
    let found: Vec<&str> = diagnosis.steps.iter().filter_map(|step| step.added.as_deref()).collect();
    let blocks = blocks(&found, diagnosis.registry);
    let names: Vec<String> = found.iter().filter_map(|id| with_block(diagnosis, &blocks, id)).collect();
    let it = if found.len() == 1 { "it" } else { "them" };
    let fall = fall(diagnosis);
    let reasons = diagnosis.reasons.join(". ");
    match diagnosis.verdict {
        Verdict::Complete if at_rest(diagnosis) => {
            "COMPLETE: the reading of the sensor at rest is constant except for noise. No column changes it.".to_string()
        }
        Verdict::Complete => {
            "COMPLETE: offset and matrix explain this log down to the sensor noise. Nothing significant is missing."
                .to_string()
        }
        Verdict::Missing => {
            let with =
                if fall.is_empty() { String::new() } else { format!(" Modelling {it} reduces {fall}.") };
            let axes = match found::axis_order(diagnosis) {
                Some(order_status) if order_status.by_gyro => {
                    " The field rotates as the gyro measures only after the axis order is corrected."
                }
                Some(_) => " Field and gravity agree only after the axis order is corrected.",
                None => "",
            };
            format!("FOUND: {}.{with}{axes}", listed(&names))
        }
        Verdict::Confounded => {
            let each: Vec<String> = groups(diagnosis)
                .iter()
                .map(|group| {
                    let names: Vec<String> = group.iter().map(|id| with_id(diagnosis, id)).collect();
                    format!("{} explain the error equally well", listed(&names))
                })
                .collect();
            let known =
                if names.is_empty() { String::new() } else { format!(" Also found: {}.", listed(&names)) };
            format!("CONFOUNDED: {}. This log cannot show which of them is the cause.{known}", each.join("; "))
        }
        Verdict::Unexplained => {
            let besides = match (names.is_empty(), fall.is_empty()) {
                (true, _) => String::new(),
                (false, true) => format!(" Found, but not sufficient: {}.", listed(&names)),
                (false, false) if is_only_unsure(diagnosis) => format!(
                    " Found: {}. Modelling {it} reduces {fall}. No other effect is significant in this log. Record a longer log to \
                     confirm.",
                    listed(&names)
                ),
                (false, false) => format!(
                    " Found: {}. Modelling {it} reduces {fall}, but error remains. Another quantity, not logged, that changes \
                     together with {it} may be the cause.",
                    listed(&names)
                ),
            };
            format!("UNEXPLAINED: {}.{besides}", reasons_or(&reasons, "error remains that no effect explains"))
        }
        Verdict::Undetermined => {
            format!("UNDETERMINED: {}.", reasons_or(&reasons, "this log does not determine a calibration"))
        }
    }
}

/// The same where like-named columns have an effect each: all of them at the first, nothing at the others.
fn with_block(diagnosis: &Diagnosis, blocks: &[Block], id: &str) -> Option<String> {
    let Some(block) = blocks.iter().find(|block| block.ids.iter().any(|own| own == id)) else {
        return Some(with_id(diagnosis, id));
    };
    let effect = diagnosis.effects.iter().find(|effect| effect.id == id);
    let name = effect.map_or("effect of a column", |effect| effect.name.as_str());
    let ids = block.ids.first().filter(|first| *first == id).map(|_| block.ids.join(", "))?;
    Some(format!("{name}, with its own coefficients for each of {} ({ids})", listed(&block.columns)))
}

/// Name and id, as in `offset drift (drift)`.
fn with_id(diagnosis: &Diagnosis, id: &str) -> String {
    let name = name_of(diagnosis, id);
    if name == id { name } else { format!("{name} ({id})") }
}

fn reasons_or<'a>(reasons: &'a str, otherwise: &'a str) -> &'a str {
    if reasons.is_empty() { otherwise } else { reasons }
}

/// Of confounded effects, this many get a command of their own.
const MOST_CHOICES: usize = 3;

/// What the error is held against that is not a column of the log.
const NO_COLUMNS: [&str; 4] = ["time", "spectrum", "attitude", "rate of turn"];
/// A column is mentioned as the likely cause from this share of the residual variance on, and up to [`MAX_P_VALUE`].
const MIN_VARIANCE_EXPLAINED: f64 = 0.5;
const MAX_P_VALUE: f64 = 1e-6;

/// The column that most of the error goes with, where none of its effects is in the model. Says whether there is one.
fn goes_with(diagnosis: &Diagnosis, add: &[String], report: &mut Report) -> bool {
    let is_column = |name: &str| !NO_COLUMNS.contains(&name);
    let named = |column: &str| add.iter().any(|id| id.contains(&format!(":{column}")));
    let mut columns = diagnosis.shows.iter().filter(|shown| is_column(&shown.against));
    let most = columns.find(|shown| shown.explained > MIN_VARIANCE_EXPLAINED && shown.p_value < MAX_P_VALUE);
    let Some(shown) = most.filter(|shown| !named(&shown.against)) else { return false };
    let why = match diagnosis.verdict {
        Verdict::Undetermined => "but no effect is named without offset and matrix",
        _ => "but not significantly enough to name an effect",
    };
    report.say(format!(
        "{:.0} % of the residual variance depends on {}, {why}. Record a log in which it rises and falls in many orientations, and \
         diagnose that log.",
        100.0 * shown.explained,
        shown.against
    ));
    true
}

/// The verdict, and why an effect that was asked for is not needed.
pub fn verdict(diagnosed_log: &DiagnosedLog) -> Vec<String> {
    let asked = diagnosed_log.arguments.add.iter().filter_map(|id| {
        let row = diagnosed_log.diagnosis.candidates.iter().find(|row| row.id == *id);
        row.filter(|row| row.status == Status::NotNeeded).map(|row| format!("{id} was {}.", row.why))
    });
    std::iter::once(sentence(diagnosed_log.diagnosis)).chain(asked).collect()
}

/// Effects that a calibration has no place for.
fn say_left_out(left_out: &[String], report: &mut Report) {
    if !left_out.is_empty() {
        report.say(format!(
            "A calibration stores at most {MAX_EFFECTS} effects, so this command leaves out {}.",
            listed(left_out)
        ));
    }
}

/// The commands, or the recording, that come next.
pub fn what_next(diagnosed_log: &DiagnosedLog, report: &mut Report) {
    let DiagnosedLog { log, arguments, diagnosis } = diagnosed_log;
    let piped = log.path == Path::new("-");
    let path = if piped { SAVED.to_string() } else { log.path.display().to_string() };
    let (add, left_out) = diagnosis.to_add(&arguments.add);
    if piped {
        report.say(format!("The log came from standard input. Save it as {SAVED} first."));
    }
    if let Some(order_status) = found::axis_order(diagnosis) {
        if order_status.is_open() {
            report.say("This log cannot show whether the axes are rotated or mirrored. Give the place of the recording, or log heading_deg. If you know which it is, use:",
            );
            report.command(next::diagnose(arguments, &path, "--at LAT,LON,YYYY-MM-DD"));
        } else {
            report.say("Correct the axis order (in the driver, or with this option) and diagnose again:");
        }
        for (rotate, _) in order_status.readings() {
            report.command(next::diagnose(arguments, &path, typed_option("--rotate", &rotate).trim()));
        }
        return;
    }
    if at_rest(diagnosis) && diagnosis.verdict != Verdict::Undetermined {
        report.say("A sensor at rest shows disturbances, but it cannot be calibrated. Record a log in which the same things change while you rotate the sensor through all directions, and diagnose that log.",
        );
        return;
    }
    if diagnosis.calibration.is_none() && diagnosis.verdict != Verdict::Undetermined {
        report.say("The effect is clear, but this log cannot provide offset and matrix. Use an earlier calibration, or record a log in which the same things change while you rotate the sensor through all directions:",
        );
        report.command(format!("{} --prior earlier.json", next::diagnose(arguments, &path, "")));
        return;
    }
    match diagnosis.verdict {
        Verdict::Complete => match &diagnosis.fit_refuses {
            None => {
                report.say("Calibrate with this log:");
                report.command(next::fit(arguments, &add));
                report.command(next::check(arguments));
            }
            Some(why) => report
                .say(format!("This log is not sufficient for a calibration, and fit refuses it: {why}.")),
        },
        Verdict::Missing => {
            let is_bound = |id: &String| {
                diagnosis.registry.parse(id).is_some_and(|named| named.family.is_bound_to_its_log())
            };
            let (bound, lasting): (Vec<String>, Vec<String>) = add.iter().cloned().partition(is_bound);
            let it = if add.len() == 1 { "it" } else { "them" };
            match &diagnosis.fit_refuses {
                None if !bound.is_empty() => report.say(format!("Calibrate with {it} in the model:")),
                None => report.say(format!("Add {it} to the calibration, then check it on a second log:")),
                Some(why) => report.say(format!(
                        "This log is not sufficient for a calibration, and fit refuses it: {why}. Record another log, and add {it} there:"
                    ),
                ),
            }
            report.command(next::fit(arguments, &add));
            say_left_out(&left_out, report);
            if bound.is_empty() {
                report.command(next::check(arguments));
            }
            if !lasting.is_empty() {
                let columns: Vec<String> =
                    found::columns(diagnosis).into_iter().filter(|column| column != "t_s").collect();
                let needs =
                    if bound.is_empty() { "The second log and the device need" } else { "The device needs" };
                if !columns.is_empty() {
                    report.say(format!("{needs} {} too.", listed(&columns)));
                }
            }
            if !bound.is_empty() {
                let (is, it) = if bound.len() == 1 { ("is", "it") } else { ("are", "they") };
                report.say(format!(
                        "({} {is} tied to the time of this log. In the model {it} make{} offset and matrix correct, but {it} cannot correct another log. Remove the cause, then record again{}.)",
                        listed(&bound),
                        if bound.len() == 1 { "s" } else { "" },
                        if lasting.is_empty() { "" } else { ", and check that log" }
                    ),
                );
            }
        }
        Verdict::Confounded => {
            for group in groups(diagnosis).iter().filter(|group| group.len() > 1).take(1) {
                let advice = advice::separating(diagnosis.registry, &group[0], &group[1]);
                report.say(format!("Record a log that separates {} and {}: {advice}", group[0], group[1]));
            }
            report.say("Then diagnose that log:");
            report.command(next::diagnose(arguments, "second.csv", ""));
            report.say("If you know which of them is the cause, add it. The wrong one fits this log, but fails as soon as the two change separately:",
            );
            for id in groups(diagnosis).first().into_iter().flatten().take(MOST_CHOICES) {
                let mut ids = add.clone();
                ids.push(id.clone());
                report.command(next::fit(arguments, &ids));
            }
        }
        Verdict::Unexplained => {
            match &diagnosis.fit_refuses {
                _ if add.is_empty() => {}
                Some(why) => {
                    report.say(format!("ironout fit refuses a calibration with these effects: {why}."))
                }
                None => {
                    report.say("These effects reduce the error anyway:");
                    report.command(next::fit(arguments, &add));
                    say_left_out(&left_out, report);
                }
            }
            goes_with(diagnosis, &add, report);
            if diagnosis.field_varies.is_some() {
                report.say("A calibration needs a uniform field. Rotate the sensor in one spot, outdoors and some metres away from iron, walls, cables and magnets, and diagnose that log. If you have to carry it, log its position.",
                );
            }
            if is_only_unsure(diagnosis) {
                report.say("Record longer, in more orientations, and diagnose that log:");
                report.command(next::diagnose(arguments, "longer.csv", ""));
                return;
            }
            report.say(format!(
                    "{} Log what changes near the sensor: temperature, currents, moving parts. ironout tests every numeric column.",
                    if add.is_empty() {
                        "See where the residual is large (-v)."
                    } else {
                        "For the rest, see where the residual is large (-v)."
                    }
                ),
            );
        }
        Verdict::Undetermined
            if diagnosis.data_faults.iter().any(|fault| fault.kind == FaultKind::CopiedAxis) =>
        {
            report.say(
                "Correct the driver so that it reads each axis from its own registers, and record again.",
            );
        }
        Verdict::Undetermined if goes_with(diagnosis, &add, report) => {
            if arguments.prior.is_none() && !diagnosis.has_attitude {
                report.say("An earlier good calibration can replace the missing orientations:");
                report.command(next::diagnose(arguments, &path, "--prior earlier.json"));
            }
            report.say("The fit prints more about it:");
            report.command(next::try_fit(arguments, &add));
        }
        Verdict::Undetermined
            if diagnosis.reasons.iter().all(|reason| reason.code == "residual-too-large") =>
        {
            report.say("The readings scatter too much for a calibration. Look for loose wires, moving magnets or iron, and a sensor rate that is too high. Then record again. The fit prints more about it:",
            );
            report.command(next::try_fit(arguments, &add));
        }
        Verdict::Undetermined => {
            let turn = "Record again in more orientations: nose up and down, on both sides, upside down, each with a full turn.";
            if arguments.prior.is_some() {
                report.say(turn);
            } else {
                report.say(format!("{turn} An earlier good calibration can replace them:"));
                report.command(next::diagnose(arguments, &path, "--prior earlier.json"));
            }
        }
    }
}
