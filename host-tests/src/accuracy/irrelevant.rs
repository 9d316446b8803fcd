//! Effects that have nothing to do with a log, added to its fit: whether they turn a refused log into an accepted one, and
//! whether what is accepted with them holds on another recording of the same board.

use crate::accuracy::simulated::table_of;
use ironout::calibration::norm;
use ironout::effect::Registry;
use ironout::extended::ExtendedCalibration;
use ironout_analysis::base::solution::Solution;
use ironout_analysis::calibration::EffectEntry;
use ironout_analysis::effects::{Calibrated, from_entry};
use ironout_analysis::{Corrector, Fitted, Options, fit};
use ironout_simulation::paper::Sampler;
use ironout_simulation::{EffectSpec, Log, Motion, World, WorldOptions};

/// One kind of log.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// The hidden effect with its strength; nothing where empty.
    pub hidden: &'static str,
    /// The column of its cause, left out of the log.
    pub without: &'static str,
    /// How the board is turned.
    pub motion: Motion,
    /// Length of the log, s.
    pub seconds: f64,
}

const fn case(hidden: &'static str, without: &'static str, motion: Motion, seconds: f64) -> Case {
    Case { hidden, without, motion, seconds }
}

/// The logs. The plain fit refuses most of them: a strong cause that the log does not hold, or too little attitude.
pub const CASES: [Case; 16] = [
    case("offset:current_a=5", "current_a", Motion::Sphere, 40.0),
    case("offset:current_a=4", "current_a", Motion::Hand, 40.0),
    case("offset:current_a=5", "", Motion::Sphere, 40.0),
    case("offset:temp_c=6", "temp_c", Motion::Sphere, 40.0),
    case("offset:temp_c=4", "temp_c", Motion::Hand, 40.0),
    case("offset:temp_c=6", "", Motion::Sphere, 40.0),
    case("drift=6", "", Motion::Sphere, 40.0),
    case("step=5", "", Motion::Hand, 40.0),
    case("periodic=5", "", Motion::Sphere, 40.0),
    case("eddy=6", "", Motion::Hand, 40.0),
    case("", "", Motion::Cap(0.06), 20.0),
    case("", "", Motion::Planar, 20.0),
    case("", "", Motion::Sphere, 40.0),
    case("", "", Motion::Hand, 20.0),
    case("offset:current_a=3", "current_a", Motion::Cap(0.3), 20.0),
    case("offset:temp_c=3", "temp_c", Motion::Cap(0.3), 20.0),
];

/// Columns that follow nothing: a random walk, a slow wave, a switch, and independent noise.
pub const DECOYS: [&str; 4] = ["walk", "wave", "switch", "hiss"];

/// What is added to every log, beside the hidden effect itself where the log holds its column.
pub const ADDITIONS: [&str; 16] = [
    "offset:walk",
    "offset:walk^2",
    "offset:walk@delay",
    "gain:walk",
    "offset:wave",
    "offset:wave^2",
    "field:wave",
    "offset:switch",
    "gain:switch",
    "offset:hiss^2",
    "drift",
    "step",
    "periodic",
    "lag",
    "nonlinearity",
    "cross-axis",
];

/// What an addition has to do with what a log hides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Nothing.
    Irrelevant,
    /// A shape in time where the cause changes slowly: it stands in for it, and takes off an error that is there.
    StandIn,
    /// It is the hidden effect.
    Own,
}

impl Case {
    fn kind(&self, addition: &str) -> Kind {
        let hidden = self.hidden.split('=').next().unwrap_or_default();
        let slow = ["offset:temp_c", "drift", "step"].contains(&hidden);
        if hidden == addition || (hidden == "eddy" && addition == "lag") {
            Kind::Own
        } else if slow && ["drift", "step"].contains(&addition) {
            Kind::StandIn
        } else {
            Kind::Irrelevant
        }
    }
}

/// A decoy's values; every name and seed a history of its own.
fn decoy(name: &str, seed: u64, rows: usize, rate_hz: f64) -> Vec<f64> {
    let own: u64 = name.bytes().map(u64::from).sum();
    let mut sampler = Sampler::new(seed.wrapping_mul(977).wrapping_add(own));
    let (mut walk, mut on) = (0.0, false);
    let waves: Vec<(f64, f64)> =
        (0..3).map(|_| (sampler.uniform(8.0, 50.0), sampler.uniform(0.0, 6.3))).collect();
    (0..rows)
        .map(|row| {
            let t_s = row as f64 / rate_hz;
            walk += 0.05 * sampler.normal3()[0];
            // A switch is thrown every four seconds on average.
            on ^= sampler.uniform(0.0, 1.0) < 0.25 / rate_hz;
            match name {
                "walk" => walk,
                "wave" => waves
                    .iter()
                    .map(|(period, phase)| (std::f64::consts::TAU * t_s / period + phase).sin())
                    .sum::<f64>(),
                "switch" => f64::from(on),
                _ => sampler.normal3()[1],
            }
        })
        .collect()
}

fn world(case: &Case, seed: u64) -> World {
    let items = Some(case.hidden).filter(|hidden| !hidden.is_empty());
    World::new(WorldOptions {
        seed,
        seconds: case.seconds,
        motion: case.motion,
        effects: items.and_then(|item| EffectSpec::parse(item).ok()).into_iter().collect(),
        drop_columns: Some(case.without)
            .filter(|name| !name.is_empty())
            .map(String::from)
            .into_iter()
            .collect(),
        ..WorldOptions::default()
    })
}

fn with_decoys(mut log: Log, seed: u64, rate_hz: f64) -> Log {
    for name in DECOYS {
        let values = decoy(name, seed, log.rows(), rate_hz);
        log.names.push(name.to_string());
        log.columns.push(values);
    }
    log
}

/// A log of one case, and a second recording of the same board through all attitudes.
pub fn logs(case: &Case, seed: u64) -> (Log, Log) {
    let first = world(case, seed);
    let rate_hz = first.options().rate_hz;
    let second = first.recording(2).run();
    (with_decoys(first.run(), seed, rate_hz), with_decoys(second, seed + 1_000_003, rate_hz))
}

/// What became of one fit.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// Whether it was accepted.
    pub accepted: bool,
    /// Predicted error over the field.
    pub predicted: f64,
    /// Rms residual, µT.
    pub rms_ut: f64,
    /// On held-out blocks of the log, µT.
    pub holdout_ut: f64,
    /// Rms residual on the second recording, µT.
    pub unseen_ut: f64,
    /// Rms error of the corrected vector there, over the field.
    pub error: f64,
}

fn calibration(solution: &Solution) -> Option<Calibrated> {
    let mut calibration = ExtendedCalibration::plain(solution.calibration);
    for effect in &solution.effects {
        let fitted = from_entry(&EffectEntry::from(effect), Registry::BUILT_IN).ok()?;
        calibration.effects.push(fitted).ok()?;
    }
    Some(calibration)
}

fn outcome(fitted: &Fitted, second: &Log) -> Outcome {
    let nothing = f64::INFINITY;
    let mut outcome = Outcome {
        accepted: fitted.accepted,
        predicted: nothing,
        rms_ut: nothing,
        holdout_ut: fitted.holdout_rms_ut.unwrap_or(nothing),
        unseen_ut: nothing,
        error: nothing,
    };
    let Some(solution) = &fitted.solution else { return outcome };
    outcome.predicted = solution.predicted_error_ut / solution.calibration.field_ut;
    outcome.rms_ut = solution.rms_ut;
    let table = table_of(second);
    let Some(corrector) = calibration(solution).and_then(|found| Corrector::new(found, &table).ok()) else {
        return outcome;
    };
    let field_ut = solution.calibration.field_ut;
    let (mut residuals, mut errors, mut rows) = (0.0, 0.0, 0.0);
    for row in 0..second.rows() {
        let Ok(corrected) = corrector.correct(row) else { continue };
        let truth = second.truth.body_field_ut[row];
        residuals += (norm(corrected) - field_ut).powi(2);
        errors += (0..3).map(|axis| (corrected[axis] - truth[axis]).powi(2)).sum::<f64>();
        rows += 1.0;
    }
    outcome.unseen_ut = (residuals / f64::max(rows, 1.0)).sqrt();
    outcome.error = (errors / f64::max(rows, 1.0)).sqrt() / second.truth.field_ut;
    outcome
}

/// One addition to one log.
#[derive(Debug, Clone)]
pub struct Trial {
    /// What was added.
    pub addition: String,
    /// What it has to do with what is hidden.
    pub kind: Kind,
    /// The fit without it.
    pub plain: Outcome,
    /// The fit with it.
    pub with: Outcome,
}

impl Trial {
    /// Whether it was accepted though the plain fit was refused.
    pub fn is_turned(&self) -> bool {
        self.with.accepted && !self.plain.accepted
    }

    /// Whether it was accepted though it is worse on unseen time than no effect.
    pub fn is_worse(&self) -> bool {
        self.with.accepted && self.with.unseen_ut > self.plain.unseen_ut
    }
}

/// Adds each of `additions`, and the hidden effect itself where the log holds its column, to the log of one case and seed.
pub fn trials(case: &Case, seed: u64, additions: &[&str]) -> Vec<Trial> {
    let (first, second) = logs(case, seed);
    let table = table_of(&first);
    let run = |add: Option<&str>| {
        let options = Options {
            field_ut: Some(first.truth.field_ut),
            add: add.map(String::from).into_iter().collect(),
            ..Options::default()
        };
        fit(&table, &options).ok().map(|fitted| outcome(&fitted, &second))
    };
    let Some(plain) = run(None) else { return Vec::new() };
    let hidden =
        first.truth.effects.first().map(|effect| effect.kind.id()).filter(|_| case.without.is_empty());
    let own = hidden.as_deref().filter(|id| !additions.contains(id));
    additions
        .iter()
        .copied()
        .chain(own)
        .filter_map(|addition| {
            let with = run(Some(addition))?;
            Some(Trial { addition: addition.into(), kind: case.kind(addition), plain, with })
        })
        .collect()
}
