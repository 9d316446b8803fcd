//! What no column shows: an offset for each recording, an offset that switches.

use crate::diagnosis_words::numbers::{microtesla, probability, wrap};
use crate::diagnosis_words::told::{Told, WIDTH, title};
use ironout_analysis::unlogged::recordings::Recordings;
use ironout_analysis::unlogged::switching::Switching;

/// Lines of a table before the rest is counted.
const MOST: usize = 12;

/// Both, where there are any.
pub(crate) fn sections(told: &Told, out: &mut Vec<String>) {
    if let Some(found) = &told.diagnosis.recordings {
        title(out, "The offset differs between the recordings");
        out.extend(recordings(found, WIDTH));
    }
    if let Some(found) = &told.diagnosis.switching {
        title(out, "An offset switches between two values, and no column says when");
        out.extend(switching(found));
    }
}

/// The offsets of recordings in one line.
pub(crate) fn recordings_in_short(found: &Recordings) -> String {
    let [x, y, z] = found.per_recording_ut.map(|value| format!("{value:+.2}"));
    format!(
        "one matrix, {} offsets; the offset changes by x {x}, y {y}, z {z} µT per recording",
        found.recordings.len()
    )
}

/// A switching offset in one line.
pub(crate) fn switching_in_short(found: &Switching) -> String {
    let [x, y, z] = found.offset_ut.map(|value| format!("{value:+.2}"));
    format!(
        "offset x {x}, y {y}, z {z} µT, on {} times, {:.0} % of samples; no column says when",
        found.on_s.len(),
        100.0 * found.duty
    )
}

fn triple(values: [f64; 3]) -> String {
    values.map(|value| format!("{value:+9.2}")).concat()
}

/// The offsets of recordings as a table.
pub(crate) fn recordings(found: &Recordings, width: usize) -> Vec<String> {
    let mut out = vec![format!(
        "  recording   samples        x        y        z   µT, less the offset of all together"
    )];
    for one in found.recordings.iter().take(MOST) {
        let errors = one.std_errors_ut.map(|error| format!("{error:.2}")).join(" ");
        out.push(format!(
            "  {:>9}  {:>8}{}   ± {errors}",
            one.index + 1,
            one.samples,
            triple(one.offset_change_ut)
        ));
    }
    if found.recordings.len() > MOST {
        out.push(format!("  and {} more; --json lists all", found.recordings.len() - MOST));
    }
    let per = found.per_recording_ut.map(|value| format!("{value:+.2}")).join(", ");
    let errors = found.per_recording_errors_ut.map_or(String::new(), |errors| {
        format!(" ± {}", errors.map(|error| format!("{error:.2}")).join(", "))
    });
    let text = format!(
        "One matrix and an offset for each recording: the error falls from {} to {} µT (chance {}). From one recording to the next the \
         offset changes by {per}{errors} µT. All that follows is of the readings with the offset of the last recording.",
        microtesla(found.common_rms_ut),
        microtesla(found.rms_ut),
        probability(found.p_value),
    );
    out.extend(wrap(&text, "  ", width));
    out
}

fn switching(found: &Switching) -> Vec<String> {
    let [x, y, z] = found.offset_ut.map(|value| format!("{value:+.2}"));
    let [ex, ey, ez] = found.std_errors_ut.map(|error| format!("{error:.2}"));
    let size = found.offset_ut.iter().map(|value| value * value).sum::<f64>().sqrt();
    let mut out = vec![format!(
        "  on less off    x {x} ±{ex}   y {y} ±{ey}   z {z} ±{ez}  µT   ({} µT)",
        microtesla(size)
    )];
    let spans: Vec<String> =
        found.on_s.iter().take(MOST).map(|[from, to]| format!("{from:.1} to {to:.1}")).collect();
    let more = found.on_s.len().saturating_sub(MOST);
    let rest = if more > 0 { format!(" and {more} times more") } else { String::new() };
    let times = format!(
        "on {} times, {:.0} % of the samples: {}{rest} s",
        found.on_s.len(),
        100.0 * found.duty,
        spans.join(", ")
    );
    out.extend(wrap(&times, "  ", WIDTH));
    let text = format!(
        "It takes the error from {} to {} µT. Something near the sensor is switched on and off: an LED, a charger, a relay, a transmitter. Log \
         its state or its current as a column, or move it away.",
        microtesla(found.before_rms_ut),
        microtesla(found.rms_ut)
    );
    out.extend(wrap(&text, "  ", WIDTH));
    out
}
