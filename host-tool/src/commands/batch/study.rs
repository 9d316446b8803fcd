//! One log: read, fitted and searched.

use crate::cli::{Expected, LogArgs};
use crate::commands::batch::files::Found;
use crate::commands::batch::origin::{From, Pattern, origin};
use crate::commands::batch::row::{Row, RowEffect};
use crate::failure::{Failure, Outcome};
use crate::input::Log;
use crate::plausible::Known;
use crate::registry::REGISTRY;
use crate::{refusal, source};
use ironout::fit::Method;
use ironout_analysis::fleet::summary::ERROR;
use ironout_analysis::outcome::outcome::Status;
use ironout_analysis::{Diagnosis, Fitted, Options, Table, fit_and_diagnose};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// What is asked of every log.
pub(super) struct Asked {
    pub reading: LogArgs,
    pub expected: Expected,
    pub method: Method,
    pub pattern: Option<Pattern>,
}

/// The row of one log; a log that cannot be studied has one with its error.
pub(super) fn study(found: &Found, asked: &Asked) -> Row {
    let began = Instant::now();
    // A fault of this program in one log must not end a run of thousands.
    let studied = catch_unwind(AssertUnwindSafe(|| one(found, asked))).unwrap_or_else(|_| {
        Err(Failure::usage("this program failed on this log. Fix: report it, with the log")
            .in_file(&found.path))
    });
    let mut row = studied.unwrap_or_else(|failure| {
        let failed = Row { verdict: ERROR.into(), error: Some(failure.to_string()), ..Row::default() };
        Row {
            log: found.path.display().to_string(),
            ..from(failed, origin(found, None, asked.pattern.as_ref()))
        }
    });
    row.took_s = Some((began.elapsed().as_secs_f64() * 1e3).round() / 1e3);
    row
}

fn one(found: &Found, asked: &Asked) -> Outcome<Row> {
    let arguments = asked.reading.alone(&found.path);
    let log = source::read_quietly(&arguments, &Known::given(asked.expected.field_ut))?;
    let options = Options {
        method: asked.method,
        field_ut: asked.expected.field_ut,
        dip_deg: asked.expected.earth.map(|earth| earth.dip_deg),
        search: true,
        registry: REGISTRY,
        ..Options::default()
    };
    let (fitted, diagnosis) = fit_and_diagnose(&Table::from(&log), &options)
        .map_err(|refusal| refusal::failure(refusal, &log.path))?;
    let row = from(row(&log, &fitted, &diagnosis), origin(found, Some(&log), asked.pattern.as_ref()));
    Ok(Row { log: found.path.display().to_string(), ..row })
}

fn from(row: Row, from: From) -> Row {
    Row {
        vehicle: from.vehicle,
        sensor: from.sensor,
        start: from.start.map(|(start, _)| start.to_string()),
        start_from: from.start.map(|(_, what)| what.to_string()),
        ..row
    }
}

fn row(log: &Log, fitted: &Fitted, diagnosis: &Diagnosis) -> Row {
    let solution = fitted.solution.as_ref();
    // With what was found in the model, where that has a calibration.
    let calibration = diagnosis.calibration.or(solution.map(|solution| solution.calibration));
    let std_errors = match diagnosis.calibration {
        Some(_) => diagnosis.std_errors.as_ref(),
        None => solution.map(|solution| &solution.std_errors),
    };
    let last = diagnosis.steps.last();
    let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
    let mut effects: Vec<RowEffect> = diagnosis
        .effects
        .iter()
        .map(|effect| RowEffect {
            id: effect.id.clone(),
            coefficients: effect.coefficients.clone(),
            unit: effect.unit.to_string(),
            reference: match effect.reference.as_slice() {
                [(_, value)] => Some(*value),
                _ => None,
            },
        })
        .collect();
    // A mounting or a lag has no coefficients and is missing anyway.
    for candidate in diagnosis.candidates.iter().filter(|candidate| candidate.status == Status::Missing) {
        if !effects.iter().any(|effect| effect.id == candidate.id) {
            effects.push(RowEffect {
                id: candidate.id.clone(),
                coefficients: Vec::new(),
                unit: String::new(),
                reference: None,
            });
        }
    }
    let reasons = match diagnosis.reasons.is_empty() {
        true => &fitted.reasons,
        false => &diagnosis.reasons,
    };
    Row {
        format: Some(log.read_as.format.clone()),
        rows: Some(log.rows as u64),
        samples_used: Some(diagnosis.samples_used as u64),
        samples_set_aside: Some(diagnosis.samples_set_aside as u64),
        seconds: finite(log.time_s.as_ref().and_then(|time| Some(time.last()? - time.first()?))),
        verdict: diagnosis.verdict.name().to_string(),
        accepted: Some(fitted.accepted),
        field_ut: finite(calibration.map(|calibration| calibration.field_ut)),
        offset_ut: calibration.map(|calibration| calibration.offset_ut),
        offset_std_ut: std_errors.map(|errors| errors.offset_ut),
        matrix: calibration.map(|calibration| calibration.matrix),
        base_rms_ut: finite(solution.map(|solution| solution.rms_ut)),
        rms_ut: finite(last.map(|step| step.rms_ut)),
        holdout_rms_ut: finite(last.and_then(|step| step.holdout_rms_ut)),
        noise_floor_ut: finite(diagnosis.noise_floor_ut),
        predicted_error_ut: finite(diagnosis.vector_error_ut()),
        heading_error_deg: finite(fitted.heading_error_deg),
        effects,
        reasons: reasons.iter().map(ToString::to_string).collect(),
        notices: log.notices.clone(),
        ..Row::default()
    }
}
