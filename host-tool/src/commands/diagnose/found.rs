//! The effects that were found: cause, coefficients, and the error falling.

use crate::commands::diagnose::curve::{bar, limits, sparkline};
use crate::commands::diagnose::numbers::{
    degrees, microtesla, probability, readable_unit, significant, unit_of, with_error, wrap,
};
use crate::commands::diagnose::place::{self, axis_label};
use crate::commands::diagnose::told::{Told, WIDTH, at_rest, name_of, title};
use crate::input::Log;
use ironout_analysis::base::axes::mounting_for;
use ironout_analysis::calibration::FittedEffect;
use ironout_analysis::outcome::outcome::{Diagnosis, StepRow, Verdict};

/// Width of the longest bar.
const BAR: usize = 40;
/// Width of the words inside an entry.
const INDENT: &str = "     ";

/// The effects in the steps, with cause, coefficients and what they did to the error.
pub fn effects(told: &Told, out: &mut Vec<String>) {
    let diagnosis = told.diagnosis;
    // Where the log does not determine the model, it does not determine what explains it either.
    let nothing = diagnosis.effects.is_empty() && axis_order(diagnosis).is_none();
    if nothing || diagnosis.verdict == Verdict::Undetermined {
        return;
    }
    title(out, "What explains it");
    let mut number = 0;
    let mut before: Option<&StepRow> = None;
    for step in &diagnosis.steps {
        if let Some(id) = &step.added {
            number += 1;
            if number > 1 {
                out.push(String::new());
            }
            entry(told, number, id, before, step, out);
        }
        before = Some(step);
    }
    // In the model, but with others that explain the same: no step of their own.
    for effect in &diagnosis.effects {
        if diagnosis.steps.iter().any(|step| step.added.as_ref() == Some(&effect.id)) {
            continue;
        }
        number += 1;
        if number > 1 {
            out.push(String::new());
        }
        out.push(format!(
            "  {number}. {}   {}   (or another that explains the same, see below)",
            name_of(diagnosis, &effect.id),
            effect.id
        ));
        out.extend(wrap(&effect.explanation, INDENT, WIDTH));
        body(told, effect, out);
    }
}

fn entry(
    told: &Told,
    number: usize,
    id: &str,
    before: Option<&StepRow>,
    step: &StepRow,
    out: &mut Vec<String>,
) {
    let diagnosis = told.diagnosis;
    out.push(format!("  {number}. {}   {id}", name_of(diagnosis, id)));
    let row = diagnosis.candidates.iter().find(|row| row.id == id);
    match diagnosis.effects.iter().find(|effect| effect.id == id) {
        Some(effect) => {
            out.extend(wrap(&effect.explanation, INDENT, WIDTH));
            body(told, effect, out);
        }
        // An effect without coefficients, as swapped axes.
        None => out.extend(row.map_or(Vec::new(), |row| wrap(&row.why, INDENT, WIDTH))),
    }
    if let Some(before) = before.filter(|_| id != "axis-order") {
        let mut text =
            format!("{INDENT}error          {} → {} µT", microtesla(before.rms_ut), microtesla(step.rms_ut));
        if let (Some(a), Some(b)) = (before.holdout_rms_ut, step.holdout_rms_ut) {
            text.push_str(&format!("   on unseen time {} → {} µT", microtesla(a), microtesla(b)));
        }
        if let (Some(a), Some(b)) = (before.dip_rms_deg, step.dip_rms_deg) {
            text.push_str(&format!("   dip {} → {}", degrees(a), degrees(b)));
        }
        out.push(text);
    }
    if let Some(p) = row.and_then(|row| row.p_value) {
        out.push(format!(
            "{INDENT}chance         {}   that noise looks like this, everything tried counted in",
            probability(p)
        ));
    }
}

fn body(told: &Told, effect: &FittedEffect, out: &mut Vec<String>) {
    out.extend(coefficients(effect));
    let mut at: Vec<String> = effect
        .parameters
        .iter()
        .map(|(name, value)| match *name {
            "at_s" => format!("at {value:.2} s"),
            "frequency_hz" => format!("at {value:.3} Hz"),
            "delay_s" => format!("{value:.2} s late"),
            other => format!("{other} = {}", significant(*value, 4)),
        })
        .collect();
    if effect.id.starts_with("offset:") || effect.id.starts_with("gain:") || effect.id.starts_with("field:") {
        at.extend(effect.reference.iter().map(|(column, value)| {
            let square = if effect.id.contains('^') { "²" } else { "" };
            format!("zero at {column}{square} = {}", significant(*value, 4))
        }));
    }
    if !at.is_empty() {
        out.push(format!("{INDENT}{:<15}{}", "where", at.join(", ")));
    }
    if let Some(text) = amount(effect, told.log) {
        out.push(format!("{INDENT}{:<15}{text}", "amounts to"));
    }
    let column = effect.columns.first();
    let earlier = told.diagnosis.effects.iter().take_while(|other| other.id != effect.id);
    // Drawn once for each column: the curves are of all effects together.
    if earlier.into_iter().all(|other| other.columns.first() != column) {
        out.extend(before_and_after(told, effect));
    }
}

/// The coefficients with their errors, by axis where they belong to axes.
fn coefficients(effect: &FittedEffect) -> Vec<String> {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let values = &effect.coefficients;
    let family = effect.id.split(':').next().unwrap_or("");
    let error = |index: usize| effect.std_errors.get(index).copied().unwrap_or(f64::NAN);
    let size = |part: &[f64]| part.iter().fold(0.0_f64, |top, value| top.max(value.abs()));
    let row = |label: &str, names: &[&str], from: usize, unit: &str| {
        let part = &values[from.min(values.len())..(from + names.len()).min(values.len())];
        // Rows of one matrix share their unit; squares and cubes have their own.
        let largest = if ["lag", "cross-axis"].contains(&family) { size(values) } else { size(part) };
        let (factor, unit) = readable_unit(unit, largest);
        let cells: Vec<String> = names
            .iter()
            .zip(part)
            .enumerate()
            .map(|(i, (name, value))| {
                let separator = if name.is_empty() { "" } else { " " };
                format!("{name}{separator}{}", with_error(value * factor, error(from + i) * factor))
            })
            .collect();
        format!("{INDENT}{label:<15}{}  {unit}", cells.join("   "))
    };
    match (family, values.len()) {
        ("nonlinearity", 6) => {
            vec![row("squares", &AXES, 0, "1/µT"), row("cubes", &AXES, 3, "1/µT²")]
        }
        ("periodic", 6) => {
            let cells: Vec<String> = (0..3)
                .map(|i| {
                    let (s, c) = (values[i], values[3 + i]);
                    let size = s.hypot(c);
                    let error = ((s * error(i)).hypot(c * error(3 + i))) / size.max(1e-300);
                    format!("{} {}", AXES[i], with_error(size, error))
                })
                .collect();
            vec![format!("{INDENT}{:<15}{}  µT", "amplitude", cells.join("   "))]
        }
        ("lag", 9) => {
            let mut lines: Vec<String> =
                (0..3).map(|i| row(if i == 0 { "coupling" } else { "" }, &AXES, 3 * i, "s")).collect();
            let mean = (values[0] + values[4] + values[8]) / 3.0;
            let spread = (error(0).powi(2) + error(4).powi(2) + error(8).powi(2)).sqrt() / 3.0;
            lines.push(format!(
                "{INDENT}{:<15}{} ms, its part that is a pure delay",
                "delay",
                with_error(1e3 * mean, 1e3 * spread)
            ));
            lines
        }
        ("lag", 1) => vec![row("delay", &[""], 0, "s")],
        ("cross-axis", 7) => vec![
            row("on x", &["xy", "xz"], 0, "1/µT"),
            row("on y", &["xy", "yz"], 2, "1/µT"),
            row("on z", &["xz", "yz"], 4, "1/µT"),
            row("on x too", &["yz"], 6, "1/µT"),
        ],
        (_, 3) => vec![row("coefficients", &AXES, 0, &effect.unit)],
        (_, 1) => vec![row("coefficient", &[""], 0, &effect.unit)],
        _ => values
            .iter()
            .enumerate()
            .map(|(i, _)| row(if i == 0 { "coefficients" } else { "" }, &[""], i, &effect.unit))
            .collect(),
    }
}

/// Smallest and largest value of a column.
fn span(log: &Log, column: &str) -> Option<(f64, f64)> {
    let values = match column {
        "t_s" => log.time_s.as_deref()?,
        name => &log.covariate(name)?.values,
    };
    let (low, high) = values
        .iter()
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    (high > low).then_some((low, high))
}

/// What an additive effect does over the whole log, µT; or a gain, per cent.
fn amount(effect: &FittedEffect, log: &Log) -> Option<String> {
    let size = effect.coefficients.iter().map(|value| value * value).sum::<f64>().sqrt();
    let family = effect.id.split(':').next().unwrap_or("");
    let column = effect.columns.first();
    match family {
        "offset" | "gain" | "field" => {
            let column = column?;
            let (low, high) = span(log, column)?;
            let unit = unit_of(column);
            let range = format!("{column} from {} to {}{unit}", significant(low, 3), significant(high, 3));
            let reach = if effect.id.contains("^2") {
                let squares = (low * low, high * high);
                let least = if low < 0.0 && high > 0.0 { 0.0 } else { squares.0.min(squares.1) };
                squares.0.max(squares.1) - least
            } else {
                high - low
            };
            Some(match family {
                "offset" => format!("{} µT over this log ({range})", microtesla(size * reach)),
                _ => {
                    let largest = effect.coefficients.iter().fold(0.0_f64, |top, v| top.max(v.abs()));
                    format!("{} % over this log ({range})", significant(100.0 * largest * reach, 2))
                }
            })
        }
        "drift" => {
            let (low, high) = span(log, "t_s")?;
            Some(format!("{} µT over the {:.0} s of this log", microtesla(size * (high - low)), high - low))
        }
        "step" => Some(format!("{} µT", microtesla(size))),
        _ => None,
    }
}

/// The residual against what the effect reads, before and after.
fn before_and_after(told: &Told, effect: &FittedEffect) -> Vec<String> {
    let Some(column) = effect.columns.first() else { return Vec::new() };
    if effect.id == "periodic" {
        return Vec::new();
    }
    let Some((before, after)) = place::against_column(told, column) else { return Vec::new() };
    let (bottom, top) = limits([&before, &after].into_iter(), place::least_span(told.diagnosis));
    let (low, high) = axis_label(column, &before);
    let what = place::what(&before);
    let first =
        format!("{INDENT}{:<15}{low} {} {high}", "left before", sparkline(&before.values, bottom, top));
    let blank = " ".repeat(low.chars().count());
    let second = format!(
        "{INDENT}{:<15}{blank} {}   {what}, {} … {} µT",
        "     with all",
        sparkline(&after.values, bottom, top),
        microtesla(bottom),
        microtesla(top)
    );
    vec![first, second]
}

/// The falling error as bars: of the magnitude, and of the dip where that is what falls.
pub fn falling(told: &Told, out: &mut Vec<String>) {
    let diagnosis = told.diagnosis;
    let steps: Vec<&StepRow> =
        diagnosis.steps.iter().filter(|step| step.added.as_deref() != Some("axis-order")).collect();
    let (Some(first), Some(last)) = (steps.first(), steps.last()) else { return };
    if steps.len() < 2 || diagnosis.verdict == Verdict::Undetermined {
        return;
    }
    let label = |step: &StepRow| step.added.as_ref().map_or("base model".into(), |id| format!("+ {id}"));
    let width = steps.iter().map(|step| label(step).chars().count()).max().unwrap_or(0).max(12);
    let mut chart = |what: &str, rows: Vec<(String, f64)>, unit: fn(f64) -> String| {
        let largest = rows.iter().map(|(_, value)| *value).fold(1e-12, f64::max);
        title(out, &format!("The error falling ({what})"));
        for (label, value) in rows {
            out.push(format!("  {label:<width$} {:>11}  {}", unit(value), bar(value / largest, BAR)));
        }
    };
    let error = |step: &StepRow| step.holdout_rms_ut.unwrap_or(step.rms_ut);
    if error(first) > 1.02 * error(last) {
        let what = if at_rest(diagnosis) { "measured vector" } else { "corrected magnitude" };
        let mut rows: Vec<(String, f64)> = steps.iter().map(|step| (label(step), error(step))).collect();
        rows.extend(diagnosis.residual_floor_ut.map(|floor| ("noise alone".to_string(), floor)));
        chart(&format!("rms of the {what} on unseen time"), rows, |ut| format!("{} µT", microtesla(ut)));
    }
    if let (Some(before), Some(after)) = (first.dip_rms_deg, last.dip_rms_deg)
        && before > 1.2 * after
    {
        let rows = steps.iter().filter_map(|step| Some((label(step), step.dip_rms_deg?))).collect();
        chart("spread of the dip", rows, degrees);
    }
}

/// Where swapped axes were found: the list of body axes for `--rotate`.
pub fn axis_order(diagnosis: &Diagnosis) -> Option<String> {
    if diagnosis.verdict == Verdict::Undetermined {
        return None;
    }
    diagnosis.axis_order.as_deref().map(mounting_for)
}

/// Columns that the found effects read, and the gyro where one needs it.
pub fn columns(diagnosis: &Diagnosis) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for effect in &diagnosis.effects {
        let needs =
            effect.columns.iter().cloned().chain(
                (effect.id == "lag").then(|| "the gyroscope (gx_radps,gy_radps,gz_radps)".to_string()),
            );
        for column in needs {
            if !list.contains(&column) {
                list.push(column);
            }
        }
    }
    list
}

/// The dip and the heading, before and after.
pub fn alignment(told: &Told, out: &mut Vec<String>) {
    let diagnosis = told.diagnosis;
    let nothing = diagnosis.dip.is_none() && diagnosis.heading.is_none();
    if nothing || diagnosis.verdict == Verdict::Undetermined {
        return;
    }
    title(out, "Alignment with the accelerometer");
    if let Some(dip) = diagnosis.dip {
        out.push(format!(
            "  spread of the dip    {} → {}   base model alone, then aligned, with all that was found",
            degrees(dip.rms_deg_before),
            degrees(dip.rms_deg_after)
        ));
        let note = if dip.misalignment_deg > 1.0 {
            "the full matrix of the fit contains it"
        } else {
            "well aligned"
        };
        out.push(format!("  misalignment         {}   {note}", degrees(dip.misalignment_deg)));
    }
    if let Some(heading) = diagnosis.heading {
        out.push(format!(
            "  heading error        {} → {}   against heading_deg, rms",
            degrees(heading.rms_deg_before),
            degrees(heading.rms_deg_after)
        ));
    }
    if axis_order(diagnosis).is_some() {
        out.extend(wrap(
            "(The dip cannot tell a field from its opposite: judge the heading when the axes are in order.)",
            "  ",
            WIDTH,
        ));
    }
}
