//! The whole diagnosis of one log.

use crate::base::counted::Counted;
use crate::base::engine::Design;
use crate::base::ground::Ground;
use crate::base::level::tilt_deg;
use crate::base::model::Base;
use crate::base::prior::Prior;
use crate::base::start;
use crate::bounds::{AS_WELL, FEWEST_SAMPLES, LEVEL_DEG};
use crate::calibration::{EffectEntry, FittedEffect};
use crate::correct::Corrector;
use crate::effects::calibrated;
use crate::outcome::at_rest::at_rest;
use crate::outcome::axes_status;
use crate::outcome::blank::undetermined;
use crate::outcome::explain::explain;
use crate::outcome::lower_order::as_logged;
use crate::outcome::outcome::{Diagnosis, Status, Verdict};
use crate::outcome::request::{Options, Refusal};
use crate::outcome::transients;
use crate::outcome::view::View;
use crate::reason::Reason;
use crate::samples::faults;
use crate::samples::samples::Samples;
use crate::search::candidates::Catalogue;
use crate::table::Table;
use crate::unlogged::levels::{Levels, levels};
use crate::unlogged::switching::{Switching, switching};
use ironout::fit::MAX_PREDICTED_ERROR;
use ironout::study::{Model, Residual};
use std::borrow::Cow;

/// The diagnosis of a log whose samples are sorted out, with `with_room` to work in.
pub fn study(ground: &Ground, options: &Options) -> Result<Diagnosis, Refusal> {
    let counted = &ground.counted;
    let mut diagnosis = of_kind(ground, options)?;
    if diagnosis.steps.iter().any(|step| !step.rms_ut.is_finite()) {
        let why = Reason::new(
            "not-finite",
            "the readings are too large to compute with. Is this the magnetometer?",
        );
        diagnosis = undetermined(counted.table, &counted.samples, options.registry, why);
    }
    // What the study has left out is told after the faults of the sensor.
    let left_out = std::mem::take(&mut diagnosis.data_faults);
    diagnosis.data_faults.clone_from(&counted.faults);
    diagnosis.samples_used = counted.studied();
    diagnosis.samples_set_aside = counted.set_aside();
    let beside = transients::samples(&left_out);
    diagnosis.samples_used -= beside.min(diagnosis.samples_used);
    diagnosis.samples_set_aside += beside;
    diagnosis.data_faults.extend(left_out);
    if beside > 0 {
        faults::merge_bursts(&mut diagnosis.data_faults);
    }
    diagnosis.base = ground.base.as_ref().ok().filter(|_| !counted.rests && options.prior.is_none()).cloned();
    diagnosis.switching = switches(counted, &diagnosis);
    if diagnosis.switching.is_none() {
        diagnosis.levels = jumps(counted, &diagnosis);
    }
    Ok(diagnosis)
}

/// An offset that switches with no column behind it, in what is left.
fn switches(counted: &Counted, diagnosis: &Diagnosis) -> Option<Switching> {
    if diagnosis.verdict != Verdict::Unexplained || counted.rests {
        return None;
    }
    let base = diagnosis.calibration?;
    let (times_s, corrected) = corrected_by(counted, diagnosis, &diagnosis.effects)?;
    switching(&times_s, &corrected, &base.matrix, base.field_ut)
}

/// An offset with more jumps than steps were named.
fn jumps(counted: &Counted, diagnosis: &Diagnosis) -> Option<Levels> {
    if diagnosis.verdict != Verdict::Unexplained || counted.rests {
        return None;
    }
    let base = diagnosis.calibration?;
    let is_step = |effect: &&FittedEffect| effect.id.split('#').next() == Some("step");
    let (steps, others): (Vec<&FittedEffect>, Vec<&FittedEffect>) =
        diagnosis.effects.iter().partition(is_step);
    let others: Vec<FittedEffect> = others.into_iter().cloned().collect();
    let (times_s, corrected) = corrected_by(counted, diagnosis, &others)?;
    levels(&times_s, &corrected, &base.matrix, base.field_ut, steps.len())
}

/// Times and vectors corrected by the calibration with these effects.
fn corrected_by(
    counted: &Counted,
    diagnosis: &Diagnosis,
    effects: &[FittedEffect],
) -> Option<(Vec<f64>, Vec<[f64; 3]>)> {
    let time_s = counted.table.time_s?;
    let entries: Vec<EffectEntry> = effects.iter().map(EffectEntry::from).collect();
    let whole = calibrated(diagnosis.calibration?, &entries, diagnosis.registry).ok()?;
    let corrector = Corrector::new(whole, counted.table).ok()?;
    // What stands out may be the one of two values that is rare.
    let samples = counted.with_bursts.as_ref().unwrap_or(&counted.samples);
    let corrected = |row: &usize| Some((time_s[*row], corrector.correct(*row).ok()?));
    Some(samples.row.iter().filter_map(corrected).unzip())
}

fn of_kind(ground: &Ground, options: &Options) -> Result<Diagnosis, Refusal> {
    let Counted { table, samples, .. } = &ground.counted;
    let asked = |name: &str| {
        let parsed = options.add.iter().filter_map(|id| options.registry.parse(id));
        parsed.into_iter().any(|named| named.form.column && named.columns().any(|column| column == name))
    };
    match samples.with_all_known(table, |name| options.search || asked(name)) {
        Some((common, lacking)) => {
            let mut diagnosis = of_samples(ground, &common, options)?;
            diagnosis.data_faults.extend(lacking);
            Ok(diagnosis)
        }
        None => of_samples(ground, samples, options),
    }
}

/// The diagnosis of these samples, without those of magnets that passed beside what was found.
fn of_samples(ground: &Ground, samples: &Samples, options: &Options) -> Result<Diagnosis, Refusal> {
    let table = ground.counted.table;
    let mut diagnosis = of_all(ground, samples, options)?;
    let mut now = Cow::Borrowed(samples);
    for _ in 0..transients::ROUNDS {
        let Some((fewer, faults)) = transients::without(table, &now, &diagnosis, &options.add) else { break };
        let known = known(options);
        let Some(mut next) = on(table, &fewer, &known, options, None)? else { break };
        if !transients::says_more(&next, &diagnosis) {
            break;
        }
        next.data_faults = diagnosis.data_faults.into_iter().chain(faults).collect();
        (diagnosis, now) = (next, Cow::Owned(fewer));
    }
    Ok(diagnosis)
}

/// What is known besides a log.
fn known(options: &Options) -> Prior {
    Prior { earlier: options.prior.as_ref().map(|prior| prior.earlier(options.field_ut)), ..Prior::default() }
}

/// The study of the magnitude of these samples; `None` where no sphere fits them.
fn on(
    table: &Table,
    samples: &Samples,
    known: &Prior,
    options: &Options,
    base: Option<&Base>,
) -> Result<Option<Diagnosis>, Refusal> {
    let at_conditions = options.prior.as_ref().map(|prior| samples.known_at(&prior.conditions));
    let samples = at_conditions.as_ref().unwrap_or(samples);
    let Some(model) = begin(samples, options) else { return Ok(None) };
    magnitude(table, samples, model, known, options, base).map(Some)
}

fn of_all(ground: &Ground, samples: &Samples, options: &Options) -> Result<Diagnosis, Refusal> {
    let table = ground.counted.table;
    if samples.len() < FEWEST_SAMPLES {
        let few = samples.len();
        let why = match ground.counted.at_rest {
            0 if table.rows() >= 2 * FEWEST_SAMPLES && few < table.rows() / 10 => format!(
                "only {few} of {} rows contain a new magnetometer reading. The sensor is stuck, its bus hangs, or its \
                 driver rarely reads it",
                table.rows()
            ),
            0 => format!("the log has {few} different samples; at least {FEWEST_SAMPLES} are necessary"),
            rest => format!(
                "The sensor hardly moved ({few} samples of motion, {rest} at rest). Record again while rotating \
                 it"
            ),
        };
        let mut diagnosis =
            undetermined(table, samples, options.registry, Reason::new("too-few-samples", why));
        // What so few samples seem to say of a column is not so.
        for row in &mut diagnosis.candidates {
            row.why = format!("the log has only {few} samples");
        }
        return Ok(diagnosis);
    }
    if ground.counted.rests {
        return at_rest(table, samples, options);
    }
    if ground.counted.axes != [true; 3] {
        let why = Reason::new(
            "copied-axis",
            "one axis is a copy of another, so no ellipsoid fits. Fix: correct the driver",
        );
        return Ok(undetermined(table, samples, options.registry, why));
    }
    let none_fits = || {
        let why = match options.prior {
            Some(_) => Reason::new("prior-mismatch", "the earlier calibration does not match this field"),
            None => Reason::new("no-ellipsoid", "no sphere or ellipsoid fits the samples"),
        };
        undetermined(table, samples, options.registry, why)
    };
    if options.prior.is_none()
        && let Some(tilt_deg) = tilt_deg(samples, table).filter(|tilt| *tilt < LEVEL_DEG)
    {
        let Some(model) = begin(samples, options) else { return Ok(none_fits()) };
        return level(table, samples, model, options, ground.base.as_ref().ok(), tilt_deg);
    }
    let known = known(options);
    // On top of an earlier calibration the base is fitted with it, which sums alone cannot.
    let base = ground.base.as_ref().ok().filter(|_| options.prior.is_none());
    let Some(mut diagnosis) = on(table, samples, &known, options, base)? else { return Ok(none_fits()) };
    if (diagnosis.verdict == Verdict::Undetermined || !diagnosis.has_attitude) && options.prior.is_none() {
        // Only where the attitude is at fault: full attitude with a large residual is something else.
        let field = diagnosis.calibration.map_or(f64::NAN, |calibration| calibration.field_ut);
        let open = diagnosis.predicted_error_ut.is_none_or(|error| error > MAX_PREDICTED_ERROR * field);
        let calibrated = if open { as_logged(table, samples, options)? } else { None };
        let tells = |lower: &Diagnosis| is_told(lower, options) && tells_more(lower, &diagnosis);
        if let Some(lower) = calibrated.filter(tells) {
            diagnosis = lower;
        } else if diagnosis.verdict == Verdict::Undetermined {
            accuse_nobody(&mut diagnosis, base);
        }
    }
    Ok(diagnosis)
}

/// Whether what is found with a sensor that is taken as calibrated before is told: what leaves most of the error unexplained accuses
/// somebody on no ground, since the attitude is in it, and is not known. A fit accuses nobody.
fn is_told(lower: &Diagnosis, options: &Options) -> bool {
    !options.search || matches!(lower.verdict, Verdict::Missing | Verdict::Confounded)
}

/// Whether a sensor that is taken as calibrated before explains a log as well as one with an offset and a matrix of its own.
fn tells_more(calibrated: &Diagnosis, free: &Diagnosis) -> bool {
    let left = |one: &Diagnosis| one.steps.last().map_or(f64::INFINITY, |step| step.rms_ut);
    left(calibrated) < AS_WELL * left(free)
}

/// The model that a study begins with: an earlier calibration, or what these samples say.
fn begin(samples: &Samples, options: &Options) -> Option<Model<f64>> {
    match &options.prior {
        Some(prior) => prior.model(options.field_ut),
        None => start::start(samples, options.scale_ut()).map(|(model, _)| model),
    }
}

/// The diagnosis of a log in which the board hardly tilted: what the readings spread by is then no attitude, whatever fits.
fn level(
    table: &Table,
    samples: &Samples,
    model: Model<f64>,
    options: &Options,
    base: Option<&Base>,
    tilt_deg: f64,
) -> Result<Diagnosis, Refusal> {
    let reason = Reason::new(
        "tilted-too-little",
        format!(
            "The sensor was tilted by only {tilt_deg:.0}° (rms), so offset and matrix cannot be found. Record again with large \
         tilts, or use --prior CAL.json. For a vehicle, ironout fit tries to calibrate for the tilts in the log"
        ),
    );
    if let Some(mut lower) = as_logged(table, samples, options)?.filter(|lower| is_told(lower, options)) {
        lower.reasons.insert(0, reason);
        return Ok(lower);
    }
    let base_only = Options { search: false, add: Vec::new(), ..options.clone() };
    let mut diagnosis = magnitude(table, samples, model, &Prior::default(), &base_only, base)?;
    diagnosis.verdict = Verdict::Undetermined;
    // The tilt says it already, with the same remedy.
    diagnosis.reasons.retain(|other| other.code != "too-few-orientations");
    diagnosis.reasons.insert(0, reason);
    accuse_nobody(&mut diagnosis, base);
    Ok(diagnosis)
}

/// Where the base is not determined nothing that stands on it may be claimed: what is left is the base as `fit` gives it.
fn accuse_nobody(diagnosis: &mut Diagnosis, base: Option<&Base>) {
    diagnosis.steps.truncate(1);
    diagnosis.effects.clear();
    diagnosis.order_status = None;
    if let Some(base) = base {
        axes_status::first_row(diagnosis, base, true);
    }
    for row in diagnosis.candidates.iter_mut().filter(|row| row.status != Status::Untestable) {
        row.status = Status::Untestable;
        row.why = "not tested: the data do not support a calibration".into();
        row.p_value = None;
        row.holdout_rms_ut = None;
        row.confounded_with.clear();
    }
}

fn magnitude(
    table: &Table,
    samples: &Samples,
    model: Model<f64>,
    known: &Prior,
    options: &Options,
    base: Option<&Base>,
) -> Result<Diagnosis, Refusal> {
    let catalogue = Catalogue::new(samples, table, options.registry);
    let design = Design::new(samples, Residual::Magnitude);
    let (explanation, pure_lag) = match explain(design, &catalogue, model, known, options, base)? {
        Ok(explained) => explained,
        Err(why) => {
            let why = Reason::new("no-convergence", why);
            return Ok(undetermined(table, samples, options.registry, why));
        }
    };
    let (dip_deg, searches) = (options.dip_deg, options.search);
    View {
        table,
        samples,
        catalogue: &catalogue,
        design,
        known,
        explanation,
        lower_order: None,
        base,
        dip_deg,
        searches,
    }
    .finish(pure_lag)
}
