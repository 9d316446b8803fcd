//! Logs with too few orientations for offset and matrix, of a sensor that was calibrated before.
//!
//! Its own scale and offset then stand, as they were with everything at rest: motors off, no current. So the effects of
//! the columns are zero where the columns rest, not at their means. The data may ask for more: an offset of the base,
//! then gains of its own for each axis, each with the field given by the magnitude that was found, because with little
//! attitude an offset and a field that are both free run away together, to a point or to a plane.

use crate::base::alignment::without_effects;
use crate::base::engine::{Design, Fitted};
use crate::base::prior::Prior;
use crate::base::start;
use crate::base::term::Term;
use crate::bounds::{AS_WELL, CALIBRATED_OFFSET, CALIBRATED_SPREAD, MOVED_GAIN, MOVED_OFFSET, MOVED_SCALE};
use crate::outcome::explain::explain;
use crate::outcome::outcome::{Diagnosis, StepRow, Verdict};
use crate::outcome::request::{Options, Refusal};
use crate::outcome::view::View;
use crate::reason::Reason;
use crate::samples::samples::Samples;
use crate::samples::series::{Autocorrelation, rms};
use crate::search::candidates::Catalogue;
use crate::search::screen::{RELEVANCE, SIGNIFICANCE, test};
use crate::search::state::held_out_rms;
use crate::table::Table;
use ironout::fit::MIN_THICKNESS;
use ironout::quality::MAX_RESIDUAL;
use ironout::study::{Model, PhysicalPrior, Residual, f_tail};

/// What the base may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Order {
    /// The scale.
    Scale,
    /// The offset, with the field given.
    Offset,
    /// Offset and a gain for each axis, with the field given.
    Gains,
}

impl Order {
    fn known(self, memory: f64) -> Prior {
        let held = PhysicalPrior::sphere();
        let (physical, scale) = match self {
            Order::Scale => (PhysicalPrior { offset_fields: CALIBRATED_OFFSET, ..held }, None),
            Order::Offset => (PhysicalPrior { offset_fields: MOVED_OFFSET, ..held }, Some(MOVED_SCALE)),
            Order::Gains => {
                (PhysicalPrior { offset_fields: MOVED_OFFSET, gain: MOVED_GAIN, ..held }, Some(MOVED_SCALE))
            }
        };
        Prior { physical, scale, memory, earlier: None }
    }

    fn words(self) -> String {
        let what = match self {
            Order::Scale => "only its scale is estimated (offset zero within 5 % of the field)",
            Order::Offset => "only an offset is estimated",
            Order::Gains => "only an offset and a gain per axis are estimated",
        };
        format!("assuming the sensor was already calibrated, {what}")
    }

    /// What this moves beyond the one before.
    fn parameters(self) -> f64 {
        match self {
            Order::Scale => 1.0,
            Order::Offset => 3.0,
            Order::Gains => 2.0,
        }
    }
}

/// The diagnosis with a sensor taken as calibrated before. `None` where the log does not look like that, or where it
/// explains nothing.
pub(crate) fn as_logged(
    table: &Table,
    samples: &Samples,
    options: &Options,
) -> Result<Option<Diagnosis>, Refusal> {
    let lengths: Vec<f64> = samples
        .readings
        .iter()
        .map(|reading| reading.measured_ut.iter().map(|value| value * value).sum::<f64>().sqrt())
        .collect();
    let mean = lengths.iter().sum::<f64>() / lengths.len().max(1) as f64;
    let off: Vec<f64> = lengths.iter().map(|length| length - mean).collect();
    if rms(&off) > CALIBRATED_SPREAD * mean {
        return Ok(None);
    }
    let samples = &samples.from_rest();
    let catalogue = Catalogue::new(samples, table, options.registry);
    let design = Design::new(samples, Residual::Magnitude);
    // What the sensor's scale is worth against slow structure, of which so many rows say the same.
    let memory = Autocorrelation::of(&off).time;
    let mut known = Order::Scale.known(memory);
    let field = options.scale_ut().unwrap_or(mean);
    let model = |scale: f64, field: f64| {
        let matrix = start::NO_ROTATION.map(|row| row.map(|value| value * scale));
        Model::new([0.0; 3], matrix, field, start::NO_ROTATION, 0.0)
    };
    let Some(mut start) = model(field / mean, field) else { return Ok(None) };
    if options.scale_ut().is_none() {
        let scale = scale_at_rest(&design, &catalogue, start, &known)?;
        let Some(scaled) = model(1.0, mean / scale) else { return Ok(None) };
        start = scaled;
    }
    let Ok(mut found) = explain(design, &catalogue, start, &known, options, None)? else { return Ok(None) };
    let mut order = Order::Scale;
    for next in [Order::Offset, Order::Gains] {
        let freer = next.known(memory);
        let now = &found.0.fitted;
        let Some(with) = design.fit(now.model, now.terms.clone(), &freer)? else { break };
        let better = asked_for(&design, now, &with, next)?;
        if !better {
            continue;
        }
        let Ok(again) = explain(design, &catalogue, start, &freer, options, None)? else { break };
        (order, known, found) = (next, freer, again);
    }
    let (explanation, pure_lag) = found;
    // Turns in one plane stay undetermined; an effect stretches the cloud of samples, so it is taken out first.
    let clean = without_effects(samples, &explanation.fitted.model, &explanation.fitted.terms);
    if start::thickness(&clean) < f64::from(MIN_THICKNESS) {
        return Ok(None);
    }
    let prior = order.words();
    let view = View {
        table,
        samples,
        catalogue: &catalogue,
        design,
        known: &known,
        explanation,
        lower_order: Some(prior),
        base: None,
        dip_deg: options.dip_deg,
        searches: options.search,
    };
    let mut diagnosis = view.finish(pure_lag)?;
    let error = |step: Option<&StepRow>| step.and_then(|step| step.holdout_rms_ut);
    let falls = error(diagnosis.steps.first())
        .zip(error(diagnosis.steps.last()))
        .is_some_and(|(before, after)| AS_WELL * after < before);
    // A sensor that was calibrated before leaves no such residual: it was not.
    let left_ut = diagnosis.steps.last().map_or(f64::INFINITY, |step| step.rms_ut);
    let calibrated = left_ut <= MAX_RESIDUAL * field;
    if diagnosis.verdict == Verdict::Undetermined || !falls || !calibrated {
        return Ok(None);
    }
    // What was held fixed was not measured: effects only.
    diagnosis.calibration = None;
    diagnosis.information = None;
    diagnosis.predicted_error_ut = None;
    diagnosis.reasons.insert(0, Reason::new("effects-only", "Too few orientations for a calibration. ironout assumes that the sensor was already calibrated, and \
         searched for effects only"));
    Ok(Some(diagnosis))
}

/// The mean magnitude is not the field where an effect stands in it: the scale that the mean magnitude needs once the
/// column that explains most is accounted for. The sensor's own scale is kept, so the field is the magnitude with
/// everything at rest.
fn scale_at_rest<'a>(
    design: &Design<'a>,
    catalogue: &Catalogue<'a>,
    start: Model<f64>,
    known: &Prior,
) -> Result<f64, Refusal> {
    let scale = |fitted: &Fitted| fitted.model.matrix[0][0];
    let Some(base) = design.fit(start, Vec::new(), known)? else { return Ok(1.0) };
    let adds = |term: &Term| term.made.is_some_and(|made| made.family().is_proportional(made.parts()));
    let list = catalogue.offered().filter(|named| named.form.searched.is_none());
    let list: Vec<Term> = list.filter_map(|named| catalogue.build(&named, 0.0)).filter(adds).collect();
    let mut best: Option<(f64, &Term)> = None;
    for term in &list {
        let Some(tested) = test(design, &base, term, list.len())? else { continue };
        let held = tested.held_out.unwrap_or(f64::INFINITY);
        let counts = tested.accepted || tested.decrease > 0.5 * base.squares;
        if counts && best.is_none_or(|(least, _)| held < least) {
            best = Some((held, term));
        }
    }
    let Some((_, best)) = best else { return Ok(scale(&base)) };
    Ok(design.fit(base.model, vec![best.clone()], known)?.as_ref().map_or(1.0, scale))
}

/// Whether the data ask for what the freer base moves: significantly, and on held-out time.
fn asked_for(design: &Design, held: &Fitted, free: &Fitted, order: Order) -> Result<bool, Refusal> {
    let residuals = design.residuals(&free.model, &free.terms.iter().collect::<Vec<_>>())?;
    let effective = free.rows / Autocorrelation::of(&residuals).time;
    let k = order.parameters();
    let freedom = effective - free.columns() as f64 - k;
    if freedom < 1.0 {
        return Ok(false);
    }
    let f = (held.squares - free.squares).max(0.0) / k / (free.squares / freedom).max(f64::MIN_POSITIVE);
    let falls = held_out_rms(held)
        .zip(held_out_rms(free))
        .is_some_and(|(before, after)| after * after < before * before * (1.0 - RELEVANCE));
    Ok(f_tail(f, k, freedom) < SIGNIFICANCE && falls)
}
