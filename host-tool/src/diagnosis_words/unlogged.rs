//! Sections about causes without a column: an offset for each recording, an offset that switches.

use crate::diagnosis_words::diagnosed_log::{DiagnosedLog, WIDTH, title};
use crate::diagnosis_words::moment::at_moment;
use crate::diagnosis_words::numbers::{field, probability, significant, wrap};
use crate::field_unit::{fixed, signed, symbol, vector_with_errors};
use ironout_analysis::evidence::wander::Wander;
use ironout_analysis::unlogged::levels::Levels;
use ironout_analysis::unlogged::pair::{Disturbed, Pair, Part};
use ironout_analysis::unlogged::recordings::Recordings;
use ironout_analysis::unlogged::switching::Switching;

/// Lines of a table before the rest is counted.
const MOST: usize = 12;

/// Whether the section on switching or on jumps describes the cause, so that the one on the wander is left out.
fn has_times(diagnosed_log: &DiagnosedLog) -> bool {
    diagnosed_log.diagnosis.switching.is_some() || diagnosed_log.diagnosis.levels.is_some()
}

/// Both, where there are any.
pub(crate) fn sections(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    if let Some(found) = &diagnosed_log.diagnosis.recordings {
        title(out, "The offset differs between the recordings");
        out.extend(recordings(found, WIDTH));
    }
    if let Some(found) = diagnosed_log.diagnosis.wander.as_ref().filter(|_| !has_times(diagnosed_log)) {
        title(out, "Wandering offset without a column");
        out.extend(wander(found));
    }
    if let Some(found) = &diagnosed_log.diagnosis.switching {
        title(out, "Switching offset without a column");
        out.extend(switching(found));
    }
    if let Some(found) = &diagnosed_log.diagnosis.levels {
        title(out, "Offset with more jumps than a model has steps");
        out.extend(jumps(diagnosed_log, found));
    }
}

/// The jumps as a table.
fn jumps(diagnosed_log: &DiagnosedLog, found: &Levels) -> Vec<String> {
    let mut out = Vec::new();
    for ((at_s, change), errors) in found.at_s.iter().zip(&found.change_ut).zip(&found.std_errors_ut) {
        out.push(format!("  at {at_s:>8.2} s   change {}", vector_with_errors(*change, *errors)));
        out.extend(
            at_moment(diagnosed_log.log, *at_s).into_iter().map(|text| format!("                   {text}")),
        );
    }
    let text = format!(
        "An offset for each stretch between the jumps reduces the error from {} to {}. Something near the sensor moves, is \
         switched or is magnetised at these times. Look for what happens then, and log it as a column. Or cut the log there and \
         give the parts as several logs: one matrix, an offset for each.",
        field(found.before_rms_ut),
        field(found.rms_ut)
    );
    out.extend(wrap(&text, "  ", WIDTH));
    out
}

/// The jumps in one line.
pub(crate) fn jumps_in_short(found: &Levels) -> String {
    let times: Vec<String> = found.at_s.iter().map(|at| format!("{at:.1}")).collect();
    format!("offset changes {} times, at {} s", times.len(), times.join(", "))
}

/// What two magnetometers show together, in one line.
pub(crate) fn pair_in_short(found: &Pair) -> String {
    let size = |part: Part| fixed(Some(part.rms_ut), 2);
    let ([this, other], common) = (found.own.map(size), size(found.common));
    // One line of the answer has room for no more.
    let own = format!("own {this} and {other}");
    let unit = symbol();
    match (found.disturbed, found.common.significant) {
        (Some(Disturbed::This), _) => {
            format!("this one is disturbed, and the other is not: {own}, common {common} {unit} rms")
        }
        (Some(Disturbed::Other), _) => {
            format!("the other is disturbed, and this one is not: {own}, common {common} {unit} rms")
        }
        (None, true) => format!("disturbance of field or vehicle: common {common}, {own} {unit} rms"),
        (None, false) => format!("no disturbance of one or of both: {own}, common {common} {unit} rms"),
    }
}

/// A vector with its unit.
fn vector(values_ut: [f64; 3]) -> String {
    let [x, y, z] = values_ut.map(|axis_ut| signed(axis_ut, 2));
    format!("x {x}, y {y}, z {z} {}", symbol())
}

/// The offsets of recordings in one line.
pub(crate) fn recordings_in_short(found: &Recordings) -> String {
    format!(
        "one matrix, {} offsets; change per recording {}",
        found.recordings.len(),
        vector(found.per_recording_ut)
    )
}

/// A wandering offset in one line.
pub(crate) fn wander_in_short(found: &Wander) -> String {
    let direction = match found.direction {
        Some([x, y, z]) => format!("in the direction ({x:+.2}, {y:+.2}, {z:+.2})"),
        None => "in no fixed direction".into(),
    };
    format!(
        "{} {} rms {direction}, correlation time {} s",
        fixed(Some(found.rms_ut), 2),
        symbol(),
        significant(found.time_constant_s, 2)
    )
}

/// A wandering offset: how far and when it is farthest.
fn wander(found: &Wander) -> Vec<String> {
    let size = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let times = found.t_s.iter().zip(&found.offset_ut);
    let farthest = times.max_by(|a, b| size(a.1).total_cmp(&size(b.1)));
    let mut text = format!("It moves by {}.", wander_in_short(found));
    if let Some((at_s, offset_ut)) = farthest {
        text += &format!(" Its largest value is at {at_s:.1} s: {}.", vector(*offset_ut));
    }
    text += " The cause was not logged. To see this offset over time, plot the key wander of --json.";
    wrap(&text, "  ", WIDTH)
}

/// A switching offset in one line.
pub(crate) fn switching_in_short(found: &Switching) -> String {
    format!("two values, difference {}, {} intervals", vector(found.offset_ut), found.on_s.len())
}

/// The offsets of recordings as a table.
pub(crate) fn recordings(found: &Recordings, width: usize) -> Vec<String> {
    let mut out =
        vec!["  recording   samples   offset relative to that of all recordings together".to_string()];
    for one in found.recordings.iter().take(MOST) {
        let offset = vector_with_errors(one.offset_change_ut, one.std_errors_ut);
        out.push(format!("  {:>9}  {:>8}   {offset}", one.index + 1, one.samples));
    }
    if found.recordings.len() > MOST {
        out.push(format!("  and {} more; --json lists all", found.recordings.len() - MOST));
    }
    let per = match found.per_recording_errors_ut {
        Some(errors) => vector_with_errors(found.per_recording_ut, errors),
        None => vector(found.per_recording_ut),
    };
    let text = format!(
        "One matrix and an offset for each recording reduce the error from {} to {} (p-value {}). From one recording to the next \
         the offset changes by {per}. The rest of this answer uses the offset of the last recording.",
        field(found.common_rms_ut),
        field(found.rms_ut),
        probability(found.p_value),
    );
    out.extend(wrap(&text, "  ", width));
    out
}

fn switching(found: &Switching) -> Vec<String> {
    let size = found.offset_ut.iter().map(|value| value * value).sum::<f64>().sqrt();
    let mut out = vec![format!(
        "  B less A   {}   ({})",
        vector_with_errors(found.offset_ut, found.std_errors_ut),
        field(size)
    )];
    let spans: Vec<String> =
        found.on_s.iter().take(MOST).map(|[from, to]| format!("{from:.1} to {to:.1}")).collect();
    let more = found.on_s.len().saturating_sub(MOST);
    let rest = if more > 0 { format!(" and {more} times more") } else { String::new() };
    let times = format!(
        "The offset has two values, A and B. The log does not show which of them is the undisturbed one. B applies in {} \
         intervals ({:.0} % of the samples): {}{rest} s.",
        found.on_s.len(),
        100.0 * found.duty,
        spans.join(", ")
    );
    out.extend(wrap(&times, "  ", WIDTH));
    let text = format!(
        "A second offset reduces the error from {} to {}. Something near the sensor is switched on and off: an LED, a charger, a \
         relay, a transmitter. Log its state or its current as a column, or move it away. To calibrate with this log, cut it at these \
         times and give all parts to ironout fit: one matrix, an offset for each part.",
        field(found.before_rms_ut),
        field(found.rms_ut)
    );
    out.extend(wrap(&text, "  ", WIDTH));
    out
}
