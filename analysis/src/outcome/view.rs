//! What a finished search says: verdict, floors, dip and heading.

use crate::base::alignment::{Alignment, align, without_effects};
use crate::base::applied::Applied;
use crate::base::dip_errors::DipErrors;
use crate::base::engine::Design;
use crate::base::heading::heading_error;
use crate::base::hemisphere::{Evidence, settle};
use crate::base::model::Base;
use crate::base::mounting::OrderStatus;
use crate::base::prior::Prior;
use crate::base::quality::{NoiseEstimate, attitude_error, covariance, error_beyond};
use crate::base::start;
use crate::base::term::{BadShape, Term};
use crate::bounds::{BETTER_PART, KNOWN_DEG, MAX_ERROR_TO_NAME, MAX_P_HELD_OUT};
use crate::outcome::outcome::{Heading, StepRow, Verdict, Where};
use crate::outcome::shows::shows;
use crate::reason::Reason;
use crate::residual::late::{Late, scan};
use crate::samples::samples::Samples;
use crate::samples::series::Autocorrelation;
use crate::search::candidates::Catalogue;
use crate::search::screen::{SIGNIFICANCE, test};
use crate::search::shown::Shown;
use crate::search::state::{Explanation, held_out_rms};
use crate::table::Table;
use ironout::fit::MAX_PREDICTED_ERROR;
use ironout::quality::MAX_RESIDUAL;
use ironout::study::{Model, Residual, f_tail};

/// A verdict and why.
pub(crate) struct Judged {
    pub(crate) verdict: Verdict,
    pub(crate) reasons: Vec<Reason>,
    /// Whether all is explained, and only the calibration not sure enough.
    pub(crate) only_unsure: bool,
    /// Whether the attitude determines the base model.
    pub(crate) has_attitude: bool,
}

/// Everything that the report of a magnitude study is made from.
pub(crate) struct View<'v, 'a> {
    pub(crate) table: &'a Table<'a>,
    pub(crate) samples: &'a Samples,
    pub(crate) catalogue: &'v Catalogue<'a>,
    pub(crate) design: Design<'a>,
    pub(crate) known: &'v Prior,
    pub(crate) explanation: Explanation<'a>,
    /// What is known of the base, in words, where not all of it is estimated.
    pub(crate) lower_order: Option<String>,
    /// The base model as `fit` gives it, if the log carries one.
    pub(crate) base: Option<&'v Base>,
    /// The dip of the place, degrees, where it is known.
    pub(crate) dip_deg: Option<f64>,
    /// Whether effects are looked for; a fit takes those that were asked for and no other.
    pub(crate) searches: bool,
}

/// What the dip says in the end.
pub(crate) struct DipStudy<'a> {
    pub(crate) alignment: Alignment,
    pub(crate) lag: Option<Term<'a>>,
    pub(crate) after_deg: f64,
    pub(crate) errors: Option<DipErrors>,
    /// Standard error of the delay, s.
    pub(crate) delay_error_s: f64,
    /// p-value and held-out rms in degrees of the pure lag.
    pub(crate) tested: Option<(f64, Option<f64>)>,
    /// The test of a pure lag that was asked for.
    pub(crate) shown: Option<Shown>,
}

impl<'a> View<'_, 'a> {
    pub(crate) fn dip(&self, force_lag: bool) -> Result<Option<DipStudy<'a>>, BadShape> {
        let fitted = &self.explanation.fitted;
        let clean = without_effects(self.samples, &fitted.model, &fitted.terms);
        let Some(alignment) = align(&clean, &fitted.model)? else { return Ok(None) };
        let after_deg = alignment.after_deg;
        let errors = DipErrors::of(self.samples, &alignment.model, &fitted.terms, None)?;
        let mut study = DipStudy {
            alignment,
            lag: None,
            after_deg,
            errors,
            delay_error_s: f64::NAN,
            tested: None,
            shown: None,
        };
        let is_coupled = fitted.terms.iter().any(|term| !term.hidden_delay().is_empty());
        if !(self.searches || force_lag || is_coupled) {
            return Ok(Some(study));
        }
        let Some(lag) = self.catalogue.late_sensor() else { return Ok(Some(study)) };
        let lag_id = lag.id.clone();
        let design = Design::new(&clean, Residual::Dip);
        let Some(base) = design.fit(study.alignment.model, Vec::new(), self.known)? else {
            return Ok(Some(study));
        };
        let Some(tested) = test(&design, &base, &lag, 2)? else { return Ok(Some(study)) };
        let held_deg = tested.held_out.map(|squares| (squares / base.rows).sqrt().to_degrees());
        study.tested = Some((tested.p_value, held_deg));
        let has_eddy = is_coupled;
        let far = if tested.accepted || force_lag || has_eddy || after_deg < KNOWN_DEG {
            None
        } else {
            scan(self.table, &clean, &base.model, after_deg)?
        };
        if (tested.accepted || force_lag || has_eddy || far.is_some())
            && let Some(with) = design.fit(base.model, vec![lag], self.known)?
        {
            let held_with = held_out_rms(&with);
            let mut late = Late { model: with.model, terms: with.terms, squares: with.squares, beside: None };
            if !has_eddy {
                late = late.settled(self.table, &clean, self.known, far)?;
            }
            // Errors where the delay is: the sensors beside it are moved, and the term has the rest to do.
            let raw = late.beside.and_then(|delay_s| self.samples.beside_late(self.table, delay_s));
            let mut at = late.terms.first().cloned();
            if let (Some(term), Some(beside)) = (&mut at, late.beside) {
                term.coefficients[0] -= beside;
            }
            let errors =
                DipErrors::of(raw.as_ref().unwrap_or(self.samples), &late.model, &fitted.terms, at.as_ref())?;
            let delay_s = late.terms.first().map_or(0.0, |term| term.coefficients[0]);
            if tested.accepted && !force_lag && !has_eddy {
                let p_value = self.chance_of_delay(&errors, delay_s)?;
                study.tested = Some((p_value, held_deg));
                if 2.0 * p_value >= SIGNIFICANCE {
                    return Ok(Some(study));
                }
            }
            if force_lag && !has_eddy {
                study.shown = Some(Shown {
                    id: lag_id,
                    // The delay and the coupling of eddy currents share the id, and both were tried.
                    p_value: (2.0 * self.chance_of_delay(&errors, delay_s)?).min(1.0),
                    without: held_out_rms(&base).map(f64::to_degrees),
                    with: held_with.map(f64::to_degrees),
                    unit: "°",
                });
            }
            study.errors = errors;
            study.lag = late.terms.into_iter().next();
            if !has_eddy {
                study.alignment.model = late.model;
                study.after_deg = (late.squares / with.rows.max(1.0)).sqrt().to_degrees();
            }
        }
        Ok(Some(study))
    }

    /// The probability that a sensor which is not late shows this delay, with the errors of the base and the effects
    /// counted in. No sensor is early: what points there is chance, or columns whose clocks differ.
    fn chance_of_delay(&self, errors: &Option<DipErrors>, delay_s: f64) -> Result<f64, BadShape> {
        let fitted = &self.explanation.fitted;
        let list: Vec<&Term> = fitted.terms.iter().collect();
        let residuals = self.design.residuals(&fitted.model, &list)?;
        let time = Autocorrelation::of(&residuals).time;
        let (Some(errors), Some(rows)) = (errors, covariance(fitted, time)) else { return Ok(1.0) };
        let variance = errors.delay_variance(&rows);
        if delay_s <= 0.0 || variance.is_nan() || variance <= 0.0 {
            return Ok(1.0);
        }
        Ok(f_tail(delay_s * delay_s / variance, 1.0, fitted.rows / time.max(1.0)))
    }

    /// Takes the alignment's model, or its opposite where heading or place say so: how the axes stand.
    pub(crate) fn settle(&mut self, dip: &DipStudy) -> OrderStatus {
        let evidence = Evidence { heading_deg: self.table.heading_deg, dip_deg: self.dip_deg };
        let (order_status, model) =
            settle(self.samples, &dip.alignment, &self.explanation.fitted.terms, evidence);
        self.explanation.fitted.model = model;
        order_status
    }

    /// The tests of the effects that were asked for. A `pure_lag` that the dip says nothing about is not shown.
    pub(crate) fn shown(&self, dip: &Option<DipStudy>, pure_lag: bool) -> Vec<Shown> {
        let mut shown = self.explanation.shown.clone();
        if pure_lag {
            let nothing = || {
                let id = self.catalogue.late_sensor().map(|lag| lag.id);
                id.map(|id| Shown { id, p_value: 1.0, without: None, with: None, unit: "°" })
            };
            shown.extend(dip.as_ref().and_then(|dip| dip.shown.clone()).or_else(nothing));
        }
        shown
    }

    /// Whether the base model is the final one, and `fit` is sure of it.
    pub(crate) fn is_accepted(&self) -> bool {
        let plain = self.base.filter(|_| self.explanation.fitted.terms.is_empty());
        plain.is_some_and(|base| base.predicted_share() <= MAX_PREDICTED_ERROR)
    }

    pub(crate) fn prior_words(&self) -> String {
        if self.known.earlier.is_some() {
            "earlier calibration, and a weak physical prior".into()
        } else if let Some(words) = &self.lower_order {
            words.clone()
        } else {
            "weak (gains within 20 %, axes within 10°, offset within a few times the field strength)".into()
        }
    }

    pub(crate) fn base_dip(&self) -> Option<f64> {
        let base = &self.explanation.base;
        align(self.samples, &base.model).ok().flatten().map(|alignment| alignment.before_deg)
    }

    pub(crate) fn steps(&self, dip: &Option<DipStudy>) -> Result<Vec<StepRow>, BadShape> {
        let count = self.explanation.steps.len();
        let base_dip =
            align(self.samples, &self.explanation.base.model)?.map(|alignment| alignment.after_deg);
        Ok(self
            .explanation
            .steps
            .iter()
            .enumerate()
            .map(|(index, step)| StepRow {
                added: step.added.clone(),
                rms_ut: step.rms,
                holdout_rms_ut: step.held_out,
                dip_rms_deg: match dip {
                    Some(dip) if index + 1 == count && index > 0 => Some(dip.alignment.after_deg),
                    Some(_) if index == 0 => base_dip,
                    _ => None,
                },
            })
            .collect())
    }

    /// What the model says of the log.
    pub(crate) fn verdict(
        &self,
        left: &NoiseEstimate,
        applied: &Applied,
        predicted: Option<f64>,
        field: f64,
    ) -> Judged {
        let mut reasons = Vec::new();
        let error = match attitude_error(&self.explanation.fitted, left) {
            // What is held fixed has no error to predict, and what `fit` accepts is determined.
            _ if self.lower_order.is_some() || self.is_accepted() => Some(0.0),
            error => error,
        };
        match error {
            Some(error) if error <= MAX_PREDICTED_ERROR => {}
            Some(error) => reasons.push(Reason::new("too-few-orientations", format!(
                "The log does not determine offset and matrix: the predicted error is {:.*} % of the field in the worst \
                 direction (1σ; limit {:.0} %). Record longer and in more orientations. For a vehicle, ironout fit \
                 tries to calibrate for the tilts in the log",
                usize::from(error < 1.05 * MAX_PREDICTED_ERROR) + 1,
                100.0 * error,
                100.0 * MAX_PREDICTED_ERROR
            ))),
            None => reasons.push(Reason::new("too-few-orientations", "too few orientations to determine the ellipsoid")),
        }
        // Noise so large carries no calibration; structure so large is a missing effect, whatever the attitude.
        if left.rms > MAX_RESIDUAL * field && left.structure <= 0.0 {
            reasons.push(Reason::new(
                "residual-too-large",
                format!("The residual is {:.1} % of the field", 100.0 * left.rms / field),
            ));
        } else if reasons.is_empty() {
            return self.of_model(left, applied, predicted, field, true);
        } else if error.is_some_and(|error| error <= MAX_ERROR_TO_NAME) && self.is_certain() {
            // Too little attitude for a calibration still tells a cause that is certain and leaves nothing.
            let judged = self.of_model(left, applied, predicted, field, false);
            if judged.only_unsure || judged.verdict == Verdict::Missing {
                return Judged {
                    verdict: Verdict::Unexplained,
                    reasons,
                    only_unsure: true,
                    has_attitude: false,
                };
            }
        }
        let has_attitude = error.is_some_and(|error| error <= MAX_PREDICTED_ERROR);
        Judged { verdict: Verdict::Undetermined, reasons, only_unsure: false, has_attitude }
    }

    /// Whether chance does as well as none of the effects of the model, and each takes most of the error that it found, on held-out
    /// time too.
    fn is_certain(&self) -> bool {
        let explanation = &self.explanation;
        let chance =
            explanation.chances.iter().map(|(_, p)| p * explanation.count as f64).fold(0.0, f64::max);
        let falls = |before: Option<f64>, after: Option<f64>| {
            before.zip(after).is_some_and(|(before, after)| after * after < BETTER_PART * before * before)
        };
        let mut pairs = explanation.steps.windows(2);
        let each = pairs.all(|pair| {
            falls(Some(pair[0].rms), Some(pair[1].rms)) && falls(pair[0].held_out, pair[1].held_out)
        });
        !explanation.fitted.terms.is_empty() && chance < MAX_P_HELD_OUT && each
    }

    /// What the model says of a log, whether or not its attitude is enough.
    fn of_model(
        &self,
        left: &NoiseEstimate,
        applied: &Applied,
        predicted: Option<f64>,
        field: f64,
        has_attitude: bool,
    ) -> Judged {
        let refused = self.refused_by_fit(applied, predicted, field);
        let (verdict, reasons, only_unsure) = self.reasoned(left, refused);
        Judged { verdict, reasons, only_unsure, has_attitude }
    }

    /// Verdict and reasons, and whether all is explained and only the calibration not sure enough.
    fn reasoned(&self, left: &NoiseEstimate, refused: Option<f64>) -> (Verdict, Vec<Reason>, bool) {
        let mut reasons = Vec::new();
        if let Some(error) = refused {
            reasons.push(Reason::new("error-too-large", format!(
                "The predicted error of a calibration from this log is {:.1} % of the field in the worst direction (1σ){}",
                100.0 * error,
                match (left.structure > 0.0, self.explanation.fitted.terms.is_empty()) {
                    (true, _) => ", including the unexplained error",
                    (false, true) => ", because of its noise. Record longer, in more orientations",
                    (false, false) => ", because of its noise and its effects. Record longer, in more orientations",
                }
            )));
        }
        if self.explanation.ended_early {
            reasons.push(Reason::new("search-limit", "The search stopped at its limit, with candidates that were not tested in addition to the effects found"));
            if left.structure <= 0.0 {
                return (Verdict::Unexplained, reasons, false);
            }
        }
        if left.structure > 0.0 {
            let words = format!(
                "{:.0} % of the residual variance is not noise, and no candidate explains it significantly",
                100.0 * left.structure
            );
            // First: it is the verdict, and the predicted error follows from it.
            reasons.insert(0, Reason::new("unexplained-variance", words));
            return (Verdict::Unexplained, reasons, false);
        }
        if !self.explanation.fitted.converged {
            reasons.push(Reason::new("no-convergence", "The fit with all effects found did not converge"));
            return (Verdict::Unexplained, reasons, false);
        }
        if !self.explanation.confounded.is_empty() {
            for group in &self.explanation.confounded {
                reasons.push(Reason::new(
                    "confounded",
                    format!("{} explain the error equally well", group.ids.join(", ")),
                ));
            }
            return (Verdict::Confounded, reasons, false);
        }
        // Where `fit` would send the log back nothing reassures: noise so slow may as well be an error that moves.
        match (refused, self.explanation.fitted.terms.is_empty()) {
            (None, _) => {}
            (Some(_), true) => return (Verdict::Undetermined, reasons, false),
            (Some(_), false) => return (Verdict::Unexplained, reasons, true),
        }
        if self.explanation.fitted.terms.is_empty() {
            (Verdict::Complete, reasons, false)
        } else {
            (Verdict::Missing, reasons, false)
        }
    }

    /// The predicted error of a calibration from this log, as a share of the field, where `fit` refuses it: by its noise and
    /// effects, or by what held-out time shows.
    pub(crate) fn refused_by_fit(
        &self,
        applied: &Applied,
        predicted: Option<f64>,
        field: f64,
    ) -> Option<f64> {
        if self.lower_order.is_some() {
            return None;
        }
        let fitted = &self.explanation.fitted;
        let held_out =
            held_out_rms(fitted).map_or(0.0, |held| applied.share * error_beyond(held, fitted.rms()) / field);
        predicted.map(|error| error.max(held_out)).filter(|error| *error > MAX_PREDICTED_ERROR)
    }

    pub(crate) fn heading(&self, dip: &Option<DipStudy>) -> Result<Option<Heading>, BadShape> {
        let Some(reference) = self.table.heading_deg else { return Ok(None) };
        let base = &self.explanation.base;
        let triangular =
            Model::new(base.model.offset_ut, base.model.matrix, base.model.field_ut, start::NO_ROTATION, 0.0);
        let fitted = &self.explanation.fitted;
        let mut terms = fitted.terms.clone();
        if !terms.iter().any(|term| !term.hidden_delay().is_empty()) {
            terms.extend(dip.as_ref().and_then(|dip| dip.lag.clone()));
        }
        let before = triangular.and_then(|model| heading_error(self.samples, &model, &[], reference));
        let after = heading_error(self.samples, &fitted.model, &terms, reference);
        Ok(before.zip(after).map(|(rms_deg_before, rms_deg_after)| Heading { rms_deg_before, rms_deg_after }))
    }

    pub(crate) fn shows(&self) -> Result<Vec<Where>, BadShape> {
        let base = &self.explanation.base;
        let residuals = self.design.residuals(&base.model, &[])?;
        Ok(shows(self.samples, &residuals, &self.explanation, &base.model))
    }
}
