//! How well hidden effects are found: a table of effect × strength over simulated logs whose truth is known.
//!
//! `cargo effects-accuracy` runs all seeds and holds the table to its snapshot; `cargo test` runs a few.

use crate::accuracy::simulated::table_of;
use ironout_analysis::outcome::outcome::Verdict;
use ironout_analysis::samples::faults::FaultKind;
use ironout_analysis::{Diagnosis, Options, diagnose};
use ironout_simulation::{EffectSpec, FaultSpec, Log, Motion, Temperature, World, WorldOptions};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// One kind of log.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Hidden effects and faults, separated by commas.
    pub hidden: &'static str,
    /// Noise per axis, µT.
    pub noise_ut: f64,
    /// Its correlation from one sample to the next.
    pub correlation: f64,
    /// A column left out of the log.
    pub without: &'static str,
    /// What else is special.
    pub special: Special,
    /// The verdict that is right.
    pub verdict: Verdict,
}

/// What is special about a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Special {
    /// Nothing.
    None,
    /// The temperature rises steadily.
    Ramp,
    /// Level turns only.
    Planar,
}

/// An effect or two in an ordinary log.
pub const fn effect(hidden: &'static str) -> Case {
    Case {
        hidden,
        noise_ut: 0.25,
        correlation: 0.0,
        without: "",
        special: Special::None,
        verdict: if hidden.is_empty() { Verdict::Complete } else { Verdict::Missing },
    }
}

/// A clean log.
pub const fn clean(noise_ut: f64, correlation: f64) -> Case {
    Case { noise_ut, correlation, ..effect("") }
}

/// A fault of the data alone: nothing is missing from the model.
pub const fn fault(hidden: &'static str) -> Case {
    Case { verdict: Verdict::Complete, ..effect(hidden) }
}

/// An effect whose column was left out.
pub const fn without(hidden: &'static str, column: &'static str) -> Case {
    Case { without: column, verdict: Verdict::Unexplained, ..effect(hidden) }
}

impl Case {
    /// How many logs of this case stand beside `seeds` of the others: a false alarm is rare, and takes more to see.
    pub fn logs(&self, seeds: u64) -> u64 {
        if self.hidden.is_empty() && self.verdict == Verdict::Complete { 10 * seeds } else { seeds }
    }
}

/// All rows of the table.
pub const CASES: [Case; 53] = [
    effect("offset:temp_c=2"),
    effect("offset:temp_c=4"),
    effect("offset:current_a=2"),
    effect("offset:current_a=4"),
    effect("offset:current_a^2=3"),
    effect("offset:current_a@delay=3"),
    effect("gain:temp_c=2"),
    effect("gain:temp_c=4"),
    effect("field:height_m=2"),
    effect("field:height_m=4"),
    effect("drift=2"),
    effect("drift=4"),
    effect("step=2"),
    effect("step=4"),
    effect("lag=2"),
    effect("lag=4"),
    effect("lag=15ms"),
    effect("lag=20ms"),
    effect("eddy=2"),
    effect("eddy=4"),
    effect("nonlinearity=2"),
    effect("nonlinearity=3"),
    effect("nonlinearity=4"),
    effect("cross-axis=2"),
    effect("cross-axis=4"),
    effect("periodic=2"),
    effect("periodic=4"),
    effect("offset:temp_c=3,offset:current_a=3"),
    effect("drift=3,eddy=3"),
    clean(0.05, 0.0),
    clean(0.25, 0.0),
    clean(1.5, 0.0),
    clean(0.25, 0.6),
    clean(0.25, 0.9),
    clean(0.05, 0.9),
    clean(0.25, 0.95),
    clean(1.5, 0.6),
    Case { special: Special::Ramp, verdict: Verdict::Confounded, ..effect("offset:temp_c=3") },
    Case { special: Special::Planar, verdict: Verdict::Undetermined, ..effect("") },
    without("offset:current_a=3", "current_a"),
    without("offset:temp_c=3", "temp_c"),
    fault("burst"),
    fault("clipping"),
    fault("stuck"),
    fault("gap"),
    fault("repeats"),
    fault("bursty-arrival"),
    effect("offset:temp_c=3,burst"),
    effect("offset:temp_c=3,clipping"),
    effect("offset:temp_c=3,stuck"),
    effect("offset:temp_c=3,gap"),
    effect("offset:temp_c=3,repeats"),
    effect("offset:temp_c=3,bursty-arrival"),
];

/// What became of the logs of one kind.
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// Logs.
    pub logs: u32,
    /// The first effect added is one of those hidden.
    pub named_first: u32,
    /// Exactly the hidden effects were added, the faults are reported as what they are, and the verdict is right. Where the
    /// cause is not in the log: nothing was added but `drift`, which blames nobody.
    pub exact: u32,
    /// The verdict is right.
    pub verdict: u32,
    /// Held-out error over the noise floor, the largest.
    pub worst_over_floor: f64,
    /// Coefficients compared, and how many are within one and three standard errors.
    pub coefficients: [u32; 3],
}

/// The faults that a log of this case must be reported with.
fn faults_of(case: &Case) -> Vec<FaultKind> {
    case.hidden
        .split(',')
        .filter_map(|item| match FaultSpec::parse(item).ok()? {
            FaultSpec::Burst => Some(FaultKind::Burst),
            FaultSpec::Clipping => Some(FaultKind::Clipping),
            FaultSpec::Stuck => Some(FaultKind::Stuck),
            FaultSpec::Gap => Some(FaultKind::Gap),
            FaultSpec::CopiedAxis => Some(FaultKind::CopiedAxis),
            // No fault.
            FaultSpec::Repeats | FaultSpec::BurstyArrival => None,
        })
        .collect()
}

/// The log of one case and seed.
pub fn log(case: &Case, seed: u64) -> Log {
    let items = || case.hidden.split(',').filter(|item| !item.is_empty());
    World::new(WorldOptions {
        seed,
        noise_ut: case.noise_ut,
        noise_correlation: case.correlation,
        effects: items().filter_map(|item| EffectSpec::parse(item).ok()).collect(),
        faults: items().filter_map(|item| FaultSpec::parse(item).ok()).collect(),
        drop_columns: case.without.split(',').filter(|name| !name.is_empty()).map(String::from).collect(),
        temperature: if case.special == Special::Ramp { Temperature::Ramp } else { Temperature::WarmUp },
        motion: if case.special == Special::Planar { Motion::Planar } else { Motion::Sphere },
        ..WorldOptions::default()
    })
    .run()
}

fn add(row: &mut Row, case: &Case, log: &Log, diagnosis: &Diagnosis) {
    let mut wanted: Vec<String> = log.truth.effects.iter().map(|effect| effect.kind.id()).collect();
    let mut found: Vec<String> = diagnosis.steps.iter().filter_map(|step| step.added.clone()).collect();
    row.logs += 1;
    row.named_first += u32::from(found.first().is_some_and(|id| wanted.contains(id)));
    wanted.sort();
    found.sort();
    let right = diagnosis.verdict == case.verdict;
    row.verdict += u32::from(right);
    let named = match case.verdict {
        Verdict::Unexplained => found.iter().all(|id| id == "drift"),
        _ => found == wanted,
    };
    let faults_found: Vec<FaultKind> = diagnosis.data_faults.iter().map(|fault| fault.kind).collect();
    let hidden_faults = faults_of(case);
    let faults_named = hidden_faults.iter().all(|kind| faults_found.contains(kind))
        && faults_found.iter().all(|kind| hidden_faults.contains(kind));
    row.exact += u32::from(right && named && faults_named);
    let last = diagnosis.steps.last().and_then(|step| step.holdout_rms_ut);
    if let Some((error, floor)) = last.zip(diagnosis.residual_floor_ut) {
        row.worst_over_floor = row.worst_over_floor.max(error / floor);
    }
    for hidden in &log.truth.effects {
        let id = hidden.kind.id();
        let Some(effect) = diagnosis.effects.iter().find(|effect| effect.id == id) else {
            continue;
        };
        if effect.coefficients.len() != hidden.coefficients().len() {
            continue;
        }
        for ((value, error), truth) in
            effect.coefficients.iter().zip(&effect.std_errors).zip(hidden.coefficients())
        {
            let off = (value - truth).abs() / error;
            row.coefficients[0] += 1;
            row.coefficients[1] += u32::from(off <= 1.0);
            row.coefficients[2] += u32::from(off <= 3.0);
        }
    }
}

/// Runs `seeds` logs of one case on two threads.
pub fn run(case: &Case, seeds: u64) -> Row {
    let next = AtomicU64::new(0);
    let row = Mutex::new(Row::default());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= seeds {
                        return;
                    }
                    let log = log(case, seed);
                    let options = Options { search: true, ..Options::default() };
                    if let Ok(diagnosis) = diagnose(&table_of(&log), &options) {
                        add(&mut row.lock().unwrap_or_else(PoisonError::into_inner), case, &log, &diagnosis);
                    }
                }
            });
        }
    });
    row.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// The heading of [`line()`].
pub const HEADING: &str = "hidden                                noise   rho  without      verdict       logs  first  exact  right  \
                           error/floor  coefficients inside 1 and 3 errors";

/// One line of the table.
pub fn line(case: &Case, row: &Row) -> String {
    let share = |count: u32, of: u32| {
        if of == 0 {
            "    -".to_string()
        } else {
            format!("{:4.0}%", 100.0 * f64::from(count) / f64::from(of))
        }
    };
    let special = match case.special {
        Special::None => "",
        Special::Ramp => " (ramp)",
        Special::Planar => "(level turns)",
    };
    let [all, one, three] = row.coefficients;
    let first =
        if case.verdict == Verdict::Missing { share(row.named_first, row.logs) } else { "    -".into() };
    let exact = match case.verdict {
        Verdict::Missing | Verdict::Complete | Verdict::Unexplained => share(row.exact, row.logs),
        _ => "    -".into(),
    };
    let text = format!(
        "{:<37} {:>5.2} {:>5.2}  {:<12} {:<13} {:>4}  {first}  {exact}  {}  {:>11.3}  {} {} of {all}",
        format!("{}{special}", case.hidden),
        case.noise_ut,
        case.correlation,
        case.without,
        case.verdict.name(),
        row.logs,
        share(row.verdict, row.logs),
        row.worst_over_floor,
        share(one, all),
        share(three, all),
    );
    text.trim_end().to_string()
}
