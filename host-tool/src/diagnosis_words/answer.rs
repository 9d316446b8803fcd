//! The answer of a diagnosis: verdict, the figures that matter, and what to do next.

use crate::diagnosis_words::conclusion::{verdict, what_next};
use crate::diagnosis_words::diagnosed_log::{DiagnosedLog, WIDTH, at_rest, counted};
use crate::diagnosis_words::found::{amount, axis_order};
use crate::diagnosis_words::numbers::{degrees, microtesla, percent, probability};
use crate::diagnosis_words::place;
use crate::diagnosis_words::unlogged;
use crate::field_unit::symbol;
use crate::report_text::{Layout, lines};
use ironout_analysis::Report;
use ironout_analysis::outcome::outcome::{StepRow, Verdict};
use ironout_analysis::samples::faults::FaultKind;

/// Found effects that get a line of their own.
const EFFECTS: usize = 4;
/// Columns of the residual that are named if nothing explains it.
const COLUMNS: usize = 3;

/// The answer.
pub fn report(diagnosed_log: &DiagnosedLog) -> Report {
    let mut report = Report { verdict: verdict(diagnosed_log), ..Report::default() };
    figures(diagnosed_log, &mut report);
    what_next(diagnosed_log, &mut report);
    report
}

/// The answer, line by line.
pub fn answer(diagnosed_log: &DiagnosedLog) -> Vec<String> {
    lines(&report(diagnosed_log), Layout { width: WIDTH, label: 14 })
}

fn figures(diagnosed_log: &DiagnosedLog, report: &mut Report) {
    let diagnosis = diagnosed_log.diagnosis;
    let seconds = diagnosed_log.log.time_s.as_ref().and_then(|t| Some(t.last()? - t.first()?));
    let over = seconds.map_or(" (no time column)".to_string(), |s| format!(" over {s:.1} s"));
    let mut row = |label: &str, text: String| report.figure(label, text);
    row(
        "log",
        format!(
            "{}: {}{over}, {} used",
            diagnosed_log.log.path.display(),
            counted(diagnosed_log.log.rows, "row"),
            counted(diagnosis.samples_used, "sample")
        ),
    );
    let steps: Vec<&StepRow> = diagnosis.steps.iter().collect();
    let determined = diagnosis.verdict != Verdict::Undetermined;
    if let (Some(first), Some(last)) = (steps.first(), steps.last()) {
        let fall = |before: f64, after: f64, text: fn(f64) -> String| match steps.len() {
            1 => text(before),
            _ => format!("{} → {}", text(before), text(after)),
        };
        let held_out = match (first.holdout_rms_ut, last.holdout_rms_ut) {
            (Some(before), Some(after)) => format!("; held out {}", fall(before, after, microtesla)),
            _ => String::new(),
        };
        let of = if at_rest(diagnosis) { " of the vector" } else { "" };
        row(
            "error",
            format!("{} {} rms{of}{held_out}", fall(first.rms_ut, last.rms_ut, microtesla), symbol()),
        );
    }
    if let Some(found) = &diagnosis.recordings {
        row("recordings", unlogged::recordings_in_short(found));
    }
    if let Some(found) = &diagnosis.switching {
        row("switching", unlogged::switching_in_short(found));
    }
    if let Some(found) = &diagnosis.levels {
        row("jumps", unlogged::jumps_in_short(found));
    }
    if let Some(found) =
        diagnosis.wander.as_ref().filter(|_| diagnosis.switching.is_none() && diagnosis.levels.is_none())
    {
        row("wander", unlogged::wander_in_short(found));
    }
    if let Some(found) = &diagnosis.pair {
        row("other sensor", unlogged::pair_in_short(found));
    }
    if let Some(floor) = diagnosis.residual_floor_ut {
        row("noise floor", format!("{} {}", microtesla(floor), symbol()));
    }
    if let Some(heading) = diagnosis.heading.filter(|_| determined) {
        let (before, after) = (degrees(heading.rms_deg_before), degrees(heading.rms_deg_after));
        row("heading error", format!("{before} → {after} rms, against heading_deg"));
    } else if let Some(dip) = diagnosis.dip.filter(|_| determined && axis_order(diagnosis).is_none()) {
        // The same two figures as in the verdict, which is about the effects; without effects only the alignment changes the dip.
        let (before, how) = match steps.first().and_then(|first| first.dip_rms_deg) {
            Some(before) if steps.len() > 1 => (before, ""),
            _ => (dip.rms_deg_before, ", aligned with the accelerometer"),
        };
        row("dip spread", format!("{} → {} rms{how}", degrees(before), degrees(dip.rms_deg_after)));
    }
    if determined {
        let mut count = 0;
        for effect in &diagnosis.effects {
            count += 1;
            if count > EFFECTS {
                continue;
            }
            let size = amount(diagnosed_log.log, diagnosis.registry, effect)
                .map_or(String::new(), |text| format!(": {text}"));
            row("effect", format!("{}{size}", effect.id));
        }
        if count > EFFECTS {
            let more = count - EFFECTS;
            row("", format!("and {more} more effect{}", if more == 1 { "" } else { "s" }));
        }
    }
    if matches!(diagnosis.verdict, Verdict::Unexplained | Verdict::Undetermined) {
        let most: Vec<String> = diagnosis
            .shows
            .iter()
            .filter(|shown| shown.p_value < 0.01)
            .take(COLUMNS)
            .map(|shown| {
                format!(
                    "{} {} (p = {})",
                    place::label(&shown.against),
                    percent(shown.explained),
                    probability(shown.p_value)
                )
            })
            .collect();
        if !most.is_empty() {
            row("residual by", most.join(", "));
        }
    }
    let mut kinds: Vec<(FaultKind, usize)> = Vec::new();
    for fault in &diagnosis.data_faults {
        match kinds.iter_mut().find(|(kind, _)| *kind == fault.kind) {
            Some((_, count)) => *count += 1,
            None => kinds.push((fault.kind, 1)),
        }
    }
    if !kinds.is_empty() {
        let list: Vec<String> =
            kinds.iter().map(|(kind, count)| format!("{count} × {}", kind.name())).collect();
        row("data faults", list.join(", "));
    }
}
