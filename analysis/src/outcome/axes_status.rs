//! What a diagnosis shares with `fit`: the axes of its matrix, and the base model as its first row.

use crate::base::axes::{Aligned, Alignment, Found};
use crate::base::model::Base;
use crate::base::mounting::MISALIGNMENT;
use crate::base::term::COLUMNS;
use crate::outcome::outcome::{Diagnosis, Dip};
use crate::outcome::view::DipStudy;

/// Gives the calibration the axes that the dip allows, and the errors in them.
pub(crate) fn take_axes(
    diagnosis: &mut Diagnosis,
    covariance: Option<&[[f64; COLUMNS]]>,
    dip: &Option<DipStudy>,
) {
    let (Some(calibration), Some(covariance)) = (&mut diagnosis.calibration, covariance) else { return };
    if covariance.len() < 9 {
        return;
    }
    let nine = std::array::from_fn(|i| std::array::from_fn(|j| covariance[i][j]));
    let rotation =
        dip.as_ref().and_then(|dip| dip.errors.as_ref()).map(|errors| errors.rotation(Some(covariance)));
    let found = dip.as_ref().zip(diagnosis.order_status).map(|(dip, order_status)| Found {
        before_deg: diagnosis.dip.map_or(dip.alignment.before_deg, |dip| dip.rms_deg_before),
        after_deg: dip.after_deg,
        angle_deg: dip.alignment.angle_deg,
        order_status,
        rotation: rotation.as_ref(),
    });
    let predicted_share =
        diagnosis.predicted_error_ut.map_or(f64::INFINITY, |error| error / calibration.field_ut);
    let Some(aligned) = Aligned::of(&calibration.matrix, &nine, predicted_share, found) else { return };
    calibration.matrix = aligned.matrix;
    diagnosis.std_errors = Some(aligned.std_errors);
    diagnosis.alignment = aligned.alignment;
    diagnosis.rotation_error_rad = aligned.rotation_error_rad;
}

/// Says beside the misalignment whether the calibration's matrix contains it.
pub(crate) fn tell_matrix(diagnosis: &mut Diagnosis) {
    let words = match diagnosis.alignment {
        Alignment::Done { .. } | Alignment::ByAll => "corrected by the full matrix",
        Alignment::NoDip { .. } => "not corrected: the dip varies too much to determine it",
        Alignment::Open(_) | Alignment::Mirrored(_) => "not corrected until the axis order is corrected",
        Alignment::None => "not corrected: too uncertain",
    };
    for row in
        diagnosis.candidates.iter_mut().filter(|row| row.id == MISALIGNMENT.id && row.angle_deg.is_some())
    {
        row.why = format!("{}; {words}", row.why);
    }
}

/// States the base model as `fit` gives it in the first row; of a `plain` diagnosis, which adds nothing to the magnitude's
/// model, everything else too.
pub(crate) fn first_row(diagnosis: &mut Diagnosis, base: &Base, plain: bool) {
    let solution = &base.solution;
    if let Some(first) = diagnosis.steps.first_mut() {
        first.rms_ut = solution.rms_ut;
        first.holdout_rms_ut = base.holdout_rms_ut;
        if let Alignment::Done { after_deg, .. } = &solution.alignment {
            first.dip_rms_deg = Some(*after_deg);
        }
    }
    if !plain {
        return;
    }
    for row in diagnosis.steps.iter_mut().skip(1) {
        (row.rms_ut, row.holdout_rms_ut) = (solution.rms_ut, base.holdout_rms_ut);
    }
    diagnosis.noise_floor_ut = Some(base.noise_floor_ut);
    diagnosis.residual_floor_ut = Some(base.residual_floor_ut);
    diagnosis.residual_floor_least_ut = Some(base.residual_floor_least_ut);
    diagnosis.predicted_error_ut = Some(solution.predicted_error_ut);
    diagnosis.information.clone_from(&solution.information);
    if diagnosis.steps.len() == 1 {
        diagnosis.calibration = Some(solution.calibration);
        diagnosis.std_errors = Some(solution.std_errors.clone());
        diagnosis.alignment = solution.alignment.clone();
        diagnosis.rotation_error_rad = solution.rotation_error_rad;
        if let Alignment::Done { angle_deg, before_deg, after_deg, .. } = solution.alignment {
            diagnosis.dip = Some(Dip {
                rms_deg_before: before_deg,
                rms_deg_after: after_deg,
                misalignment_deg: angle_deg,
            });
        }
    }
}
