//! The diagnosis as an explanation.

use super::outcome::{Diagnosis, Status, Verdict};
use crate::output::{line, number};
use std::path::Path;

const BLOCKS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// A line of blocks from the least to the greatest value; a blank where there is none.
pub fn sparkline(values: &[f64]) -> String {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let low = finite.clone().fold(f64::INFINITY, f64::min);
    let high = finite.fold(f64::NEG_INFINITY, f64::max);
    values
        .iter()
        .map(|value| {
            if !value.is_finite() {
                return ' ';
            }
            let share = if high > low { (value - low) / (high - low) } else { 0.0 };
            BLOCKS[((share * 7.99) as usize).min(7)]
        })
        .collect()
}

/// A bar in proportion to `value`.
pub fn bar(value: f64, full: f64, width: usize) -> String {
    let cells =
        if full > 0.0 && value.is_finite() { (value / full * width as f64).round() as usize } else { 0 };
    "█".repeat(cells.clamp(1, width))
}

fn verdict_words(diagnosis: &Diagnosis) -> String {
    let names: Vec<&str> = diagnosis
        .candidates
        .iter()
        .filter(|row| row.status == Status::Missing && row.id != "misalignment")
        .map(|row| row.name.as_str())
        .collect();
    match diagnosis.verdict {
        Verdict::Complete => {
            "complete: the model explains the log down to the noise; nothing is missing".into()
        }
        Verdict::Missing => {
            format!("missing: {}; with it the log is explained down to the noise", names.join(", "))
        }
        Verdict::Confounded => "confounded: something is missing, and several causes explain it alike".into(),
        Verdict::Unexplained => "unexplained: structure remains that no candidate explains".into(),
        Verdict::Undetermined => "undetermined: the data do not support a calibration".into(),
    }
}

/// Prints the whole story.
pub fn print(diagnosis: &Diagnosis, log: &Path) {
    for text in lines(diagnosis, log) {
        line(&text);
    }
}

/// The lines of the story.
pub fn lines(diagnosis: &Diagnosis, log: &Path) -> Vec<String> {
    let mut out = Vec::new();
    out.push(format!("Verdict: {}", verdict_words(diagnosis)));
    out.extend(diagnosis.reasons.iter().map(|reason| format!("  {reason}")));
    out.push(String::new());
    data(diagnosis, &mut out);
    fails(diagnosis, &mut out);
    falling(diagnosis, &mut out);
    causes(diagnosis, log, &mut out);
    others(diagnosis, &mut out);
    out
}

fn data(diagnosis: &Diagnosis, out: &mut Vec<String>) {
    out.push(format!(
        "Data: {} samples, {} rows set aside. Noise of the sensor {} µT per axis; it makes {} µT of the {}.",
        diagnosis.samples_used,
        diagnosis.samples_set_aside,
        number(diagnosis.noise_floor_ut, 3),
        number(diagnosis.residual_floor_ut, 3),
        if diagnosis.residual == "vector" { "vector" } else { "corrected magnitude" },
    ));
    if !diagnosis.prior.is_empty() {
        out.push(format!("Prior: {}.", diagnosis.prior));
    }
    for fault in &diagnosis.data_faults {
        let when = match (fault.from_s, fault.to_s) {
            (Some(from), Some(to)) => format!(" from {from:.2} s to {to:.2} s"),
            _ => String::new(),
        };
        let columns = if fault.columns.is_empty() {
            String::new()
        } else {
            format!(" in {}", fault.columns.join(", "))
        };
        out.push(format!("Data fault: {}{when}, {} samples{columns}.", fault.kind.name(), fault.samples));
    }
    out.push(String::new());
}

fn fails(diagnosis: &Diagnosis, out: &mut Vec<String>) {
    let shown: Vec<_> =
        diagnosis.shows.iter().filter(|one| one.p_value < 0.02 && one.explained > 0.01).take(6).collect();
    if shown.is_empty() {
        return;
    }
    out.push("Where the base model fails (share of the squared residual that it explains):".into());
    for one in shown {
        out.push(format!(
            "  {:<14} {:>5.1} %  p {:<8.1e} {}",
            one.against,
            100.0 * one.explained,
            one.p_value,
            sparkline(&one.shape)
        ));
    }
    out.push(String::new());
}

fn falling(diagnosis: &Diagnosis, out: &mut Vec<String>) {
    let Some(first) = diagnosis.steps.first() else { return };
    let full = first.holdout_rms_ut.unwrap_or(first.rms_ut).max(first.rms_ut);
    out.push("The error, on blocks of time that the fit has not seen:".into());
    for step in &diagnosis.steps {
        let value = step.holdout_rms_ut.unwrap_or(step.rms_ut);
        let name = step.added.as_deref().map_or("base model".to_string(), |id| format!("+ {id}"));
        let dip = step.dip_rms_deg.map_or(String::new(), |dip| format!("  dip {dip:.2}°"));
        out.push(format!("  {name:<26} {value:>8.3} µT  {}{dip}", bar(value, full, 40)));
    }
    if let Some(floor) = diagnosis.residual_floor_ut {
        out.push(format!("  {:<26} {floor:>8.3} µT  {}", "noise floor", bar(floor, full, 40)));
    }
    if let Some(dip) = diagnosis.dip {
        out.push(format!(
            "Dip against the accelerometer: {:.2}° with the triangular matrix, {:.2}° aligned (rotation {:.1}°).",
            dip.rms_deg_before, dip.rms_deg_after, dip.misalignment_deg
        ));
    }
    if let Some(heading) = diagnosis.heading {
        out.push(format!(
            "Heading against the reference: {:.2}° rms before, {:.2}° after.",
            heading.rms_deg_before, heading.rms_deg_after
        ));
    }
    out.push(String::new());
}

fn causes(diagnosis: &Diagnosis, log: &Path, out: &mut Vec<String>) {
    for effect in &diagnosis.effects {
        let confounded =
            diagnosis.candidates.iter().any(|row| row.id == effect.id && row.status == Status::Confounded);
        if confounded {
            continue;
        }
        out.push(format!("Cause: {} ({})", effect.name, effect.id));
        out.push(format!("  {}", effect.explanation));
        let values: Vec<String> = effect
            .coefficients
            .iter()
            .zip(&effect.std_errors)
            .map(|(value, error)| format!("{} ± {}", digits(*value), digits(*error)))
            .collect();
        out.push(format!("  {}  [{}]", values.join(", "), effect.unit));
        for (column, value) in &effect.reference {
            out.push(format!("  zero at {column} = {}", digits(*value)));
        }
        for (name, value) in &effect.parameters {
            out.push(format!("  {name} = {}", digits(*value)));
        }
        out.push(String::new());
    }
    let adds: Vec<String> = diagnosis
        .steps
        .iter()
        .filter_map(|step| step.added.as_deref())
        .filter(|id| *id != "axis-order")
        .map(|id| format!("--add '{id}'"))
        .collect();
    if !adds.is_empty() && diagnosis.residual == "magnitude" {
        out.push(format!("To add it: ironout fit {} {} -o cal.json", log.display(), adds.join(" ")));
        out.push(String::new());
    }
}

fn digits(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        "-".into()
    } else if size != 0.0 && !(1e-3..1e5).contains(&size) {
        format!("{value:.3e}")
    } else if size >= 100.0 {
        format!("{value:.1}")
    } else {
        format!("{value:.4}")
    }
}

fn others(diagnosis: &Diagnosis, out: &mut Vec<String>) {
    for row in diagnosis.candidates.iter().filter(|row| row.status == Status::Confounded) {
        out.push(format!("Confounded: {} ({}): {}", row.id, row.name, row.why));
    }
    for row in
        diagnosis.candidates.iter().filter(|row| row.status == Status::Missing && row.residual == "dip")
    {
        out.push(format!("From the dip: {}: {}", row.id, row.why));
    }
    let not_needed: Vec<&str> = diagnosis
        .candidates
        .iter()
        .filter(|row| row.status == Status::NotNeeded)
        .map(|row| row.id.as_str())
        .collect();
    if !not_needed.is_empty() {
        out.push(format!("Tested, and not needed: {}.", not_needed.join(", ")));
    }
    for row in diagnosis.candidates.iter().filter(|row| row.status == Status::Untestable) {
        out.push(format!("Could not be tested: {}: {}.", row.id, row.why));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sparklines_span_their_range_and_leave_gaps_blank() {
        assert_eq!(sparkline(&[0.0, 1.0, f64::NAN, 0.5]), "▁█ ▄");
        assert_eq!(sparkline(&[2.0, 2.0]), "▁▁");
    }

    #[test]
    fn bars_are_in_proportion_and_never_empty() {
        assert_eq!(bar(1.0, 4.0, 8), "██");
        assert_eq!(bar(0.0, 4.0, 8), "█");
        assert_eq!(bar(f64::NAN, 4.0, 8), "█");
    }
}
