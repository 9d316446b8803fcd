//! What the odds say of a log.

use crate::base::ground::Ground;
use crate::evidence::bounds::{MAX_BLOCKS, MIN_ODDS, UNCLEAR_ODDS};
use crate::evidence::candidates::Catalogue;
use crate::evidence::design::Blocks;
use crate::evidence::dip::Dip;
use crate::evidence::fit::{Fit, Setting, starts};
use crate::evidence::gaps::without_gaps;
use crate::evidence::hidden::hidden_cause;
use crate::evidence::log::Log;
use crate::evidence::search::{Rival, Search};
use crate::outcome::outcome::Verdict;
use crate::outcome::request::Options;
use crate::table::Table;

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
    let log = Log::new(without.as_ref().unwrap_or(whole), ground.counted.table);
    let catalogue = Catalogue::new(&log, options.registry);
    let blocks = Blocks::at_most(log.len(), MAX_BLOCKS);
    let candidates = catalogue.count.max(1.0);
    let mut bases = Vec::new();
    for (model, scale) in starts(ground, &log) {
        let setting = Setting { blocks, scale, candidates };
        let fit = Fit::of(&log, &setting, model, None);
        if trace {
            eprintln!("start: score {:?}, rms {:?}, scale {scale}, b {:?}", fit.as_ref().map(|fit| fit.score), fit.as_ref().map(Fit::rms), fit.as_ref().map(|f| f.model.offset));
        }
        bases.extend(fit.map(|fit| (fit, setting)));
    }
    let best = bases.into_iter().min_by(|a, b| a.0.score.total_cmp(&b.0.score));
    let (base, setting) = best?;
    let search = Search { log: &log, catalogue: &catalogue, setting, trace };
    let found = search.run(base);
    let (mut named, mut confounded) = (Vec::new(), Vec::new());
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
    let cause = hidden_cause(&found.fit);
    if trace {
        eprintln!("hidden cause: {cause:?}");
    }
    let dip = Dip::of(&log, &setting, &found.fit).and_then(|dip| dip.lateness());
    if trace {
        eprintln!("dip: {dip:?}");
    }
    if dip.is_some_and(|dip| dip.is_shown()) && !named.iter().any(|id| id == "lag") {
        named.push("lag".into());
    }
    let wander = found.fit.noise.wander_ut();
    let noise_ut = found.fit.noise.variance.sqrt();
    let is_hidden = cause.is_some_and(|cause| cause.gain > MIN_ODDS);
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
        rms_ut: [found.base.rms(), found.fit.rms()],
        noise_ut,
        wander,
    })
}
