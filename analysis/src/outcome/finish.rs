//! The diagnosis that a finished search of the magnitude comes to.

use crate::base::applied::Applied;
use crate::base::engine::Fitted;
use crate::base::mounting::AXIS_ORDER;
use crate::base::quality::{
    NoiseEstimate, covariance, information, memory_of_scores, noise_gain, predicted_error, residue,
};
use crate::calibration::Information;
use crate::evidence::select::{Begin, moving};
use crate::evidence::wander::Moving;
use crate::outcome::axes_status;
use crate::outcome::outcome::{Diagnosis, Dip, NoiseRow, StepRow, Verdict};
use crate::outcome::request::Refusal;
use crate::outcome::view::{Judged, View};
use crate::reason::Reason;
use crate::residual::traces::Traces;
use crate::search::state::held_out_rms;
use ironout::calibration::Calibration;
use ironout::study::Residual;

impl View<'_, '_> {
    pub(crate) fn finish(mut self, force_lag: bool) -> Result<Diagnosis, Refusal> {
        // Without an offset and a matrix of its own the log says nothing about a rotation either.
        let mut dip = if self.lower_order.is_some() { None } else { self.dip(force_lag)? };
        let order_status = dip.as_ref().map(|dip| self.settle(dip));
        let fitted = &self.explanation.fitted;
        let applied = Applied::of(&self.design, fitted)?;
        let (rms_ut, holdout_rms_ut) = left_ut(fitted, &applied);
        // Without effects the final model is the base model, and what `fit` says of that holds.
        let plain = self.base.filter(|_| fitted.terms.is_empty() && self.lower_order.is_none());
        let left = match plain {
            Some(base) => base.residue.clone(),
            None => self.residue(fitted, &applied),
        };
        let gain = noise_gain(fitted, Residual::Magnitude);
        let predicted = match plain {
            Some(base) => Some(base.predicted_share()),
            None => predicted_error(&self.design, fitted, self.known, &left),
        };
        let time = left.time.max(memory_of_scores(&self.design, fitted));
        let rows = covariance(fitted, time);
        if let (Some(dip), Some(rows)) = (&mut dip, &rows) {
            dip.delay_error_s =
                dip.errors.as_ref().map_or(f64::NAN, |errors| errors.delay_variance(rows).sqrt());
        }
        let is_coupled = fitted.terms.iter().any(|term| !term.hidden_delay().is_empty());
        let late = dip.as_ref().and_then(|dip| Some((dip, dip.lag.as_ref()?))).filter(|_| !is_coupled);
        let pure_lag = late.is_some();
        let swapped = order_status.and_then(|order_status| order_status.swapped());
        let Judged { mut verdict, mut reasons, only_unsure, has_attitude } =
            self.verdict(&left, &applied, predicted, fitted.model.field_ut);
        if verdict == Verdict::Complete && (pure_lag || swapped.is_some()) {
            verdict = Verdict::Missing;
        }
        let traces = Traces::of(&self.design, &self.explanation.base, &self.explanation.fitted)?;
        let wanted = verdict == Verdict::Unexplained && self.searches && self.lower_order.is_none();
        let fitted = &self.explanation.fitted;
        let begin = Begin { model: &fitted.model, known: self.known, stay: &fitted.terms, is_at_rest: false };
        let moving = match wanted {
            true => moving(self.samples, self.table, self.catalogue.registry, &begin),
            false => Moving::default(),
        };
        if let Some(share) = moving.field_share {
            reasons.push(Reason::new("field-not-uniform", format!(
                "{:.0} % of the remaining variance does not depend on the orientation and changes along the path. The field \
                 itself is not uniform, as next to iron, magnets or cables, or the gain of all axes changes",
                100.0 * share
            )));
        }
        let candidates = self.candidates(&dip, pure_lag, order_status, verdict);
        let mut steps = self.steps(&dip)?;
        if let Some((dip, lag)) = late {
            steps.push(StepRow {
                added: Some(lag.id.clone()),
                rms_ut,
                holdout_rms_ut,
                dip_rms_deg: Some(dip.after_deg),
            });
        }
        let groups = &self.explanation.confounded;
        let in_group = |id: &str| groups.iter().any(|group| group.ids.iter().any(|other| other == id));
        steps.retain(|step| step.added.as_ref().is_none_or(|id| !in_group(id)));
        if let (Some(_), Some(dip)) = (swapped, &dip) {
            steps.push(StepRow {
                added: Some(AXIS_ORDER.id.into()),
                rms_ut,
                holdout_rms_ut,
                dip_rms_deg: Some(dip.after_deg),
            });
        }
        let fitted = &self.explanation.fitted;
        let field = fitted.model.field_ut;
        let effects = self.effects(time, &dip)?;
        let full = if dip.is_some() { fitted.model.full_matrix() } else { fitted.model.matrix };
        let headings = self.heading(&dip)?;
        let mut diagnosis = Diagnosis {
            verdict,
            reasons,
            residual: Residual::Magnitude.name(),
            steps,
            noise_floor_ut: Some(left.floor / applied.share / gain),
            residual_floor_ut: Some(left.floor),
            residual_floor_least_ut: Some(left.floor_least),
            noise: Some(NoiseRow::of(&left)),
            candidates,
            data_faults: Vec::new(),
            dip: dip.as_ref().map(|dip| Dip {
                rms_deg_before: self.base_dip().unwrap_or(dip.alignment.before_deg),
                rms_deg_after: dip.after_deg,
                misalignment_deg: dip.alignment.angle_deg,
            }),
            heading: headings,
            shows: self.shows()?,
            effects,
            calibration: Some(Calibration {
                offset_ut: fitted.model.offset_ut,
                matrix: full,
                field_ut: field,
            }),
            std_errors: None,
            alignment: Default::default(),
            order_status,
            information: (information(&self.design, fitted, self.known, time))
                .and_then(|matrix| Information::of(&matrix)),
            converged: fitted.converged,
            base: None,
            predicted_error_ut: predicted.map(|error| error * field),
            rotation_error_rad: 0.0,
            field_varies: moving.field_share,
            fit_refuses: None,
            only_unsure,
            has_attitude,
            chances: self.explanation.chances.clone(),
            samples_used: 0,
            samples_set_aside: 0,
            prior: self.prior_words(),
            contradiction: None,
            recordings: None,
            switching: None,
            levels: None,
            pair: None,
            wander: moving.offset,
            lower_order: self.lower_order.is_some(),
            shown: self.shown(&dip, force_lag),
            traces,
            registry: self.catalogue.registry,
        };
        axes_status::take_axes(&mut diagnosis, rows.as_deref(), &dip);
        if let (Some(base), None) = (self.base, &self.lower_order) {
            axes_status::first_row(&mut diagnosis, base, plain.is_some());
        }
        axes_status::tell_matrix(&mut diagnosis);
        Ok(diagnosis)
    }

    /// What a model leaves under its own correction.
    fn residue(&self, fitted: &Fitted, applied: &Applied) -> NoiseEstimate {
        residue(&self.design, &fitted.model, &applied.residuals, fitted.columns())
    }
}

/// Rms error that a correction by a model leaves, and that on held-out time, µT.
fn left_ut(fitted: &Fitted, applied: &Applied) -> (f64, Option<f64>) {
    (applied.share * fitted.rms(), held_out_rms(fitted).map(|held| applied.share * held))
}
