//! The candidates and effects of a diagnosis as rows, in words and numbers.

use crate::base::alignment::SWAPPED_DEG;
use crate::base::engine::Fitted;
use crate::base::mounting::{self, AXIS_ORDER, MISALIGNMENT, Standing};
use crate::base::quality::{covariance, covariance_of};
use crate::base::term::{BadShape, Term};
use crate::calibration::FittedEffect;
use crate::outcome::blank::untestable;
use crate::outcome::outcome::{CandidateRow, Status, Verdict};
use crate::outcome::view::{DipStudy, View};
use crate::search::parameter::in_words;
use crate::search::screen::{RELEVANCE, SIGNIFICANCE, WORTH_NAMING};
use crate::search::state::{Confounded, Judged, held_out_rms};
use ironout::effect::{Follows, Named};
use ironout::study::Residual;
use ironout::study::rule::falls;

/// A rotation between the sensors beyond this is worth a word, degrees: soft iron itself may turn the field by less.
const MISALIGNED_DEG: f64 = 4.0;

impl View<'_, '_> {
    pub(crate) fn candidates(
        &self,
        dip: &Option<DipStudy>,
        pure_lag: bool,
        standing: Option<Standing>,
        verdict: Verdict,
    ) -> Vec<CandidateRow> {
        let rows = self.explanation.fitted.rows;
        let mut list: Vec<CandidateRow> = Vec::new();
        let squares = |fitted: &Fitted| fitted.squares.max(f64::MIN_POSITIVE);
        let (base, whole) = (squares(&self.explanation.base), squares(&self.explanation.fitted));
        let row_of = |one: &Judged, status: Status, partners: Vec<String>, why: String| CandidateRow {
            id: one.term.id.clone(),
            name: one.term.effect.name().to_string(),
            status,
            residual: Residual::Magnitude.name(),
            holdout_rms_ut: one.tested.held_out.map(|squares| (squares / rows).sqrt()),
            p_value: Some((one.tested.p_value * self.explanation.count as f64).min(1.0)),
            confounded_with: partners,
            why,
            angle_deg: None,
            takes: Some(
                (one.tested.decrease / if status == Status::NotNeeded { whole } else { base })
                    .clamp(0.0, 1.0),
            ),
        };
        let others_in = |groups: &[Confounded], id: &str| {
            groups
                .iter()
                .find(|group| group.ids.iter().any(|other| other == id))
                .map(|group| group.ids.iter().filter(|other| *other != id).cloned().collect::<Vec<_>>())
        };
        let untried = |id: &String, status: Status, why: String| {
            let built = self.catalogue.registry.parse(id).and_then(|named| self.catalogue.build(&named, 0.0));
            CandidateRow {
                id: id.clone(),
                name: built.map_or_else(|| id.clone(), |term| term.effect.name().to_string()),
                status,
                residual: Residual::Magnitude.name(),
                holdout_rms_ut: None,
                p_value: None,
                confounded_with: Vec::new(),
                why,
                angle_deg: None,
                takes: None,
            }
        };
        let group_of = |id: &str| others_in(&self.explanation.confounded, id);
        for term in &self.explanation.fitted.terms {
            let tested = self.explanation.first.iter().find(|one| one.term.id == term.id);
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
            let p_value = chance.map(|(_, p)| (p * self.explanation.count as f64).min(1.0));
            match tested {
                Some(one) => list
                    .push(CandidateRow { p_value, ..row_of(one, status, partners.unwrap_or_default(), why) }),
                None => list.push(CandidateRow {
                    id: term.id.clone(),
                    name: term.effect.name().to_string(),
                    status,
                    residual: Residual::Magnitude.name(),
                    holdout_rms_ut: None,
                    p_value,
                    confounded_with: partners.unwrap_or_default(),
                    why,
                    angle_deg: None,
                    takes: None,
                }),
            }
        }
        for withdrawn in &self.explanation.withdrawn {
            let judged = self.explanation.first.iter().chain(&self.explanation.last);
            let mut tested = judged.filter(|one| one.term.id == withdrawn.id);
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
            let id = &one.term.id;
            // A further step or tone that nothing asks for is not worth a row.
            let further =
                id.contains('#') && one.term.made.is_some_and(|made| made.parts().form.is_repeated());
            if further || list.iter().any(|row| row.id == *id) {
                continue;
            }
            if !one.term.hidden_delay().is_empty() && dip.is_some() {
                continue;
            }
            match group_of(id) {
                Some(partners) => {
                    // What it explains by itself, not beside the one that stands in the model.
                    let alone = self.explanation.first.iter().find(|other| other.term.id == *id);
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
                    } else if one.tested.p_value * (self.explanation.count as f64) < SIGNIFICANCE {
                        self.not_taken(one, one.tested.decrease / whole)
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
                list.push(CandidateRow {
                    name: late.effect.name().into(),
                    id: late.id,
                    status: if pure_lag { Status::Missing } else { Status::NotNeeded },
                    residual: Residual::Dip.name(),
                    holdout_rms_ut: held,
                    p_value: Some((2.0 * p).min(1.0)),
                    confounded_with: Vec::new(),
                    why,
                    angle_deg: None,
                    takes: None,
                });
            }
            let angle = dip.alignment.angle_deg;
            let by_gyro = dip.alignment.by_gyro;
            let beside = if by_gyro { "gyro" } else { "accelerometer" };
            list.push(CandidateRow {
                id: MISALIGNMENT.id.into(),
                name: MISALIGNMENT.name.into(),
                // A rotation so large is a matter of the axes' order, told below.
                status: if angle > MISALIGNED_DEG && angle <= SWAPPED_DEG {
                    Status::Missing
                } else {
                    Status::NotNeeded
                },
                residual: Residual::Dip.name(),
                holdout_rms_ut: None,
                p_value: None,
                confounded_with: Vec::new(),
                why: format!(
                    "the axes of magnetometer and {beside} differ by {angle:.1}° in addition to the triangular matrix"
                ),
                angle_deg: Some(angle),
                takes: None,
            });
            list.push(CandidateRow {
                id: AXIS_ORDER.id.into(),
                name: AXIS_ORDER.name.into(),
                status: match standing.and_then(|standing| standing.swapped()) {
                    Some(_) => Status::Missing,
                    None if angle > SWAPPED_DEG => Status::Untestable,
                    None => Status::NotNeeded,
                },
                residual: Residual::Dip.name(),
                holdout_rms_ut: None,
                p_value: None,
                confounded_with: Vec::new(),
                why: match standing.map(|standing| standing.words()) {
                    Some(_) if angle > SWAPPED_DEG => format!(
                        "{} with the axes rotated by {angle:.0}°, but it varies by {:.1}° rms there too, which is too much \
                         to determine their order. Fix: rotate the sensor slowly and without shaking it",
                        if by_gyro { "the gyro agrees best with the field" } else { "the dip is most constant" },
                        dip.after_deg
                    ),
                    Some(words) if !words.is_empty() => words.join("; "),
                    _ => "the axis order is correct".into(),
                },
                angle_deg: None,
                takes: None,
            });
        }
        if self.lower_order.is_some() && self.catalogue.has_down() {
            for one in mounting::ALL {
                list.push(CandidateRow {
                    id: one.id.into(),
                    name: one.name.into(),
                    status: Status::Untestable,
                    residual: Residual::Dip.name(),
                    holdout_rms_ut: None,
                    p_value: None,
                    confounded_with: Vec::new(),
                    why: "too few orientations: rotate the sensor through more of them".into(),
                    angle_deg: None,
                    takes: None,
                });
            }
        }
        let more = untestable(self.catalogue);
        let known: Vec<String> = list.iter().map(|row| row.id.clone()).collect();
        list.extend(more.into_iter().filter(|row| !known.contains(&row.id)));
        list
    }

    /// Why what chance hardly does was not added, from what it would take off the squared error.
    fn not_taken(&self, one: &Judged, takes: f64) -> String {
        let percent = 100.0 * takes.clamp(0.0, 1.0);
        if takes < RELEVANCE {
            return format!(
                "significant, but too small to matter: it explains {percent:.1} % of the remaining variance"
            );
        }
        if takes < WORTH_NAMING && self.design.residual == Residual::Magnitude {
            return format!(
                "it explains {percent:.0} % of the remaining variance, less than the {:.0} % needed to name it",
                100.0 * WORTH_NAMING
            );
        }
        let before =
            held_out_rms(&self.explanation.fitted).map(|rms| rms * rms * self.explanation.fitted.rows);
        if !falls(before, one.tested.held_out) {
            return format!(
                "it explains {percent:.0} % of the remaining variance, but does not reduce the held-out error"
            );
        }
        format!(
            "it explains {percent:.0} % of the remaining variance, but is not significant by itself: {} may look like it",
            if one.term.follows(Follows::Attitude) { "another cause" } else { "a cause that was not logged" }
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
    }
}
