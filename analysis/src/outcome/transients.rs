//! Magnets that passed beside an effect: what stands out of the model with what was found is set aside, and the log is studied once
//! more without it.
//!
//! A strong effect hides the flanks of a passing magnet, and a magnet that comes and goes looks like steps. Once the effect is
//! in the model both show.

use crate::bounds::{AS_WELL, MAX_PASSING, PASSED, PASSES_S};
use crate::calibration::FittedEffect;
use crate::outcome::outcome::{Diagnosis, Verdict};
use crate::samples::faults::{self, DataFault, FaultKind};
use crate::samples::samples::Samples;
use crate::table::Table;
use ironout::study::Residual;

/// Studies without what stood out of the one before.
pub(crate) const ROUNDS: usize = 3;

/// Samples that stand out of what a diagnosis found, as first and last place among its samples; empty where nothing does, or where so
/// much does that it is no fault.
fn stand_out(samples: &Samples, diagnosis: &Diagnosis, asked: &[String]) -> Vec<(usize, usize)> {
    // A step that was asked for is one.
    let found = diagnosis.effects.iter().filter(|effect| !asked.contains(&effect.id));
    let mut found = steps_there_and_back(samples, found);
    if let [residuals] = diagnosis.traces.final_ut.as_slice()
        && !diagnosis.effects.is_empty()
        && residuals.len() == samples.len()
    {
        found.extend(faults::bursts(residuals));
    }
    found.sort_unstable();
    let mut merged: Vec<(usize, usize)> = Vec::new();
    for (from, to) in found {
        match merged.last_mut() {
            Some(last) if from <= last.1 + 1 => last.1 = last.1.max(to),
            _ => merged.push((from, to)),
        }
    }
    let flagged: usize = merged.iter().map(|(from, to)| to - from + 1).sum();
    let much = flagged as f64 > MAX_PASSING * samples.len() as f64;
    if much || faults::have_company(samples, &merged) { Vec::new() } else { merged }
}

/// Where steps that undo each other together lie so close that they are a magnet that passed.
fn steps_there_and_back<'e>(
    samples: &Samples,
    effects: impl Iterator<Item = &'e FittedEffect>,
) -> Vec<(usize, usize)> {
    let Some(time) = &samples.time else { return Vec::new() };
    let mut steps: Vec<(f64, [f64; 3])> = effects.filter_map(step).collect();
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut list = Vec::new();
    for (index, (first_s, first)) in steps.iter().enumerate() {
        let (mut left, mut largest) = (*first, length(*first));
        for (last_s, next) in &steps[index + 1..] {
            left = std::array::from_fn(|axis| left[axis] + next[axis]);
            largest = largest.max(length(*next));
            let apart = last_s - first_s;
            if apart <= PASSES_S && length(left) <= PASSED * largest {
                let (from, to) = (first_s - PASSED * apart, last_s + PASSED * apart);
                let (from, to) = (time.partition_point(|t| *t < from), time.partition_point(|t| *t <= to));
                if from < to {
                    list.push((from, to - 1));
                }
            }
        }
    }
    list
}

/// When a step was, and how much it added to the offset.
fn step(effect: &FittedEffect) -> Option<(f64, [f64; 3])> {
    let at_s = effect.parameters.iter().find(|(name, _)| *name == "at_s")?.1;
    let [x, y, z] = *effect.coefficients.first_chunk::<3>()?;
    Some((at_s, [x, y, z]))
}

/// The samples without what stands out of what a diagnosis found, and the faults that this is. `None` where nothing stands out.
pub(crate) fn without(
    table: &Table,
    samples: &Samples,
    diagnosis: &Diagnosis,
    asked: &[String],
) -> Option<(Samples, Vec<DataFault>)> {
    let of_magnitude = diagnosis.residual == Residual::Magnitude.name() && !diagnosis.lower_order;
    if diagnosis.verdict == Verdict::Undetermined || !of_magnitude {
        return None;
    }
    let found = stand_out(samples, diagnosis, asked);
    if found.is_empty() {
        return None;
    }
    let fault = |&(from, to): &(usize, usize)| {
        faults::burst_fault(table, (samples.row[from], samples.row[to]), (to - from + 1) * samples.stride)
    };
    let inside = |at: usize| found.iter().any(|(from, to)| (*from..=*to).contains(&at));
    let kept = |(at, row): (usize, &usize)| (!inside(at)).then_some(*row);
    let rows: Vec<usize> = samples.row.iter().enumerate().filter_map(kept).collect();
    Some((samples.of_these(table, rows), found.iter().map(fault).collect()))
}

/// How many samples these faults set aside; a gap of a column is none.
pub(crate) fn samples(faults: &[DataFault]) -> usize {
    faults.iter().filter(|fault| fault.kind == FaultKind::Burst).map(|fault| fault.samples).sum()
}

/// Whether the study without what stood out says more: it explains what the other does not, or the same effects leave less, or fewer
/// leave as little.
pub(crate) fn says_more(without: &Diagnosis, with: &Diagnosis) -> bool {
    let left = |one: &Diagnosis| one.steps.last().and_then(|step| step.holdout_rms_ut);
    let explained = |one: &Diagnosis| matches!(one.verdict, Verdict::Missing | Verdict::Confounded);
    let Some(now) = left(without) else { return false };
    // A step within a part of the log that is held out cannot be predicted.
    let before = left(with).unwrap_or(f64::INFINITY);
    let fewer = without.effects.len() < with.effects.len() && now <= AS_WELL * before;
    let better = match (explained(with), explained(without)) {
        (false, true) => now <= before || fewer,
        (true, false) => false,
        _ => AS_WELL * now < before || fewer,
    };
    better && !without.effects.is_empty() && without.verdict != Verdict::Undetermined
}
