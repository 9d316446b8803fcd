//! The fit with effects, or on top of an earlier calibration: by the study instead of the quadric.

use super::align::{ALIGNABLE, full_errors, is_mirrored, triangle_of};
use super::result::Fitted;
use super::solution::{Alignment, Solution, WithoutEffects};
use super::{Data, FaultKind, MOST_SPREAD_DEG, Options};
use crate::cal_file::{Information, StdErrors};
use crate::diagnose::faults::FaultKind as Found;
use crate::diagnose::outcome::Diagnosis;
use crate::diagnose::{self, Refusal};
use crate::effects::Id;
use crate::failure::{Failure, Outcome};
use crate::input::Log;
use ironout::calibration::norm;
use ironout::effect::ColumnName;
use ironout::extended::MAX_EFFECTS;
use ironout::fit::Model;
use nalgebra::SMatrix;

/// Fits offset, matrix and effects together. `fitted` holds what the plain fit of the same samples counted.
pub fn run(data: &Data, moving: &[u32], options: &Options, mut fitted: Fitted) -> Outcome<Fitted> {
    let log = data.log;
    check_ids(log, &options.add)?;
    let table = data.table_of(moving);
    let study = diagnose::Options {
        field_ut: options.field_ut(),
        add: options.add.clone(),
        search: false,
        earlier: options.prior.as_ref().map(|prior| prior.earlier(options.expected.field_ut)),
    };
    let diagnosis = diagnose::diagnose(&table, &study).map_err(|refusal| failure(refusal, log))?;
    fitted.aside = aside(&diagnosis);
    fitted.too_many_outliers = None;
    fitted.used = diagnosis.samples_used;
    fitted.solution = None;
    let Some(solution) = solution(data, moving, &diagnosis, options)? else {
        fitted.accepted = false;
        fitted.holdout_rms_ut = None;
        fitted.noise_floor_ut = None;
        fitted.residual_floor_ut = None;
        fitted.heading_error_deg = None;
        fitted.reasons = diagnosis.reasons;
        if fitted.reasons.is_empty() {
            fitted.reasons.push(
                "the log does not determine these effects beside offset and matrix: leave one out, or record more".into(),
            );
        }
        return Ok(fitted);
    };
    fitted.holdout_rms_ut = diagnosis.steps.last().and_then(|step| step.holdout_rms_ut);
    fitted.noise_floor_ut = diagnosis.noise_floor_ut;
    fitted.residual_floor_ut = diagnosis.residual_floor_ut;
    fitted.judge(data, moving, solution);
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
        fitted.reasons.push(format!(
            "note: {} explain the same here and cannot be told apart: record a log in which they change one at a time",
            unseen.join(" and ")
        ));
    } else {
        for id in unseen {
            fitted.reasons.push(format!(
                "note: no coefficient of {id} is three standard errors from zero: this log does not show it"
            ));
        }
    }
    Ok(fitted)
}

/// Every id must be one that a calibration can carry, at most once, with its column in the log.
fn check_ids(log: &Log, ids: &[String]) -> Outcome<()> {
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

/// Samples set aside by the study, by kind.
fn aside(diagnosis: &Diagnosis) -> Vec<(FaultKind, usize)> {
    let mut counts: Vec<(FaultKind, usize)> = Vec::new();
    for fault in &diagnosis.data_faults {
        let kind = match fault.kind {
            Found::Clipping => {
                let axis = ["mx_ut", "my_ut", "mz_ut"];
                let axis = axis.iter().position(|name| fault.columns.iter().any(|column| column == name));
                FaultKind::Clipping { axis: axis.unwrap_or_default() }
            }
            Found::Burst => FaultKind::Outlier,
            Found::Stuck => FaultKind::Stuck,
            Found::Gap | Found::CopiedAxis => continue,
        };
        match counts.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, count)) => *count += fault.samples,
            None => counts.push((kind, fault.samples)),
        }
    }
    counts
}

/// What the study arrived at; `None` where it is no calibration.
fn solution(
    data: &Data,
    moving: &[u32],
    diagnosis: &Diagnosis,
    options: &Options,
) -> Outcome<Option<Solution>> {
    let (Some(mut calibration), Some(last)) = (diagnosis.calibration, diagnosis.steps.last()) else {
        return Ok(None);
    };
    // Where the data alone do not determine everything there is no information to hand on, but there are errors.
    let known = diagnosis.information.as_ref().and_then(inverse);
    let covariance = known.or_else(|| diagonal(diagnosis));
    let finite = diagnosis.effects.iter().all(|effect| effect.coefficients.iter().all(|v| v.is_finite()));
    let (Some(covariance), true) = (covariance, finite) else { return Ok(None) };
    let Some(triangle) = triangle_of(&calibration.matrix) else { return Ok(None) };
    let mut alignment = Alignment::None;
    let mut matrix = std::array::from_fn(|i| {
        std::array::from_fn(|j| if j < i { 0.0 } else { diagnosis.matrix_std_errors[i][j] })
    });
    let predicted_error_ut = diagnosis.predicted_error_ut.unwrap_or(f64::INFINITY);
    if !(predicted_error_ut <= ALIGNABLE * calibration.field_ut) {
        calibration.matrix = triangle;
    } else if let Some(order) = diagnosis.axis_order.clone().filter(|order| is_mirrored(order)) {
        calibration.matrix = triangle;
        alignment = Alignment::Mirrored { order };
    } else if let Some(dip) = diagnosis.dip {
        if dip.rms_deg_after > MOST_SPREAD_DEG {
            calibration.matrix = triangle;
            alignment = Alignment::NoDip { after_deg: dip.rms_deg_after };
        } else {
            let rotation = diagnosis.rotation_errors.as_ref();
            matrix = full_errors(&triangle, &calibration.matrix, &covariance, rotation);
            alignment = Alignment::Done {
                angle_deg: dip.misalignment_deg,
                before_deg: dip.rms_deg_before,
                after_deg: dip.rms_deg_after,
                axis_order: diagnosis.axis_order.clone(),
            };
        }
    }
    let squares: f64 = moving
        .iter()
        .map(|&sample| {
            let v = data.field(sample);
            norm(std::array::from_fn(|axis| v[axis] - calibration.offset_ut[axis])).powi(2)
        })
        .sum();
    let first = diagnosis.steps.first().filter(|_| !diagnosis.effects.is_empty());
    Ok(Some(Solution {
        calibration,
        std_errors: StdErrors { offset_ut: diagnosis.offset_std_errors_ut, matrix },
        effects: diagnosis.effects.clone(),
        rms_ut: last.rms_ut,
        predicted_error_ut,
        measured_field_ut: (squares / moving.len().max(1) as f64).sqrt(),
        model: if diagnosis.lower_order { Model::Sphere } else { Model::Ellipsoid },
        information: known.as_ref().and_then(Information::from_covariance),
        alignment,
        without_effects: first
            .map(|step| WithoutEffects { rms_ut: step.rms_ut, holdout_rms_ut: step.holdout_rms_ut }),
        prior: options.prior.is_some().then(|| diagnosis.prior.clone()),
    }))
}

/// The errors alone, as if they were independent.
fn diagonal(diagnosis: &Diagnosis) -> Option<[[f64; 9]; 9]> {
    let [x, y, z] = diagnosis.offset_std_errors_ut;
    let [[a, b, c], [_, d, e], [_, _, f]] = diagnosis.matrix_std_errors;
    let errors = [x, y, z, a, b, c, d, e, f];
    errors.iter().all(|error| error.is_finite()).then(|| {
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { errors[i] * errors[i] } else { 0.0 }))
    })
}

fn inverse(information: &[[f64; 9]; 9]) -> Option<[[f64; 9]; 9]> {
    // Offsets are in µT and matrix entries near 1: equal diagonals before inverting keep the digits.
    let scale: [f64; 9] = std::array::from_fn(|i| 1.0 / information[i][i].sqrt());
    let unit = SMatrix::<f64, 9, 9>::from_fn(|i, j| information[i][j] * scale[i] * scale[j]);
    let inverse = unit.cholesky()?.inverse();
    Some(std::array::from_fn(|i| std::array::from_fn(|j| inverse[(i, j)] * scale[i] * scale[j])))
}
