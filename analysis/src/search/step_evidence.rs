//! When the readings themselves jump by a step.

use crate::base::term::Term;
use crate::samples::samples::Samples;

/// A jump is looked for this far before and after a step, s.
const AROUND_STEP_S: f64 = 6.0;
/// In fewer readings no jump is looked for.
const FEWEST_READINGS: usize = 40;
/// The readings jump by the step if they jump by its size to this share, ...
const ITS_SIZE: f64 = 0.5;
/// ... and by so many times as much as anywhere else around.
const ABOVE_OTHERS: f64 = 1.5;

/// When the readings themselves jump by the step, near its time, and nowhere around by nearly as much: the magnitude does not
/// see a step that happens across the field, and places it where it begins to.
pub(crate) fn readings_jump(samples: &Samples, step: &Term, at: f64) -> Option<f64> {
    let time = samples.time.as_ref()?;
    let place = |seconds: f64| time.partition_point(|t| *t < at + seconds);
    let (from, to) = (place(-AROUND_STEP_S).max(2), place(AROUND_STEP_S).min(time.len().saturating_sub(1)));
    let size: f64 = step.coefficients.iter().take(3).map(|value| value * value).sum();
    if to < from + FEWEST_READINGS || size <= 0.0 {
        return None;
    }
    // From one sample to the next, less what the board's motion makes of it on either side; in sizes of the step.
    let along = |a: usize, b: usize| -> f64 {
        let (a, b) = (samples.readings[a].measured_ut, samples.readings[b].measured_ut);
        (0..3).map(|axis| (b[axis] - a[axis]) * step.coefficients[axis]).sum::<f64>() / size
    };
    let jumps: Vec<f64> =
        (from..to).map(|i| along(i - 1, i) - 0.5 * (along(i - 2, i - 1) + along(i, i + 1))).collect();
    let best = (0..jumps.len()).max_by(|a, b| jumps[*a].total_cmp(&jumps[*b]))?;
    // The sample before and the one after see half of the jump the other way round.
    let elsewhere = jumps.iter().enumerate().filter(|(i, _)| i.abs_diff(best) > 1);
    let most = elsewhere.fold(0.0, |most: f64, (_, jump)| most.max(jump.abs()));
    let jumps = (jumps[best] - 1.0).abs() < ITS_SIZE && jumps[best] > ABOVE_OTHERS * most;
    jumps.then(|| 0.5 * (time[from + best - 1] + time[from + best]))
}
