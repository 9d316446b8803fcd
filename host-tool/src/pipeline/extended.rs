//! The fit with effects, or on top of an earlier calibration: by the study instead of the quadric.

use super::Options;
use super::result::Fitted;
use crate::diagnose::outcome::Diagnosis;
use crate::diagnose::{self, Refusal};
use crate::effects::Id;
use crate::failure::{Failure, Outcome};
use crate::ground::{Counted, Ground, Solution, WithoutEffects};
use crate::input::Log;
use ironout::calibration::norm;
use ironout::effect::ColumnName;
use ironout::extended::MAX_EFFECTS;
use ironout::fit::Model;

/// Fits offset, matrix and effects together.
pub fn run(log: &Log, ground: &Ground, options: &Options, mut fitted: Fitted) -> Outcome<Fitted> {
    let study = diagnose::Options {
        field_ut: options.field_ut(),
        method: options.method,
        add: options.add.clone(),
        search: false,
        earlier: options.prior.as_ref().map(|prior| prior.earlier(options.expected.field_ut)),
    };
    let diagnosis = diagnose::study(ground, &study).map_err(|refusal| failure(refusal, log))?;
    let Some(solution) = solution(&ground.counted, &diagnosis, options) else {
        fitted.reasons = diagnosis.reasons;
        if fitted.reasons.is_empty() {
            fitted.reasons.push(
                "the log does not determine these effects beside offset and matrix: leave one out, or record more".into(),
            );
        }
        fitted.reasons.extend(ground.note());
        return Ok(fitted);
    };
    fitted.holdout_rms_ut = diagnosis.steps.last().and_then(|step| step.holdout_rms_ut);
    fitted.noise_floor_ut = diagnosis.noise_floor_ut;
    fitted.residual_floor_ut = diagnosis.residual_floor_ut;
    fitted.judge(&ground.counted, solution);
    fitted.reasons.extend(ground.note());
    if !diagnosis.converged {
        fitted.accepted = false;
        fitted.reasons.insert(
            0,
            "the fit did not converge: these effects and the calibration are hardly told apart by this log; leave one out, or \
             record more"
                .into(),
        );
    }
    fitted.reasons.extend(not_shown(&diagnosis));
    Ok(fitted)
}

/// What the log does not show of the effects in the model.
fn not_shown(diagnosis: &Diagnosis) -> Vec<String> {
    let unseen: Vec<&str> = (diagnosis.effects.iter())
        .filter(|effect| {
            effect.coefficients.iter().zip(&effect.std_errors).all(|(value, error)| value.abs() < 3.0 * error)
        })
        .map(|effect| effect.id.as_str())
        .collect();
    let falls = match (diagnosis.steps.first(), diagnosis.steps.last()) {
        (Some(first), Some(last)) => last.rms_ut < 0.95 * first.rms_ut,
        _ => false,
    };
    if unseen.len() > 1 && falls {
        return vec![format!(
            "note: {} explain the same here and cannot be told apart: record a log in which they change one at a time",
            unseen.join(" and ")
        )];
    }
    let told = |id: &&str| {
        format!("note: no coefficient of {id} is three standard errors from zero: this log does not show it")
    };
    unseen.iter().map(told).collect()
}

/// Every id must be one that a calibration can carry, at most once, with its column in the log.
pub(super) fn check_ids(log: &Log, ids: &[String]) -> Outcome<()> {
    if ids.len() > MAX_EFFECTS {
        return Err(Failure::usage(format!(
            "--add: a calibration carries at most {MAX_EFFECTS} effects, and {} are given",
            ids.len()
        )));
    }
    for (index, id) in ids.iter().enumerate() {
        if id == "misalignment" || id == "axis-order" {
            return Err(Failure::usage(format!(
                "--add {id}: this is no effect to add: with an accelerometer in the log (ax_mps2,ay_mps2,az_mps2) the \
                 alignment is always part of the fit"
            )));
        }
        let Some(parts) = Id::parse(id) else {
            return Err(Failure::usage(format!(
                "--add {id}: unknown effect; this log allows {}",
                known(log).join(", ")
            )));
        };
        let timed = parts.delayed || ["drift", "step", "periodic"].contains(&parts.kind);
        let missing = [
            (timed && log.time_s.is_none(), "t_s", "it needs the time, and the log has no time column"),
            (
                parts.kind == "lag" && log.gyro_radps.is_none(),
                "gx_radps",
                "it needs the rate of turn, which is not in the log",
            ),
        ];
        if let Some((_, column, why)) = missing.into_iter().find(|(is_missing, ..)| *is_missing) {
            return Err(Failure::usage(format!("--add {id}: {why}")).in_file(&log.path).at_column(column));
        }
        if ids[..index].contains(id) {
            return Err(Failure::usage(format!("--add {id}: given twice")));
        }
        let Some(column) = parts.column else { continue };
        let bad = |why: String| {
            Err(Failure::usage(format!("--add {id}: {why}")).in_file(&log.path).at_column(column))
        };
        let Some(covariate) = log.covariate(column) else {
            let names: Vec<&str> = log.covariates.iter().map(|c| c.name.as_str()).collect();
            return bad(format!(
                "the log has no such column; the columns that effects may follow are {}",
                if names.is_empty() { "none".to_string() } else { names.join(", ") }
            ));
        };
        let values = || covariate.values.iter().copied().filter(|value| value.is_finite());
        let least = values().fold(f64::INFINITY, f64::min);
        let most = values().fold(f64::NEG_INFINITY, f64::max);
        if covariate.not_finite > 0 {
            return bad(format!("{} of its cells are NaN or infinite", covariate.not_finite));
        }
        if 2 * covariate.empty > log.rows {
            return bad(format!("it is empty in {} of {} rows", covariate.empty, log.rows));
        }
        if most - least <= 1e-9 * most.abs().max(least.abs()) {
            return bad(format!("it is constant ({least}): record a log in which it changes"));
        }
        ColumnName::new(column).map_err(|error| {
            Failure::usage(format!("--add {id}: {error}; take it by another name with --map"))
                .in_file(&log.path)
                .at_column(column)
        })?;
    }
    Ok(())
}

/// The ids that the columns of this log allow.
pub fn known(log: &Log) -> Vec<String> {
    let mut known = Vec::new();
    for column in &log.covariates {
        let name = &column.name;
        known.extend([format!("offset:{name}"), format!("offset:{name}^2")]);
        if log.time_s.is_some() {
            known.push(format!("offset:{name}@delay"));
        }
        known.extend([format!("gain:{name}"), format!("field:{name}")]);
    }
    if log.time_s.is_some() {
        known.extend(["drift", "step", "periodic"].map(String::from));
    }
    if log.gyro_radps.is_some() {
        known.push("lag".into());
    }
    known.extend(["nonlinearity", "cross-axis"].map(String::from));
    known
}

fn failure(refusal: Refusal, log: &Log) -> Failure {
    match refusal {
        Refusal::BadShape(id) => {
            Failure::usage(format!("the shape of effect {id} is not finite")).in_file(&log.path)
        }
        Refusal::CannotAdd(id, why) => {
            let failure = Failure::usage(format!("--add {id}: {why}")).in_file(&log.path);
            match Id::parse(&id).and_then(|parts| parts.column) {
                Some(column) => failure.at_column(column),
                None => failure,
            }
        }
    }
}

/// What the study arrived at; `None` where it is no calibration.
fn solution(counted: &Counted, diagnosis: &Diagnosis, options: &Options) -> Option<Solution> {
    let (calibration, last) = (diagnosis.calibration?, diagnosis.steps.last()?);
    let finite = diagnosis.effects.iter().all(|effect| effect.coefficients.iter().all(|v| v.is_finite()));
    let std_errors = diagnosis.std_errors.clone().filter(|_| finite)?;
    let squares: f64 = counted
        .used
        .iter()
        .map(|&sample| {
            let v = counted.data.field(sample);
            norm(std::array::from_fn(|axis| v[axis] - calibration.offset_ut[axis])).powi(2)
        })
        .sum();
    let first = diagnosis.steps.first().filter(|_| !diagnosis.effects.is_empty());
    Some(Solution {
        calibration,
        std_errors,
        effects: diagnosis.effects.clone(),
        rms_ut: last.rms_ut,
        predicted_error_ut: diagnosis.predicted_error_ut.unwrap_or(f64::INFINITY),
        measured_field_ut: (squares / counted.used.len().max(1) as f64).sqrt(),
        model: if diagnosis.lower_order { Model::Sphere } else { Model::Ellipsoid },
        information: diagnosis.information.clone(),
        alignment: diagnosis.alignment.clone(),
        without_effects: first
            .map(|step| WithoutEffects { rms_ut: step.rms_ut, holdout_rms_ut: step.holdout_rms_ut }),
        prior: options.prior.is_some().then(|| diagnosis.prior.clone()),
    })
}
