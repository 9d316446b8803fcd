//! What `diagnose` says to people: the answer first, then the details from the noise floor to the tested effects.

use crate::diagnosis_words::diagnosed_log::{DiagnosedLog, WIDTH, at_rest, counted, groups, name_of, title};
use crate::diagnosis_words::numbers::{field, hang, microtesla, probability, wrap};
use crate::diagnosis_words::{advice, answer, found, place, unlogged};
use crate::field_unit::symbol;
use ironout::effect::{Named, Registry, Searched};
use ironout_analysis::base::mounting;
use ironout_analysis::noise::own::Colour;
use ironout_analysis::outcome::outcome::{CandidateRow, Status, Verdict};
use ironout_analysis::samples::faults::{DataFault, FaultKind};

/// The answer alone: verdict, figures and next steps, at most a screen.
pub fn brief(diagnosed_log: &DiagnosedLog) -> String {
    let mut out = answer::answer(diagnosed_log);
    out.push(String::new());
    out.push("Residual by column, coefficients and all tested effects: repeat the command with -v.".into());
    joined(&out)
}

/// The answer, then every detail.
pub fn text(diagnosed_log: &DiagnosedLog) -> String {
    let mut out = answer::answer(diagnosed_log);
    out.push(String::new());
    heading(diagnosed_log, &mut out);
    faults(diagnosed_log, &mut out);
    base(diagnosed_log, &mut out);
    unlogged::sections(diagnosed_log, &mut out);
    place::failures(diagnosed_log, &mut out);
    found::effects(diagnosed_log, &mut out);
    found::falling(diagnosed_log, &mut out);
    found::alignment(diagnosed_log, &mut out);
    tested(diagnosed_log, &mut out);
    untestable(diagnosed_log, &mut out);
    confounded(diagnosed_log, &mut out);
    joined(&out)
}

fn joined(lines: &[String]) -> String {
    lines.iter().map(|line| format!("{line}\n")).collect()
}

fn heading(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    let DiagnosedLog { log, diagnosis, .. } = diagnosed_log;
    let seconds = log.time_s.as_ref().and_then(|t| Some(t.last()? - t.first()?));
    let over = seconds.map_or(" without a time column".to_string(), |s| format!(" over {s:.1} s"));
    out.push(format!("{}: {}{over}", log.path.display(), counted(log.rows, "row")));
    let mut parts = vec![format!("{} studied", counted(diagnosis.samples_used, "sample"))];
    if diagnosis.samples_set_aside > 0 {
        parts.push(format!("{} set aside as faulty", diagnosis.samples_set_aside));
    }
    out.push(parts.join(", "));
}

fn explain_fault(kind: FaultKind) -> &'static str {
    match kind {
        FaultKind::Clipping => {
            "the sensor reached the end of its range. Choose a larger range, or move it away from the magnet"
        }
        FaultKind::Burst => "a magnet or iron passed close by, or single readings failed",
        FaultKind::Stuck => "the sensor repeated one reading while it was rotated. It or its bus hung",
        FaultKind::Gap => "rows or cells are missing here. ironout skips these samples",
        FaultKind::CopiedRows => {
            "the log contains the same readings twice: a recording was joined to itself or named twice"
        }
        FaultKind::CopiedAxis => "one axis is a copy of another: the driver reads one register twice",
    }
}

fn fault_line(fault: &DataFault) -> String {
    let when = match (fault.from_s, fault.to_s) {
        (Some(from), Some(to)) => format!("{from:.1} to {to:.1} s"),
        _ => String::new(),
    };
    let count = match fault.kind {
        FaultKind::Gap => format!("about {} missing", counted(fault.samples, "sample")),
        _ => counted(fault.samples, "sample"),
    };
    let columns = fault.columns.join(",");
    format!("  {:<12} {when:<18} {count:<26} {columns}", fault.kind.name()).trim_end().to_string()
}

fn faults(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    let mut list: Vec<&DataFault> = diagnosed_log.diagnosis.data_faults.iter().collect();
    if list.is_empty() {
        return;
    }
    title(out, "Faults of the data");
    // Gaps take no sample away: where not all is listed, what does comes first.
    list.sort_by_key(|fault| fault.kind == FaultKind::Gap);
    const MOST: usize = 12;
    let mut kinds: Vec<FaultKind> = Vec::new();
    for fault in list.iter().take(MOST) {
        out.push(fault_line(fault));
    }
    if list.len() > MOST {
        out.push(format!("  and {} more", list.len() - MOST));
    }
    for fault in &list {
        if !kinds.contains(&fault.kind) {
            kinds.push(fault.kind);
            out.extend(wrap(&format!("{}: {}.", fault.kind.name(), explain_fault(fault.kind)), "  ", WIDTH));
        }
    }
}

fn base(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    let diagnosis = diagnosed_log.diagnosis;
    if diagnosis.steps.is_empty() {
        return;
    }
    title(out, "The sensor and the base model");
    let field = diagnosis.calibration.map(|calibration| calibration.field_ut);
    let share = |ut: f64| match field {
        Some(field) if field > 0.0 => format!("{:5.2} % of the field: ", 100.0 * ut / field),
        _ => String::new(),
    };
    let mut row = |label: &str, value: Option<f64>, note: String| {
        let number = value.map_or("-".into(), microtesla);
        out.push(format!("  {label:<16} {number:>8} {}   {note}", symbol()).trim_end().to_string());
    };
    row("sensor noise", diagnosis.noise_floor_ut, "per axis (1σ), estimated from the residual".into());
    if !at_rest(diagnosis) {
        let note = diagnosis
            .residual_floor_ut
            .map_or(String::new(), |floor| format!("{}expected if only sensor noise remains", share(floor)));
        row("noise floor", diagnosis.residual_floor_ut, note);
    }
    let what = if at_rest(diagnosis) {
        "measured vector about its mean (the sensor was at rest)".to_string()
    } else {
        format!(
            "{}error of the base model",
            diagnosis.steps.first().map_or(String::new(), |s| share(s.rms_ut))
        )
    };
    if let Some(step) = diagnosis.steps.first() {
        row("base model", Some(step.rms_ut), what);
        if let Some(floor) = diagnosis.residual_floor_ut
            && floor > 0.0
        {
            let ratio = step.rms_ut / floor;
            let text = if diagnosis.verdict == Verdict::Undetermined {
                "The log does not determine this model, so its error is not meaningful.".to_string()
            } else if ratio > 1.1 {
                format!(
                    "The error of the base model is {ratio:.1} × the noise floor, so the model lacks a cause of error."
                )
            } else if ratio > 1.03 {
                format!(
                    "The error of the base model is {:.0} % above the noise floor.",
                    100.0 * (ratio - 1.0)
                )
            } else {
                "The error of the base model equals the noise floor.".to_string()
            };
            out.push(format!("  {text}"));
        }
    }
    if !at_rest(diagnosis) && !diagnosis.steps.is_empty() {
        let base = if diagnosis.lower_order {
            "Too few orientations for a full calibration."
        } else {
            "The base model is hard iron (offset), soft iron and gains (matrix)."
        };
        let prior =
            if diagnosis.prior.is_empty() { String::new() } else { format!(" Prior: {}.", diagnosis.prior) };
        out.extend(wrap(&format!("{base}{prior}"), "  ", WIDTH));
    }
    if let Some(noise) = diagnosis.noise.filter(|noise| noise.is_noise && noise.colour != Colour::White) {
        let text = format!(
            "The noise is {}. {1:.1} samples determine as much as one sample of white noise, so standard errors are multiplied by {2:.1}.",
            noise.colour.words(),
            noise.memory_samples,
            noise.memory_samples.sqrt()
        );
        out.extend(wrap(&text, "  ", WIDTH));
    }
}

fn tested(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    let diagnosis = diagnosed_log.diagnosis;
    let (small, rest): (Vec<&CandidateRow>, Vec<&CandidateRow>) = diagnosis
        .candidates
        .iter()
        .filter(|row| row.status == Status::NotNeeded && !mounting::is_one(&row.id))
        .partition(|row| row.why.contains("too small"));
    if (small.is_empty() && rest.is_empty()) || diagnosis.verdict == Verdict::Undetermined {
        return;
    }
    title(out, "Tested and not significant");
    let (uncertain, rest): (Vec<&CandidateRow>, Vec<&CandidateRow>) =
        rest.into_iter().partition(|row| row.why.starts_with(EXPLAINS));
    if !rest.is_empty() {
        let ids: Vec<&str> = rest.iter().map(|row| row.id.as_str()).collect();
        for (family, members) in families(diagnosis.registry, &ids) {
            out.extend(hang(&members.join(", "), &format!("  {family:<10}"), "            ", WIDTH));
        }
    }
    if !small.is_empty() {
        let ids: Vec<String> = small
            .iter()
            .map(|row| format!("{} (p = {})", row.id, row.p_value.map_or("-".into(), probability)))
            .collect();
        out.extend(wrap(&format!("significant, but too small to matter: {}", ids.join(", ")), "  ", WIDTH));
    }
    for (why, members) in alike(&uncertain) {
        out.extend(hang(
            &format!("Each explains a part of the remaining variance, {why}: {members}."),
            "  ",
            "    ",
            WIDTH,
        ));
    }
}

/// How the reason of a candidate begins that explains something, but not enough.
const EXPLAINS: &str = "it explains ";

/// Candidates by what their reasons have in common, each with its share of the variance: one line instead of many.
fn alike<'a>(rows: &[&'a CandidateRow]) -> Vec<(&'a str, String)> {
    let mut list: Vec<(&str, String)> = Vec::new();
    for row in rows {
        let said = row.why.trim_start_matches(EXPLAINS).split_once(" of the remaining variance, ");
        let (share, why) = said.unwrap_or(("", &row.why));
        let member = if share.is_empty() { row.id.clone() } else { format!("{} {share}", row.id) };
        match list.iter_mut().find(|(known, _)| *known == why) {
            Some((_, members)) => *members += &format!(", {member}"),
            None => list.push((why, member)),
        }
    }
    list
}

/// Ids by what they have in common: `offset:a`, `offset:b` as `offset` over `a, b`; those without a column last.
fn families<'a>(registry: Registry, ids: &[&'a str]) -> Vec<(&'static str, Vec<&'a str>)> {
    let named: Vec<Named> = ids.iter().filter_map(|id| registry.parse(id)).collect();
    let mut list: Vec<(&'static str, Vec<&str>)> = Vec::new();
    for family in registry.families() {
        for form in family.forms().iter().filter(|form| form.column) {
            let label = match (form.is_squared(), form.searched) {
                (false, None) => family.kind(),
                (true, None) => "  squared",
                (false, Some(Searched::TimeConstant)) => "  slow",
                (false, _) => "  late",
                (true, _) => "  both",
            };
            let members = named.iter().filter(|one| one.family.kind() == family.kind() && one.form == *form);
            list.push((label, members.map(|one| one.column).collect()));
        }
    }
    let apart = |id: &&&str| registry.parse(id).is_none_or(|named| !named.form.column);
    list.push(("others", ids.iter().filter(apart).copied().collect()));
    list.retain(|(_, members)| !members.is_empty());
    list
}

fn untestable(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    let diagnosis = diagnosed_log.diagnosis;
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    for row in diagnosis.candidates.iter().filter(|row| row.status == Status::Untestable) {
        if row.why.starts_with("not tested") {
            continue;
        }
        let name = format!("{} ({})", row.name, row.id);
        match groups.iter_mut().find(|(why, _)| *why == row.why) {
            Some((_, names)) => names.push(name),
            None => groups.push((&row.why, vec![name])),
        }
    }
    if groups.is_empty() {
        return;
    }
    title(out, "Not testable with this log");
    for (why, names) in groups {
        let how = advice::how_to_log(why).map_or(String::new(), |how| format!(" ({how})"));
        out.extend(hang(&format!("{}: {why}{how}", names.join(", ")), "  - ", "    ", WIDTH));
    }
}

fn confounded(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    for group in groups(diagnosed_log.diagnosis) {
        title(out, "Confounded in this log");
        for id in &group {
            let row = diagnosed_log.diagnosis.candidates.iter().find(|row| row.id == *id);
            let held = row
                .and_then(|row| row.holdout_rms_ut)
                .map_or(String::new(), |ut| format!(": held-out error {} with it alone", field(ut)));
            let text = format!("{} ({id}){held}", name_of(diagnosed_log.diagnosis, id));
            out.extend(hang(&text, "  - ", "    ", WIDTH));
        }
        let first = &group[0];
        out.extend(wrap(
            "Each explains the error by itself. With one of them in the model the other is not significant.",
            "  ",
            WIDTH,
        ));
        out.push("  To separate them:".into());
        for other in &group[1..] {
            let text = format!(
                "{first} or {other}: {}",
                advice::separating(diagnosed_log.diagnosis.registry, first, other)
            );
            out.extend(hang(&text, "  - ", "    ", WIDTH));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_listed_by_family_and_none_is_lost() {
        let ids = [
            "offset:temp_c",
            "gain:temp_c",
            "drift",
            "offset:i_a^2",
            "offset:i_a@delay",
            "offset:i_a",
            "lag",
        ];
        let list = families(Registry::BUILT_IN, &ids);
        let expected = [
            ("offset", vec!["temp_c", "i_a"]),
            ("  squared", vec!["i_a"]),
            ("  late", vec!["i_a"]),
            ("gain", vec!["temp_c"]),
            ("others", vec!["drift", "lag"]),
        ];
        assert_eq!(list, expected);
        assert_eq!(list.iter().map(|(_, members)| members.len()).sum::<usize>(), ids.len());
    }
}
