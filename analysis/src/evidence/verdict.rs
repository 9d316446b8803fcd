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
use crate::table::Table;
use nalgebra::Matrix3;

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
    let without = without_gaps(whole, ground.counted.table);
    let mut samples = without.unwrap_or_else(|| whole.clone());
    let mut tones: Vec<String> = Vec::new();
    let mut first_rms = None;
    loop {
        let log = Log::new(&samples, ground.counted.table);
        let catalogue = Catalogue::new(&log, options.registry);
        let (base, setting) = base_of(ground, &log, catalogue.count, trace)?;
        let first_rms = *first_rms.get_or_insert(base.rms());
        let tone = |fit: &Fit| {
            let again = tones.len() < MOST_TONES;
            let term = again.then(|| fast_tone(&log, options.registry, &setting, fit)).flatten()?;
            Some((without_tone(&samples, &term, fit), term.id))
        };
        if let Some((rest, id)) = tone(&base) {
            drop((base, catalogue));
            samples = rest;
            tones.push(id);
            continue;
        }
        let search = Search { log: &log, catalogue: &catalogue, setting, trace };
        let mut found = search.run(base);
        // Next to a stronger effect a tone is less than its share at first.
        if !found.fit.model.terms.is_empty()
            && let Some((rest, id)) = tone(&found.fit)
        {
            drop((found, catalogue));
            samples = rest;
            tones.push(id);
            continue;
        }
        let cause = search.against_hidden_cause(&mut found);
        if trace {
            eprintln!("hidden cause: {cause:?}");
        }
        return answer(&log, &setting, found, cause, tones, first_rms, trace);
    }
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
    found: Found,
    cause: Option<HiddenCause>,
    tones: Vec<String>,
    first_rms: f64,
    trace: bool,
) -> Option<Evidence> {
    let (mut named, mut confounded) = (tones, Vec::new());
    for (term, rivals) in found.fit.model.terms.iter().zip(&found.rivals) {
        let unclear: Vec<&Rival> =
            rivals.iter().filter(|rival| !rival.is_variant && rival.odds < UNCLEAR_ODDS).collect();
        if unclear.is_empty() {
            named.push(term.id.clone());
        } else {
            confounded.push(term.id.clone());
            confounded.extend(unclear.iter().map(|rival| rival.id.clone()));
        }
    }
    let dip = Dip::of(log, setting, &found.fit).and_then(|dip| dip.lateness());
    if trace {
        eprintln!("dip: {dip:?}");
    }
    if dip.is_some_and(|dip| dip.is_shown()) && !named.iter().any(|id| id == "lag") {
        named.push("lag".into());
    }
    let wander = found.fit.noise.wander_ut();
    let noise_ut = found.fit.noise.variance.sqrt();
    let is_hidden = cause.as_ref().is_some_and(|cause| cause.gain > MIN_ODDS);
    let coloured_ut = (found.fit.rms().powi(2) - noise_ut * noise_ut).max(0.0).sqrt();
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
        rms_ut: [first_rms, found.fit.rms()],
        noise_ut,
        wander,
        hidden: cause.filter(|_| is_hidden),
        predicted_error_ut: predicted_error_ut(&found.fit.model, &found.fit.covariance()?)?,
        lateness: dip,
        corrected: log.samples.row.iter().copied().zip(corrected(&found.fit)).collect(),
        calibration: Some((found.fit.model.offset.into(), matrix_rows(&found.fit.model.matrix))),
    })
}

fn matrix_rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| matrix[(i, j)]))
}
