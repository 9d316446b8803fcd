//! The candidates and effects of a diagnosis as rows, in words and numbers.

use crate::base::mounting::{self, AXIS_ORDER, MISALIGNMENT, Mounting, OrderStatus};
use crate::base::quality::{covariance, covariance_of};
use crate::base::term::{BadShape, Term};
use crate::bounds::{MIN_SHARE, MISALIGNED_DEG, SWAPPED_DEG};
use crate::calibration::FittedEffect;
use crate::evidence::significance::Test;
use crate::outcome::blank::untestable;
use crate::outcome::outcome::{CandidateRow, Status, Verdict};
use crate::outcome::view::{DipStudy, View};
use crate::search::parameter::in_words;
use crate::search::screen::SIGNIFICANCE;
use ironout::effect::{Follows, Named};
use ironout::study::Residual;

impl View<'_, '_> {
    pub(crate) fn candidates(
        &self,
        dip: &Option<DipStudy>,
        pure_lag: bool,
        order_status: Option<OrderStatus>,
        verdict: Verdict,
    ) -> Vec<CandidateRow> {
        let mut list: Vec<CandidateRow> = Vec::new();
        let corrected = |p: f64| Some((p * self.explanation.count as f64).min(1.0));
        let row_of = |one: &Test, status: Status, partners: Vec<String>, why: String| CandidateRow {
            holdout_rms_ut: one.held_out_rms_ut,
            p_value: corrected(one.p_value),
            confounded_with: partners,
            takes: Some(one.share),
            ..CandidateRow::new(&one.id, one.name, status, Residual::Magnitude, why)
        };
        let untried = |id: &String, status: Status, why: String| {
            let built = self.catalogue.registry.parse(id).and_then(|named| self.catalogue.build(&named, 0.0));
            let name = built.map_or(id.as_str(), |term| term.effect.name());
            CandidateRow::new(id, name, status, Residual::Magnitude, why)
        };
        let group_of = |id: &str| -> Option<Vec<String>> {
            let mut groups = self.explanation.confounded.iter();
            let group = groups.find(|group| group.ids.iter().any(|other| other == id))?;
            Some(group.ids.iter().filter(|other| *other != id).cloned().collect())
        };
        for term in &self.explanation.fitted.terms {
            let tested = self.explanation.first.iter().find(|one| one.id == term.id);
            let partners = group_of(&term.id);
            let status = if partners.is_some() { Status::Confounded } else { Status::Missing };
            let why = match &partners {
                Some(partners) => format!(
                    "{} explains the error equally well. Fix: {}",
                    partners.join(", "),
                    self.separating(&term.id, partners)
                ),
                None if term.searched().is_some() && term.is_in_time() => {
                    format!("a {}: {}", in_words(term), term.effect.explanation())
                }
                None => term.effect.explanation().to_string(),
            };
            // Beside all others: before those are in the model, what they do hides it.
            let chance = self.explanation.chances.iter().find(|(id, _)| *id == term.id);
            let p_value = chance.and_then(|(_, p)| corrected(*p));
            let name = term.effect.name();
            let row = match tested {
                Some(one) => row_of(one, status, Vec::new(), why),
                None => CandidateRow::new(&term.id, name, status, Residual::Magnitude, why),
            };
            list.push(CandidateRow { p_value, confounded_with: partners.unwrap_or_default(), ..row });
        }
        for withdrawn in &self.explanation.withdrawn {
            let judged = self.explanation.first.iter().chain(&self.explanation.last);
            let mut tested = judged.filter(|one| one.id == withdrawn.id);
            list.push(match tested.next() {
                Some(one) => row_of(one, Status::NotNeeded, Vec::new(), withdrawn.why.clone()),
                None => untried(&withdrawn.id, Status::NotNeeded, withdrawn.why.clone()),
            });
        }
        for id in &self.explanation.dropped {
            let why = "its shape is not finite on this log, so it was not tested";
            list.push(untried(id, Status::Untestable, why.into()));
        }
        for one in &self.explanation.last {
            let id = &one.id;
            // A further step or tone that nothing asks for is not worth a row.
            let further = id.contains('#') && one.is_repeated;
            if further || list.iter().any(|row| row.id == *id) {
                continue;
            }
            if one.hides_delay && dip.is_some() {
                continue;
            }
            match group_of(id) {
                Some(partners) => {
                    // What it explains by itself, not beside the one that stands in the model.
                    let alone = self.explanation.first.iter().find(|other| other.id == *id);
                    let one = alone.unwrap_or(one);
                    let why = format!(
                        "{} explains the error equally well. Fix: {}",
                        partners.join(", "),
                        self.separating(id, &partners)
                    );
                    list.push(row_of(one, Status::Confounded, partners, why));
                }
                None => {
                    let why = if verdict == Verdict::Undetermined {
                        "not tested: the data do not support a calibration".to_string()
                    } else if one.p_value * (self.explanation.count as f64) < SIGNIFICANCE {
                        self.not_taken(one)
                    } else {
                        "not significant".to_string()
                    };
                    let status =
                        if verdict == Verdict::Undetermined { Status::Untestable } else { Status::NotNeeded };
                    list.push(row_of(one, status, Vec::new(), why));
                }
            }
        }
        if let Some(dip) = dip {
            let late = self.catalogue.late_sensor();
            if let Some(late) = late.filter(|late| !list.iter().any(|row| row.id == late.id)) {
                let (p, held) = dip.tested.unwrap_or((1.0, None));
                let why = match &dip.lag {
                    Some(term) if pure_lag => format!(
                        "the sensor is delayed by {:.1} ± {:.1} ms: {}",
                        1e3 * term.coefficients[0],
                        1e3 * dip.delay_error_s,
                        term.effect.explanation()
                    ),
                    _ => "significant neither in the magnitude nor in the dip".to_string(),
                };
                let status = if pure_lag { Status::Missing } else { Status::NotNeeded };
                list.push(CandidateRow {
                    holdout_rms_ut: held,
                    p_value: Some((2.0 * p).min(1.0)),
                    ..CandidateRow::new(&late.id, late.effect.name(), status, Residual::Dip, why)
                });
            }
            let angle = dip.alignment.angle_deg;
            let by_gyro = dip.alignment.by_gyro;
            let beside = if by_gyro { "gyro" } else { "accelerometer" };
            let mut of_mounting = |one: Mounting, status: Status, angle_deg: Option<f64>, why: String| {
                let row = CandidateRow::new(one.id, one.name, status, Residual::Dip, why);
                list.push(CandidateRow { angle_deg, ..row });
            };
            // A rotation so large is a matter of the axes' order, told below.
            let status = match angle > MISALIGNED_DEG && angle <= SWAPPED_DEG {
                true => Status::Missing,
                false => Status::NotNeeded,
            };
            let why = format!(
                "the axes of magnetometer and {beside} differ by {angle:.1}° in addition to the triangular matrix"
            );
            of_mounting(MISALIGNMENT, status, Some(angle), why);
            let status = match order_status.and_then(|order_status| order_status.swapped()) {
                Some(_) => Status::Missing,
                None if angle > SWAPPED_DEG => Status::Untestable,
                None => Status::NotNeeded,
            };
            let why = match order_status.map(|order_status| order_status.words()) {
                Some(_) if angle > SWAPPED_DEG => format!(
                    "{} with the axes rotated by {angle:.0}°, but it varies by {:.1}° rms there too, which is too much \
                     to determine their order. Fix: rotate the sensor slowly and without shaking it",
                    if by_gyro { "the gyro agrees best with the field" } else { "the dip is most constant" },
                    dip.after_deg
                ),
                Some(words) if !words.is_empty() => words.join("; "),
                _ => "the axis order is correct".into(),
            };
            of_mounting(AXIS_ORDER, status, None, why);
        }
        if self.lower_order.is_some() && self.catalogue.has_down() {
            for one in mounting::ALL {
                let why = "too few orientations: rotate the sensor through more of them".into();
                list.push(CandidateRow::new(one.id, one.name, Status::Untestable, Residual::Dip, why));
            }
        }
        let more = untestable(self.catalogue);
        let known: Vec<String> = list.iter().map(|row| row.id.clone()).collect();
        list.extend(more.into_iter().filter(|row| !known.contains(&row.id)));
        list
    }

    /// Why what chance hardly does was not added, from what it would take off the squared error.
    fn not_taken(&self, one: &Test) -> String {
        let (takes, percent) = (one.share, 100.0 * one.share);
        if takes < MIN_SHARE {
            return format!(
                "significant, but too small to matter: it explains {percent:.1} % of the remaining variance"
            );
        }
        if !one.falls {
            return format!(
                "it explains {percent:.0} % of the remaining variance, but does not reduce the held-out error"
            );
        }
        format!(
            "it explains {percent:.0} % of the remaining variance, but is not significant by itself: {} may look like it",
            if one.follows == Follows::Attitude { "another cause" } else { "a cause that was not logged" }
        )
    }

    /// Which recording would tell the candidates apart.
    fn separating(&self, id: &str, partners: &[String]) -> String {
        let all = std::iter::once(id).chain(partners.iter().map(String::as_str));
        let all: Vec<Named> = all.filter_map(|id| self.catalogue.registry.parse(id)).collect();
        let timed = all.iter().any(|named| named.family.follows() == Follows::Time);
        let columns: Vec<&str> =
            all.iter().filter(|named| named.form.column).flat_map(Named::columns).collect();
        match (timed, columns.first()) {
            (true, Some(column)) => format!(
                "record a log in which {column} rises and falls again (let it cool down, switch it on and off)"
            ),
            (false, Some(first)) => {
                let other = columns.iter().find(|column| *column != first).unwrap_or(first);
                if other == first {
                    format!("record a log in which {first} changes in many orientations")
                } else {
                    format!("record a log in which {first} and {other} change one at a time")
                }
            }
            (true, None) => "record a longer log: a drift continues, a step does not".into(),
            _ => "record a log with more orientations, and keep the sensor still in some of them".into(),
        }
    }

    pub(crate) fn effects(&self, time: f64, dip: &Option<DipStudy>) -> Result<Vec<FittedEffect>, BadShape> {
        let fitted = &self.explanation.fitted;
        let covariance = match crate::search::parameter::with_slopes(&self.design, fitted)? {
            // A log may tell a tone's numbers and not where between them its frequency lies.
            Some(total) => covariance_of(&total, fitted, time).or_else(|| covariance(fitted, time)),
            None => covariance(fitted, time),
        };
        let delay = dip.as_ref().filter(|dip| dip.lag.is_some()).and_then(|dip| dip.errors.as_ref());
        let mut column = Residual::Magnitude.base_columns();
        let mut list = Vec::new();
        for term in &fitted.terms {
            let mut errors: Vec<f64> = (column..column + term.k())
                .map(|index| covariance.as_ref().map_or(f64::NAN, |rows| rows[index][index].max(0.0).sqrt()))
                .collect();
            let hidden = term.hidden_delay();
            if let (Some(delay), Some(rows)) = (delay, &covariance) {
                // The share that is a pure delay is the dip's, and follows what the magnitude says of the rest.
                for &index in hidden {
                    let variance = delay.delay_variance(rows) + 2.0 * delay.delay_with(rows, column + index);
                    errors[index] = (errors[index].powi(2) + variance).max(0.0).sqrt();
                }
            } else {
                // Without the dip that share is not known at all.
                for &index in hidden {
                    errors[index] = f64::NAN;
                }
            }
            column += term.k();
            list.push(describe(term, errors));
        }
        let is_coupled = fitted.terms.iter().any(|term| !term.hidden_delay().is_empty());
        if !is_coupled && let Some(term) = dip.as_ref().and_then(|dip| dip.lag.as_ref()) {
            list.push(describe(term, vec![dip.as_ref().map_or(f64::NAN, |dip| dip.delay_error_s)]));
        }
        Ok(list)
    }
}

/// An effect with its fitted coefficients, in the words and numbers of the contract.
pub(crate) fn describe(term: &Term, std_errors: Vec<f64>) -> FittedEffect {
    let k = term.k();
    let columns: Vec<String> =
        term.effect.columns().iter().flatten().map(|column| column.name.to_string()).collect();
    let mut reference = Vec::new();
    let mut parameters = Vec::new();
    if let Some(parts) = term.parts() {
        // The column's value, not its square's.
        let of_column = |value: f64| if parts.form.is_squared() { value.max(0.0).sqrt() } else { value };
        let value = parts.reference().map(of_column);
        reference.extend(columns.first().cloned().zip(value));
        parameters.extend(parts.parameter().map(|(searched, value)| (searched.name(), value)));
    }
    let range = columns.iter().enumerate().filter_map(|(slot, column)| {
        let values = || term.inputs.iter().filter_map(|inputs| inputs.get(slot));
        let ends = [values().copied().reduce(f64::min)?, values().copied().reduce(f64::max)?];
        Some((column.clone(), ends))
    });
    FittedEffect {
        id: term.id.clone(),
        range: range.collect(),
        name: term.effect.name().to_string(),
        explanation: term.effect.explanation().to_string(),
        columns,
        coefficients: term.coefficients[..k].to_vec(),
        std_errors,
        unit: term.effect.unit().to_string(),
        reference,
        parameters,
        bends: term.bends,
    }
}
