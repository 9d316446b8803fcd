//! The effects that were found: cause, coefficients, and the error falling.

use crate::diagnosis_words::curve::{bar, limits, sparkline};
use crate::diagnosis_words::diagnosed_log::{DiagnosedLog, WIDTH, at_rest, name_of, title};
use crate::diagnosis_words::moment::at_moment;
use crate::diagnosis_words::numbers::{
    degrees, field, hang, microtesla, probability, readable_unit, significant, unit_of, with_error, wrap,
};
use crate::diagnosis_words::place::{self, axis_label};
use crate::input::Log;
use ironout::effect::{Amount, Follows, Group, Named, Need, Registry, TIME};
use ironout_analysis::base::axes::Alignment;
use ironout_analysis::base::mounting::{AXIS_ORDER, OrderStatus};
use ironout_analysis::calibration::FittedEffect;
use ironout_analysis::outcome::outcome::{Diagnosis, StepRow, Verdict};

/// Width of the longest bar.
const BAR: usize = 40;
/// Width of the words inside an entry.
const INDENT: &str = "     ";

/// The effects in the steps, with cause, coefficients and what they did to the error.
pub fn effects(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    let diagnosis = diagnosed_log.diagnosis;
    // Where the log does not determine the model, it does not determine what explains it either.
    let nothing = diagnosis.effects.is_empty() && axis_order(diagnosis).is_none();
    if nothing || diagnosis.verdict == Verdict::Undetermined {
        return;
    }
    title(out, "Effects found");
    let mut number = 0;
    let mut before: Option<&StepRow> = None;
    for step in &diagnosis.steps {
        if let Some(id) = &step.added {
            number += 1;
            if number > 1 {
                out.push(String::new());
            }
            entry(diagnosed_log, number, id, before, step, out);
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
            "  {number}. {}   {}   (or a confounded effect, see below)",
            name_of(diagnosis, &effect.id),
            effect.id
        ));
        out.extend(wrap(&effect.explanation, INDENT, WIDTH));
        body(diagnosed_log, effect, out);
    }
}

fn entry(
    diagnosed_log: &DiagnosedLog,
    number: usize,
    id: &str,
    before: Option<&StepRow>,
    step: &StepRow,
    out: &mut Vec<String>,
) {
    let diagnosis = diagnosed_log.diagnosis;
    out.push(format!("  {number}. {}   {id}", name_of(diagnosis, id)));
    let row = diagnosis.candidates.iter().find(|row| row.id == id);
    match diagnosis.effects.iter().find(|effect| effect.id == id) {
        Some(effect) => {
            out.extend(wrap(&effect.explanation, INDENT, WIDTH));
            body(diagnosed_log, effect, out);
        }
        // An effect without coefficients, as swapped axes.
        None => out.extend(row.map_or(Vec::new(), |row| wrap(&row.why, INDENT, WIDTH))),
    }
    if let Some(before) = before.filter(|_| id != AXIS_ORDER.id) {
        let mut text =
            format!("{INDENT}error          {} → {}", microtesla(before.rms_ut), field(step.rms_ut));
        if let (Some(a), Some(b)) = (before.holdout_rms_ut, step.holdout_rms_ut) {
            text.push_str(&format!("   held out {} → {}", microtesla(a), field(b)));
        }
        if let (Some(a), Some(b)) = (before.dip_rms_deg, step.dip_rms_deg) {
            text.push_str(&format!("   dip {} → {}", degrees(a), degrees(b)));
        }
        out.push(text);
    }
    if let Some(p) = row.and_then(|row| row.p_value) {
        out.push(format!("{INDENT}p-value        {}   corrected for all effects tested", probability(p)));
    }
}

fn body(diagnosed_log: &DiagnosedLog, effect: &FittedEffect, out: &mut Vec<String>) {
    out.extend(coefficients(diagnosed_log.diagnosis, effect));
    let mut at: Vec<String> = effect
        .parameters
        .iter()
        .map(|(name, value)| match *name {
            "at_s" => format!("at {value:.2} s"),
            "frequency_hz" => format!("at {value:.3} Hz"),
            "delay_s" if *value < 0.0 => {
                format!("{:.2} s before it is logged: the column is logged late", -value)
            }
            "delay_s" => format!("delayed by {value:.2} s"),
            "time_constant_s" => format!("low-pass filtered, time constant {} s", significant(*value, 3)),
            other => format!("{other} = {}", significant(*value, 4)),
        })
        .collect();
    let named = named(diagnosed_log.diagnosis, effect);
    if let Some(named) = named.filter(|named| named.form.column) {
        at.extend(effect.reference.iter().map(|(column, value)| {
            // The reference is a value of the column, whatever becomes of it.
            let sign = if named.form.is_squared() { "±" } else { "" };
            format!("zero at {column} = {sign}{}", significant(*value, 4))
        }));
    }
    if !at.is_empty() {
        let [first, rest] = ["parameters", ""].map(|label| format!("{INDENT}{label:<15}"));
        out.extend(hang(&at.join(", "), &first, &rest, WIDTH));
    }
    if let Some((_, at_s)) = effect.parameters.iter().find(|(name, _)| *name == "at_s") {
        let [first, rest] = ["then", ""].map(|label| format!("{INDENT}{label:<15}"));
        let words = at_moment(diagnosed_log.log, *at_s);
        out.extend(words.iter().flat_map(|text| hang(text, &first, &rest, WIDTH)));
    }
    if let Some(text) = amount(diagnosed_log.log, diagnosed_log.diagnosis.registry, effect) {
        out.push(format!("{INDENT}{:<15}{text}", "size"));
    }
    if let Some(text) = with_its_past(diagnosed_log, effect) {
        out.push(format!("{INDENT}{:<15}{text}", "together"));
    }
    let column = effect.columns.first();
    let earlier = diagnosed_log.diagnosis.effects.iter().take_while(|other| other.id != effect.id);
    // Drawn once for each column: the curves are of all effects together.
    if earlier.into_iter().all(|other| other.columns.first() != column) {
        out.extend(before_and_after(diagnosed_log, effect));
    }
}

/// What an effect and the same of its column's past come to where the column stands still: the two may undo each other. Said at the
/// second of them.
fn with_its_past(diagnosed_log: &DiagnosedLog, effect: &FittedEffect) -> Option<String> {
    let diagnosis = diagnosed_log.diagnosis;
    let own = named(diagnosis, effect)?;
    let is_other_half = |other: &&FittedEffect| {
        named(diagnosis, other).is_some_and(|other| {
            other.form.column
                && (other.family.kind(), other.column) == (own.family.kind(), own.column)
                && other.form.is_squared() == own.form.is_squared()
                && other.form.is_late() != own.form.is_late()
        })
    };
    let earlier = diagnosis.effects.iter().take_while(|other| other.id != effect.id);
    let other = earlier.into_iter().find(is_other_half)?;
    let both: Vec<f64> = effect.coefficients.iter().zip(&other.coefficients).map(|(a, b)| a + b).collect();
    let sum = FittedEffect { coefficients: both, ..effect.clone() };
    let text = amount(diagnosed_log.log, diagnosis.registry, &sum)?;
    let size = text.split(" over this log").next()?;
    Some(format!("{size} after {} has settled", own.column))
}

/// The id of an effect taken apart, with the form that its coefficients are of.
fn named<'a>(diagnosis: &Diagnosis, effect: &'a FittedEffect) -> Option<Named<'a>> {
    let named = diagnosis.registry.parse(&effect.id)?;
    Some(named.of_coefficients(effect.coefficients.len()))
}

/// The coefficients with their errors, in the groups of their effect; without any by axis where they belong to axes.
fn coefficients(diagnosis: &Diagnosis, effect: &FittedEffect) -> Vec<String> {
    const AXES: &[&str] = &["x", "y", "z"];
    let values = &effect.coefficients;
    let named = named(diagnosis, effect);
    let one_scale = named.is_some_and(|named| named.family.one_scale());
    let error = |index: usize| effect.std_errors.get(index).copied().unwrap_or(f64::NAN);
    let value = |index: usize| values.get(index).copied().unwrap_or(f64::NAN);
    let size = |part: &[f64]| part.iter().fold(0.0_f64, |top, value| top.max(value.abs()));
    let row = |label: &str, names: &[&str], from: usize, unit: &str| {
        let part = &values[from.min(values.len())..(from + names.len()).min(values.len())];
        // Rows of one matrix share their unit; squares and cubes have their own.
        let (factor, unit) = readable_unit(unit, size(if one_scale { values } else { part }));
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
    let groups = named.map_or(&[][..], |named| named.family.groups(named.form));
    if groups.is_empty() {
        return match values.len() {
            3 => vec![row("coefficients", AXES, 0, &effect.unit)],
            1 => vec![row("coefficient", &[""], 0, &effect.unit)],
            count => (0..count)
                .map(|i| row(if i == 0 { "coefficients" } else { "" }, &[""], i, &effect.unit))
                .collect(),
        };
    }
    let line = |group: &Group| match *group {
        Group::Row { label, names, from, unit } => row(label, names, from, unit),
        Group::Amplitude { label, sines, cosines, unit } => {
            let cells: Vec<String> = AXES
                .iter()
                .enumerate()
                .map(|(i, axis)| {
                    let (s, c) = (value(sines + i), value(cosines + i));
                    let size = s.hypot(c);
                    let error = ((s * error(sines + i)).hypot(c * error(cosines + i))) / size.max(1e-300);
                    format!("{axis} {}", with_error(size, error))
                })
                .collect();
            format!("{INDENT}{label:<15}{}  {unit}", cells.join("   "))
        }
        Group::Mean { label, of, factor, unit } => {
            let count = of.len().max(1) as f64;
            let mean = of.iter().map(|&i| value(i)).sum::<f64>() / count;
            let spread = of.iter().map(|&i| error(i).powi(2)).sum::<f64>().sqrt() / count;
            format!("{INDENT}{label:<15}{} {unit}", with_error(factor * mean, factor * spread))
        }
    };
    groups.iter().map(line).collect()
}

/// Smallest and largest value of a column.
fn span(log: &Log, column: &str) -> Option<(f64, f64)> {
    let values = match column {
        TIME => log.time_s.as_deref()?,
        name => &log.covariate(name)?.values,
    };
    let (low, high) = values
        .iter()
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    (high > low).then_some((low, high))
}

/// What an effect does over the whole log: an additive one in µT, a gain in per cent.
pub fn amount(log: &Log, registry: Registry, effect: &FittedEffect) -> Option<String> {
    let named = registry.parse(&effect.id)?;
    let size = effect.coefficients.iter().map(|value| value * value).sum::<f64>().sqrt();
    let over_column = || {
        let column = effect.columns.first()?;
        let (low, high) = span(log, column)?;
        let unit = unit_of(column);
        let range = format!("{column} from {} to {}{unit}", significant(low, 3), significant(high, 3));
        let reach = if named.form.is_squared() {
            let squares = (low * low, high * high);
            let least = if low < 0.0 && high > 0.0 { 0.0 } else { squares.0.min(squares.1) };
            squares.0.max(squares.1) - least
        } else {
            high - low
        };
        Some((reach, range))
    };
    match named.family.amount() {
        Amount::Untold => None,
        Amount::Field => {
            let (reach, range) = over_column()?;
            Some(format!("{} over this log ({range})", field(size * reach)))
        }
        Amount::Share => {
            let (reach, range) = over_column()?;
            let largest = effect.coefficients.iter().fold(0.0_f64, |top, v| top.max(v.abs()));
            Some(format!("{} % over this log ({range})", significant(100.0 * largest * reach, 2)))
        }
        Amount::OverTime => {
            let (low, high) = span(log, TIME)?;
            let seconds = high - low;
            Some(format!("{} over the {seconds:.0} s of this log", field(size * seconds)))
        }
        Amount::Itself => Some(field(size)),
    }
}

/// The residual against what the effect reads, before and after.
fn before_and_after(diagnosed_log: &DiagnosedLog, effect: &FittedEffect) -> Vec<String> {
    let Some(column) = effect.columns.first() else { return Vec::new() };
    if named(diagnosed_log.diagnosis, effect).is_some_and(|named| named.family.follows() == Follows::Tone) {
        return Vec::new();
    }
    let Some((before, after)) = place::against_column(diagnosed_log, column) else { return Vec::new() };
    let (bottom, top) = limits([&before, &after].into_iter(), place::least_span(diagnosed_log.diagnosis));
    let (low, high) = axis_label(column, &before);
    let what = place::what(&before);
    let first =
        format!("{INDENT}{:<16}{low} {} {high}", "residual before", sparkline(&before.values, bottom, top));
    let blank = " ".repeat(low.chars().count());
    let second = format!(
        "{INDENT}{:<16}{blank} {}   {what}, {} … {}",
        "residual after",
        sparkline(&after.values, bottom, top),
        microtesla(bottom),
        field(top)
    );
    vec![first, second]
}

/// The falling error as bars: of the magnitude, and of the dip where that is what falls.
pub fn falling(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    let diagnosis = diagnosed_log.diagnosis;
    let steps: Vec<&StepRow> =
        diagnosis.steps.iter().filter(|step| step.added.as_deref() != Some(AXIS_ORDER.id)).collect();
    let (Some(first), Some(last)) = (steps.first(), steps.last()) else { return };
    if steps.len() < 2 || diagnosis.verdict == Verdict::Undetermined {
        return;
    }
    let label = |step: &StepRow| step.added.as_ref().map_or("base model".into(), |id| format!("+ {id}"));
    let width = steps.iter().map(|step| label(step).chars().count()).max().unwrap_or(0).max(12);
    let mut chart = |what: &str, rows: Vec<(String, f64)>, unit: fn(f64) -> String| {
        let largest = rows.iter().map(|(_, value)| *value).fold(1e-12, f64::max);
        title(out, &format!("Error with each effect added ({what})"));
        for (label, value) in rows {
            out.push(format!("  {label:<width$} {:>11}  {}", unit(value), bar(value / largest, BAR)));
        }
    };
    let error = |step: &StepRow| step.holdout_rms_ut.unwrap_or(step.rms_ut);
    if error(first) > 1.02 * error(last) {
        let what = if at_rest(diagnosis) { "measured vector" } else { "corrected magnitude" };
        let mut rows: Vec<(String, f64)> = steps.iter().map(|step| (label(step), error(step))).collect();
        rows.extend(diagnosis.residual_floor_ut.map(|floor| ("noise floor".to_string(), floor)));
        chart(&format!("held-out rms of the {what}"), rows, field);
    }
    if let (Some(before), Some(after)) = (first.dip_rms_deg, last.dip_rms_deg)
        && before > 1.2 * after
    {
        // The dip is known at the ends alone, so that its fall is that of all effects.
        let between = steps.iter().any(|step| step.dip_rms_deg.is_none());
        let named = |step: &StepRow| match between && step.added.is_some() {
            true => "with all".into(),
            false => label(step),
        };
        let rows = steps.iter().filter_map(|step| Some((named(step), step.dip_rms_deg?))).collect();
        chart("dip spread, rms", rows, degrees);
    }
}

/// Where the axes do not stand for themselves: how they stand.
pub fn axis_order(diagnosis: &Diagnosis) -> Option<OrderStatus> {
    diagnosis
        .order_status
        .filter(|order_status| diagnosis.verdict != Verdict::Undetermined && order_status.swapped().is_some())
}

/// Columns that the found effects read, and the gyro where one needs it.
pub fn columns(diagnosis: &Diagnosis) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for effect in &diagnosis.effects {
        let turning =
            named(diagnosis, effect).is_some_and(|named| named.family.need(named.form) == Some(Need::Gyro));
        let gyro = turning.then(|| "the gyroscope (gx_radps,gy_radps,gz_radps)".to_string());
        let needs = effect.columns.iter().cloned().chain(gyro);
        for column in needs {
            if !list.contains(&column) {
                list.push(column);
            }
        }
    }
    list
}

/// The dip and the heading, before and after.
pub fn alignment(diagnosed_log: &DiagnosedLog, out: &mut Vec<String>) {
    let diagnosis = diagnosed_log.diagnosis;
    let nothing = diagnosis.dip.is_none() && diagnosis.heading.is_none();
    if nothing || diagnosis.verdict == Verdict::Undetermined {
        return;
    }
    title(out, "Alignment with the accelerometer");
    if let Some(dip) = diagnosis.dip {
        out.push(format!(
            "  dip spread           {} → {} rms   base model → aligned, with all effects found",
            degrees(dip.rms_deg_before),
            degrees(dip.rms_deg_after)
        ));
        let note = match diagnosis.alignment {
            Alignment::Done { .. } if dip.misalignment_deg > 1.0 => "corrected by the full matrix of the fit",
            Alignment::Done { .. } | Alignment::ByAll => "well aligned",
            Alignment::NoDip { .. } => "not corrected: the dip varies too much to determine it",
            Alignment::Open(_) | Alignment::Mirrored(_) => "not corrected until the axis order is corrected",
            Alignment::None => "not corrected: too uncertain",
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
    // Of axes that are out of order the entry above speaks.
    if let (None, Some(order_status)) = (axis_order(diagnosis), diagnosis.order_status) {
        for words in order_status.words() {
            out.extend(wrap(&format!("({words})"), "  ", WIDTH));
        }
    }
}
