//! The fit with effects, or on top of an earlier calibration: by the study instead of the quadric.

use crate::base::counted::Counted;
use crate::base::ground::Ground;
use crate::base::solution::{Solution, WithoutEffects};
use crate::fit::fitted::Fitted;
use crate::outcome::outcome::Diagnosis;
use crate::outcome::request::{Options, Refusal};
use crate::outcome::study::study;
use crate::reason::Reason;
use crate::search::shown::Shown;
use ironout::calibration::norm;
use ironout::fit::Order;

/// Fits offset, matrix and effects together.
///
/// # Errors
/// An effect that this log does not allow.
pub fn run(ground: &Ground, options: &Options, mut fitted: Fitted) -> Result<Fitted, Refusal> {
    let diagnosis = study(ground, &Options { search: false, ..options.clone() })?;
    if !ground.counted.rests {
        fitted.counts_as(&diagnosis);
    }
    let Some(solution) = solution(&ground.counted, &diagnosis, options) else {
        fitted.reasons = diagnosis.reasons;
        if fitted.reasons.is_empty() {
            fitted.reasons.push(Reason::new("effects-undetermined", "this log does not determine these effects in addition to offset and matrix. Fix: drop one, or record \
                 more"));
        }
        fitted.reasons.extend(ground.note());
        return Ok(fitted);
    };
    fitted.holdout_rms_ut = diagnosis.steps.last().and_then(|step| step.holdout_rms_ut);
    fitted.noise_floor_ut = diagnosis.noise_floor_ut;
    fitted.residual_floor_ut = diagnosis.residual_floor_ut;
    fitted.residual_floor_least_ut = diagnosis.residual_floor_least_ut;
    fitted.judge(&ground.counted, solution, options.registry);
    fitted.reasons.extend(ground.note());
    if !diagnosis.converged {
        (fitted.accepted, fitted.only_saturated) = (false, false);
        let why = match options.add.is_empty() {
            true => "the fit did not converge. Fix: record more, in more orientations",
            false => {
                "the fit did not converge: these effects and the calibration are nearly collinear in this log. Fix: drop \
                 one, or record more"
            }
        };
        fitted.reasons.insert(0, Reason::new("no-convergence", why));
    }
    let not_significant = not_shown(&diagnosis.shown);
    if options.force_effect {
        let kept = |doubt: &String| {
            Reason::new(
                "effect-not-significant",
                format!("note: {doubt}. It is kept because of --force-effect"),
            )
        };
        fitted.reasons.extend(not_significant.iter().map(kept));
    } else if !not_significant.is_empty() {
        (fitted.accepted, fitted.only_saturated) = (false, false);
        fitted.reasons.splice(
            0..0,
            not_significant
                .iter()
                .map(|doubt| Reason::new("effect-not-significant", format!("{doubt}. {REMEDY}"))),
        );
    }
    Ok(fitted)
}

/// What to do about an effect that the log does not show.
const REMEDY: &str = "Drop it, or use --force-effect if you know it from another test";

/// The effects that this log does not show, each with the reason.
fn not_shown(shown: &[Shown]) -> Vec<String> {
    let number =
        |value: Option<f64>, unit: &str| value.map_or("-".into(), |value| format!("{value:.3} {unit}"));
    let because = |one: &Shown| {
        let errors =
            format!("{} with it, {} without", number(one.with, one.unit), number(one.without, one.unit));
        if one.is_significant() {
            format!("{} does not reduce the held-out error ({errors})", one.id)
        } else {
            format!("No evidence for {} (p = {:.1e}; held-out error {errors})", one.id, one.p_value)
        }
    };
    shown.iter().filter(|one| !one.is_shown()).map(because).collect()
}

/// What the study arrived at; `None` where it is not a calibration.
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
        rotation_error_rad: diagnosis.rotation_error_rad,
        field_varies_by_ut: 0.0,
        measured_field_ut: (squares / counted.used.len().max(1) as f64).sqrt(),
        model: if diagnosis.lower_order { Order::Sphere } else { Order::Ellipsoid },
        information: diagnosis.information.clone(),
        alignment: diagnosis.alignment.clone(),
        without_effects: first
            .map(|step| WithoutEffects { rms_ut: step.rms_ut, holdout_rms_ut: step.holdout_rms_ut }),
        prior: options.prior.is_some().then(|| diagnosis.prior.clone()),
    })
}
