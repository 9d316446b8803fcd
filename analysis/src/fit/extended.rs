//! The fit with effects, or on top of an earlier calibration: by the study instead of the quadric.

use crate::base::counted::Counted;
use crate::base::ground::Ground;
use crate::base::solution::{Solution, WithoutEffects};
use crate::fit::fitted::Fitted;
use crate::outcome::outcome::Diagnosis;
use crate::outcome::request::{Options, Refusal};
use crate::outcome::study::study;
use ironout::calibration::norm;
use ironout::fit::Order;

/// Fits offset, matrix and effects together.
///
/// # Errors
/// An effect that this log does not allow.
pub fn run(ground: &Ground, options: &Options, mut fitted: Fitted) -> Result<Fitted, Refusal> {
    let diagnosis = study(ground, &Options { search: false, ..options.clone() })?;
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
        model: if diagnosis.lower_order { Order::Sphere } else { Order::Ellipsoid },
        information: diagnosis.information.clone(),
        alignment: diagnosis.alignment.clone(),
        without_effects: first
            .map(|step| WithoutEffects { rms_ut: step.rms_ut, holdout_rms_ut: step.holdout_rms_ut }),
        prior: options.prior.is_some().then(|| diagnosis.prior.clone()),
    })
}
