//! What the odds say of a log.

use crate::base::ground::Ground;
use crate::evidence::bounds::{MAX_BLOCKS, MAX_COLOURED_UT, MIN_ODDS, MOST_TONES, UNCLEAR_ODDS};
use crate::evidence::candidates::Catalogue;
use crate::evidence::design::Blocks;
use crate::evidence::dip::{Dip, Lateness};
use crate::evidence::error::{corrected, predicted_error_ut};
use crate::evidence::fast_tones::{fast_tone, without_tone};
use crate::evidence::fit::{Fit, Setting, starts};
use crate::evidence::gaps::without_gaps;
use crate::evidence::hidden::HiddenCause;
use crate::evidence::log::Log;
use crate::evidence::search::{Found, Rival, Search};
use crate::outcome::outcome::Verdict;
use crate::outcome::request::Options;
use crate::samples::samples::Samples;
use crate::table::Table;
use nalgebra::{Matrix3, Vector3};

/// The answer to a log.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// The verdict.
    pub verdict: Verdict,
    /// Ids of the terms, in the order in which they were found.
    pub named: Vec<String>,
    /// Ids of terms that the log cannot tell apart from those.
    pub confounded: Vec<String>,
    /// Rms of the residual without terms and with them, µT.
    pub rms_ut: [f64; 2],
    /// White noise of the sensor, σ per axis, µT.
    pub noise_ut: f64,
    /// Wander that is left: σ per axis, µT, and its time constant, s.
    pub wander: (f64, f64),
    /// The cause behind that wander, where it has a single one.
    pub hidden: Option<HiddenCause>,
    /// Predicted 1σ of a corrected vector in the worst direction, rotation and scale apart, µT.
    pub predicted_error_ut: f64,
    /// Delay of the sensor, where the dip shows one.
    pub lateness: Option<Lateness>,
    /// Corrected vectors, µT, of these rows of the log.
    pub corrected: Vec<(usize, [f64; 3])>,
    /// Offset, µT, and matrix.
    pub calibration: Option<([f64; 3], [[f64; 3]; 3])>,
}

impl Evidence {
    fn undetermined() -> Evidence {
        Evidence {
            verdict: Verdict::Undetermined,
            named: Vec::new(),
            confounded: Vec::new(),
            rms_ut: [f64::NAN; 2],
            noise_ut: f64::NAN,
            wander: (f64::NAN, f64::NAN),
            hidden: None,
            predicted_error_ut: f64::NAN,
            lateness: None,
            corrected: Vec::new(),
            calibration: None,
        }
    }
}

/// Judges a log.
pub fn judge(table: &Table, options: &Options, trace: bool) -> Evidence {
    let mut ground = Ground::of(table, options.method, options.scale_ut(), options.dip_deg);
    crate::fit::diagnosed::leave_out(&mut ground, options);
    if ground.counted.rests || ground.counted.axes != [true; 3] {
        return Evidence::undetermined();
    }
    of_ground(&ground, options, trace).unwrap_or_else(Evidence::undetermined)
}

fn of_ground(ground: &Ground, options: &Options, trace: bool) -> Option<Evidence> {
    let whole = &ground.counted.samples;
    let mut samples = without_gaps(whole, ground.counted.table).unwrap_or_else(|| whole.clone());
    let mut tones: Vec<String> = Vec::new();
    let (mut first_rms, mut rounds) = (None, 0);
    loop {
        match round(ground, options, &samples, (&tones, rounds < MOST_TONES), first_rms, trace)? {
            Round::Tone { rest, id, first_rms: rms } => {
                samples = rest;
                first_rms = Some(rms);
                if !tones.contains(&id) {
                    tones.push(id);
                }
                rounds += 1;
            }
            Round::Answer(answer) => return Some(*answer),
        }
    }
}

/// What one search ends with.
// One at a time, on the stack: the size does not matter.
#[allow(clippy::large_enum_variant)]
enum Round {
    /// A fast tone, the samples without it, and the rms of the log before.
    Tone { rest: Samples, id: String, first_rms: f64 },
    /// The answer.
    Answer(Box<Evidence>),
}

fn round(
    ground: &Ground,
    options: &Options,
    samples: &Samples,
    (tones, looks_again): (&[String], bool),
    first_rms: Option<f64>,
    trace: bool,
) -> Option<Round> {
    let log = Log::new(samples, ground.counted.table);
    let catalogue = Catalogue::new(&log, options.registry);
    let (base, setting) = base_of(ground, &log, catalogue.count, trace)?;
    let first_rms = first_rms.unwrap_or(base.rms());
    if looks_again && let Some(term) = fast_tone(&log, options.registry, &setting, &base) {
        let rest = without_tone(samples, &term, &base);
        return Some(Round::Tone { rest, id: term.id, first_rms });
    }
    // Which terms there are is decided by a sample of each block: a term that matters shows in those as well.
    let few = thinned(samples, ground.counted.table);
    let few_log = few.as_ref().map(|few| Log::new(few, ground.counted.table));
    let few_catalogue = few_log.as_ref().map(|log| Catalogue::new(log, options.registry));
    let (searched, catalogue, setting, begin) = match (&few_log, &few_catalogue) {
        (Some(few), Some(catalogue)) => {
            let blocks = Blocks::at_most(few.len(), MAX_BLOCKS);
            let setting = Setting { blocks, ..setting };
            let fit = Fit::of(few, &setting, base.model.rebound(few)?, None)?;
            (few, catalogue, setting, fit)
        }
        _ => (&log, &catalogue, setting, base),
    };
    let search = Search { log: searched, catalogue, setting, trace };
    let mut found = search.run(begin);
    let cause = search.against_hidden_cause(&mut found);
    if trace {
        eprintln!("hidden cause: {cause:?}");
    }
    let setting = Setting { blocks: Blocks::at_most(log.len(), MAX_BLOCKS), ..setting };
    let Found { fit, rivals, .. } = found;
    let fit = match few_log {
        Some(_) => Fit::of(&log, &setting, fit.model.rebound(&log)?, None)?,
        None => fit,
    };
    // Next to a stronger effect a tone is less than its share at first.
    if !fit.model.terms.is_empty()
        && looks_again
        && let Some(term) = fast_tone(&log, options.registry, &setting, &fit)
    {
        let rest = without_tone(samples, &term, &fit);
        return Some(Round::Tone { rest, id: term.id, first_rms });
    }
    answer(&log, &setting, (&fit, &rivals), cause, tones, first_rms, trace)
        .map(|answer| Round::Answer(Box::new(answer)))
}

/// One sample of each block of a long log, at uneven places: a tone cannot pass for a slower one. `None` where the log is short.
fn thinned(samples: &Samples, table: &Table) -> Option<Samples> {
    let size = Blocks::at_most(samples.len(), MAX_BLOCKS).size;
    if size < 2 {
        return None;
    }
    let places: Vec<usize> = (0..samples.len() / size)
        .map(|block| {
            block * size + ((block as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as usize % size
        })
        .collect();
    let mut few = samples.of_these(table, places.iter().map(|&place| samples.row[place]).collect());
    // What was taken out of the readings stays out.
    for (reading, place) in few.readings.iter_mut().zip(places) {
        reading.measured_ut = samples.readings[place].measured_ut;
    }
    Some(few)
}

/// The likeliest fit without terms, with how it was made.
fn base_of<'a>(ground: &Ground, log: &Log<'a>, candidates: f64, trace: bool) -> Option<(Fit<'a>, Setting)> {
    let blocks = Blocks::at_most(log.len(), MAX_BLOCKS);
    let mut bases = Vec::new();
    for (model, scale) in starts(ground, log) {
        let setting = Setting { blocks, scale, candidates: candidates.max(1.0), is_white: false };
        let fit = Fit::of(log, &setting, model, None);
        if trace {
            eprintln!(
                "start: score {:?}, rms {:?}, scale {scale}, b {:?}",
                fit.as_ref().map(|fit| fit.score),
                fit.as_ref().map(Fit::rms),
                fit.as_ref().map(|f| f.model.offset)
            );
        }
        bases.extend(fit.map(|fit| (fit, setting)));
    }
    bases.into_iter().min_by(|a, b| a.0.score.total_cmp(&b.0.score))
}

fn answer(
    log: &Log,
    setting: &Setting,
    (fit, rivals): (&Fit, &[Vec<Rival>]),
    cause: Option<HiddenCause>,
    tones: &[String],
    first_rms: f64,
    trace: bool,
) -> Option<Evidence> {
    let (mut named, mut confounded) = (tones.to_vec(), Vec::new());
    for (term, rivals) in fit.model.terms.iter().zip(rivals) {
        let unclear: Vec<&Rival> =
            rivals.iter().filter(|rival| !rival.is_variant && rival.odds < UNCLEAR_ODDS).collect();
        if unclear.is_empty() {
            // Two tones are one name.
            if !named.contains(&term.id) {
                named.push(term.id.clone());
            }
        } else {
            confounded.push(term.id.clone());
            confounded.extend(unclear.iter().map(|rival| rival.id.clone()));
        }
    }
    let dip = Dip::of(log, setting, fit).and_then(|dip| dip.lateness());
    if trace {
        eprintln!("dip: {dip:?}");
    }
    let late = dip.filter(Lateness::is_shown);
    if late.is_some() && !named.iter().any(|id| id == "lag") {
        named.push("lag".into());
    }
    let late_error_ut = late.map_or(0.0, |late| late.error_s * rms_turn_radps(log) * fit.model.field);
    let mut corrected = corrected(fit);
    if let Some(late) = late {
        on_time(log, &mut corrected, late.delay_s);
    }
    let wander = fit.noise.wander_ut();
    let noise_ut = fit.noise.variance.sqrt();
    let is_hidden = cause.as_ref().is_some_and(|cause| cause.gain > MIN_ODDS);
    let coloured_ut = (fit.rms().powi(2) - noise_ut * noise_ut).max(0.0).sqrt();
    let is_hidden = is_hidden || coloured_ut > MAX_COLOURED_UT;
    let verdict = match (confounded.is_empty(), named.is_empty()) {
        _ if is_hidden => Verdict::Unexplained,
        (false, _) => Verdict::Confounded,
        (true, true) => Verdict::Complete,
        (true, false) => Verdict::Missing,
    };
    Some(Evidence {
        verdict,
        named,
        confounded,
        rms_ut: [first_rms, fit.rms()],
        noise_ut,
        wander,
        hidden: cause.filter(|_| is_hidden),
        predicted_error_ut: predicted_error_ut(&fit.model, &fit.covariance()?)?.hypot(late_error_ut),
        lateness: dip,
        corrected: log.samples.row.iter().copied().zip(corrected).collect(),
        calibration: Some((fit.model.offset.into(), matrix_rows(&fit.model.matrix))),
    })
}

/// Rms rate of turn, rad/s.
fn rms_turn_radps(log: &Log) -> f64 {
    let turns = log.samples.readings.iter().filter_map(|reading| reading.turn_radps);
    let (sum, count) =
        turns.fold((0.0, 0.0), |(sum, count), turn| (sum + Vector3::from(turn).norm_squared(), count + 1.0));
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}

/// Turns the vectors of a sensor that is late by `delay_s` to where they are now: in the axes of a board that turns by ω the field changes
/// by −ω×h.
fn on_time(log: &Log, vectors: &mut [[f64; 3]], delay_s: f64) {
    for (h, reading) in vectors.iter_mut().zip(&log.samples.readings) {
        if let Some(turn) = reading.turn_radps {
            let vector = Vector3::from(*h);
            *h = (vector - Vector3::from(turn).cross(&vector) * delay_s).into();
        }
    }
}

fn matrix_rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| matrix[(i, j)]))
}
