//! A log under a model, as JSON.

use crate::cal_file::{CalFile, FitObject};
use crate::cli::{DiagnoseArgs, FitArgs};
use crate::diagnosis_words::{self, DiagnosedLog, amount};
use crate::failure::{Failure, Outcome};
use crate::fit_words;
use crate::input::Log;
use crate::output::json_number;
use crate::page::asked::LookAsked;
use crate::page::held::Held;
use crate::reading::Reading;
use crate::refusal;
use crate::registry::REGISTRY;
use ironout::effect::Group;
use ironout::fit::Method;
use ironout_analysis::base::axes::Alignment;
use ironout_analysis::base::mounting;
use ironout_analysis::calibration::FittedEffect;
use ironout_analysis::outcome::json;
use ironout_analysis::outcome::outcome::Verdict;
use ironout_analysis::{Diagnosis, Fitted, Look, Options, Refusal, Table};
use serde_json::{Value, json};

const AXES: [&str; 3] = ["x", "y", "z"];
/// An error within so many times what noise leaves needs no explanation.
const EXPLAINED: f64 = 1.2;

/// Fits a log with what is asked, searches if asked, and gives all that a page shows of it.
///
/// # Errors
/// An effect that this log does not allow.
pub fn look(held: &Held, asked: &LookAsked) -> Outcome<Value> {
    let log = &held.log;
    let expected = asked.expected()?;
    let options = Options {
        method: Method::Adjusted,
        field_ut: expected.field_ut,
        dip_deg: expected.earth.map(|earth| earth.dip_deg),
        add: asked.add.clone(),
        force_effect: true,
        search: asked.search,
        prior: None,
        registry: REGISTRY,
        ..Options::default()
    };
    let (look, add) =
        with_found(log, &options, asked.floor_ut).map_err(|refusal| refusal::failure(refusal, &log.path))?;
    let asked = &LookAsked { add, ..asked.clone() };
    let arguments = FitArgs {
        free: None,
        purpose: None,
        headings: Vec::new(),
        prior_from: None,
        log: held.asked.arguments(),
        field: asked.field(),
        output: Some("cal.json".into()),
        add: asked.add.clone(),
        force_effect: !asked.add.is_empty(),
        prior: None,
    };
    let words = fit_words::text(&arguments, log, &look.fitted, &expected);
    let cal = match look.fitted.accepted {
        true => Some(cal_text(held, &look.fitted)?),
        false => None,
    };
    let diagnosis = look.diagnosis.as_ref().map(|diagnosis| diagnosed(held, asked, diagnosis));
    let effects = look.fitted.solution.iter().flat_map(|solution| &solution.effects);
    Ok(json!({
        "asked": asked,
        "fit": FitObject::of(&look.fitted, options.method.name()),
        "figures": figures(&look.fitted, look.floor_ut),
        "verdict": verdict(&look, asked),
        "words": words,
        "cal": cal,
        "effects": effects.map(|effect| explained(held, effect)).collect::<Vec<_>>(),
        "alignment": alignment(&look.fitted),
        "diagnosis": diagnosis,
        "faults": look.faults.iter().map(|fault| json!({
            "kind": fault.kind.name(), "from_s": json_number(fault.from_s), "to_s": json_number(fault.to_s),
            "samples": fault.samples, "columns": fault.columns,
        })).collect::<Vec<_>>(),
        "picture": look.picture,
    }))
}

/// A look with what its search found switched on, and which effects that are; with what was asked for, if that is something.
fn with_found(log: &Log, options: &Options, floor_ut: Option<f64>) -> Result<(Look, Vec<String>), Refusal> {
    let table = Table::from(log);
    let look = ironout_analysis::look(&table, options, floor_ut)?;
    if !options.add.is_empty() {
        return Ok((look, options.add.clone()));
    }
    // A log that does not determine the model does not determine what explains its error either.
    let determined = look.diagnosis.iter().filter(|diagnosis| diagnosis.verdict != Verdict::Undetermined);
    let steps = determined.flat_map(|diagnosis| &diagnosis.steps);
    // The alignment, which every fit has, puts axes in order.
    let found: Vec<String> =
        steps.filter_map(|step| step.added.clone()).filter(|id| !mounting::is_one(id)).collect();
    if found.is_empty() {
        return Ok((look, found));
    }
    let with = Options { add: found.clone(), search: false, ..options.clone() };
    match ironout_analysis::look(&table, &with, look.floor_ut) {
        Ok(second) if second.fitted.solution.is_some() => {
            Ok((Look { diagnosis: look.diagnosis, ..second }, found))
        }
        _ => Ok((look, Vec::new())),
    }
}

/// The verdict on top of a page: of the search if there was one, else of the fit; and whether there is a calibration to take.
fn verdict(look: &Look, asked: &LookAsked) -> Value {
    let fitted = &look.fitted;
    let fit = sentence(fitted, look.floor_ut);
    let whole = look.diagnosis.as_ref().map_or(fit.clone(), diagnosis_words::sentence);
    let (name, sentence) = whole.split_once(": ").unwrap_or(("", &whole));
    let with = if asked.add.is_empty() { String::new() } else { format!(" with {}", asked.add.join(", ")) };
    let calibration = match (&fitted.solution, fitted.accepted) {
        (Some(solution), true) => {
            let error = solution.vector_error_ut();
            format!(
                "A calibration{with} is ready to export. The predicted error of a corrected vector is {error:.3} µT ({:.2} % of the field).",
                100.0 * error / solution.calibration.field_ut
            )
        }
        _ => format!("There is no calibration{with} to export: {}.", refused(fitted).trim_end_matches('.')),
    };
    json!({"name": name, "sentence": sentence, "calibration": calibration, "accepted": fitted.accepted})
}

/// The first reason of a refusal.
fn refused(fitted: &Fitted) -> &str {
    let why = fitted.reasons.iter().find(|reason| !reason.starts_with("note:"));
    why.map_or("this log is not enough for one", |why| why.words.as_str())
}

/// A log under a calibration that there is already: what is drawn, and its error.
///
/// # Errors
/// A file that is not a calibration, or a column that it needs and the log has not.
pub fn under(held: &Held, cal_text: &str, name: &str) -> Outcome<Value> {
    let cal = CalFile::parse(cal_text).map_err(|failure| failure.in_file(name.as_ref()))?;
    if let Some(reading) = &cal.reading {
        reading.must_fit(name.as_ref(), &held.log, &held.asked.arguments())?;
    }
    let extended = cal.extended().map_err(|failure| failure.in_file(name.as_ref()))?;
    let field_ut = extended.base.field_ut;
    let table = Table::from(&held.log);
    let (picture, rms_ut) = ironout_analysis::look_with(&table, extended)
        .map_err(|error| Failure::usage(error.why).in_file(&held.log.path).at_column(error.column))?;
    Ok(json!({
        "name": name, "fit": cal.fit, "picture": picture, "rms_ut": json_number(Some(rms_ut)),
        "percent": json_number(Some(100.0 * rms_ut / field_ut)),
    }))
}

/// CAL.json of an accepted fit, as `fit -o` writes it.
fn cal_text(held: &Held, fitted: &Fitted) -> Outcome<String> {
    let mut cal = CalFile::of(fitted, Method::Adjusted.name());
    cal.reading = Some(Reading::of(&held.log, &held.asked.arguments(), &cal.read_columns())?);
    let text = serde_json::to_string_pretty(&cal).map_err(|error| Failure::usage(error.to_string()))?;
    Ok(text + "\n")
}

fn figures(fitted: &Fitted, floor_ut: Option<f64>) -> Value {
    let solution = fitted.solution.as_ref();
    let field_ut = solution.map(|solution| solution.calibration.field_ut);
    let percent = |value: Option<f64>| json_number(value.zip(field_ut).map(|(v, field)| 100.0 * v / field));
    let before = fitted.before;
    json!({
        "before_ut": json_number(before.map(|(_, rms)| rms)),
        "before_percent": json_number(before.map(|(mean, rms)| 100.0 * rms / mean)),
        "after_ut": json_number(solution.map(|solution| solution.rms_ut)),
        "after_percent": percent(solution.map(|solution| solution.rms_ut)),
        "after_heading_deg": json_number(fitted.heading_error_deg),
        "without_effects_ut": json_number(solution.and_then(|s| s.without_effects.as_ref()).map(|base| base.rms_ut)),
        "predicted_ut": json_number(solution.map(|solution| solution.vector_error_ut())),
        "floor_ut": json_number(floor_ut),
        "floor_percent": percent(floor_ut),
        "dip_deg": json_number(fitted.dip_deg),
        "rows": fitted.rows, "repeated": fitted.repeated, "at_rest": fitted.at_rest,
    })
}

/// The verdict of a fit in one sentence.
fn sentence(fitted: &Fitted, floor_ut: Option<f64>) -> String {
    let Some(solution) = fitted.solution.as_ref().filter(|_| fitted.accepted) else {
        return format!("REFUSED: {}", refused(fitted));
    };
    let both = |rms: f64| format!("{rms:.3} µT ({:.2} %)", 100.0 * rms / solution.calibration.field_ut);
    let after = both(solution.rms_ut);
    let falls = match fitted.before {
        Some((mean, rms)) => format!(
            "the calibration reduces the error from {rms:.3} µT ({:.2} % of the field) to {after}",
            100.0 * rms / mean
        ),
        None => format!("the error of the corrected magnitude is {after}"),
    };
    let least = fitted.residual_floor_least_ut.filter(|least| *least > 0.0);
    let rest = match floor_ut.filter(|floor| *floor > 0.0) {
        Some(floor)
            if solution.rms_ut <= EXPLAINED * floor
                && solution.rms_ut > EXPLAINED * least.unwrap_or(floor) =>
        {
            let most = solution.rms_ut / least.unwrap_or(floor);
            format!(
                ". The error is {most:.1} times the noise from sample to sample: either the noise is correlated, or something moves \
                 slowly. Only a search with more columns can tell which"
            )
        }
        Some(floor) if solution.rms_ut <= EXPLAINED * floor => ", the noise floor of this log".to_string(),
        Some(floor) => format!(", {:.1} times the noise floor", solution.rms_ut / floor),
        None => String::new(),
    };
    format!("ACCEPTED: {falls}{rest}.")
}

fn alignment(fitted: &Fitted) -> Value {
    match fitted.solution.as_ref().map(|solution| &solution.alignment) {
        Some(Alignment::Done { angle_deg, before_deg, after_deg, .. }) => {
            json!({"angle_deg": angle_deg, "dip_before_deg": before_deg, "dip_after_deg": after_deg})
        }
        _ => Value::Null,
    }
}

/// An effect with its cause and its size.
fn explained(held: &Held, effect: &FittedEffect) -> Value {
    json!({
        "id": effect.id, "name": effect.name, "explanation": effect.explanation, "columns": effect.columns,
        "coefficients": effect.coefficients.iter().map(|v| json_number(Some(*v))).collect::<Vec<_>>(),
        "std_errors": effect.std_errors.iter().map(|v| json_number(Some(*v))).collect::<Vec<_>>(),
        "unit": effect.unit, "names": coefficient_names(effect),
        "reference": effect.reference.iter().map(|(n, v)| json!([n, json_number(Some(*v))])).collect::<Vec<_>>(),
        "parameters": effect.parameters.iter().map(|(n, v)| json!([n, json_number(Some(*v))])).collect::<Vec<_>>(),
        "amount": amount(&held.log, REGISTRY, effect),
    })
}

/// What each coefficient of an effect is called: an axis, or the words of its effect.
fn coefficient_names(effect: &FittedEffect) -> Vec<String> {
    let count = effect.coefficients.len();
    let named = REGISTRY.parse(&effect.id).map(|named| named.of_coefficients(count));
    let mut names: Vec<String> = match count {
        1 => vec!["value".into()],
        3 => AXES.map(String::from).to_vec(),
        _ => (1..=count).map(|number| format!("coefficient {number}")).collect(),
    };
    let mut set = |index: usize, name: String| {
        if let Some(slot) = names.get_mut(index) {
            *slot = name;
        }
    };
    for group in named.iter().flat_map(|named| named.family.groups(named.form)) {
        match *group {
            Group::Row { label, names, from, .. } => {
                let whole = |name: &&str| format!("{label} {name}").trim().to_string();
                names.iter().enumerate().for_each(|(i, name)| set(from + i, whole(name)));
            }
            Group::Amplitude { sines, cosines, .. } => {
                for (i, axis) in AXES.iter().enumerate() {
                    set(sines + i, format!("sine {axis}"));
                    set(cosines + i, format!("cosine {axis}"));
                }
            }
            Group::Mean { .. } => {}
        }
    }
    names
}

fn diagnosed(held: &Held, asked: &LookAsked, diagnosis: &Diagnosis) -> Value {
    let arguments = DiagnoseArgs {
        log: held.asked.arguments(),
        field: asked.field(),
        add: asked.add.clone(),
        prior: None,
    };
    let diagnosed_log = DiagnosedLog { log: &held.log, arguments: &arguments, diagnosis };
    let mut object = json::object(diagnosis);
    if let Some(map) = object.as_object_mut() {
        map.insert("sentence".into(), diagnosis_words::sentence(diagnosis).into());
        map.insert("words".into(), diagnosis_words::text(&diagnosed_log).into());
        let effects = diagnosis.effects.iter().map(|effect| explained(held, effect));
        map.insert("explained".into(), effects.collect());
    }
    object
}
