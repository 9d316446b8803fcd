//! One axis as a series: its path, its range, its step.

use crate::samples::series::median;

/// Values looked at for the range and the usual step of an axis.
const MAX_LOOK: usize = 4000;
/// Values looked at for the step of the numbers.
const MAX_LOOK_FOR_STEP: usize = 2000;

/// Values, evenly chosen, sorted.
fn chosen(values: &[f64], most: usize) -> Vec<f64> {
    let mut few: Vec<f64> = values
        .iter()
        .step_by(values.len().div_ceil(most).max(1))
        .copied()
        .filter(|v| v.is_finite())
        .collect();
    few.sort_by(f64::total_cmp);
    few
}

/// Half the range of the middle 96 % of the values.
pub fn half_range(values: &[f64]) -> f64 {
    let sorted = chosen(values, MAX_LOOK);
    let at = |share: f64| {
        sorted.get(((sorted.len().max(1) - 1) as f64 * share).round() as usize).copied().unwrap_or(0.0)
    };
    0.5 * (at(0.98) - at(0.02))
}

/// Median step from one value to the next, equal ones left out.
pub fn usual_step(values: &[f64]) -> f64 {
    let stride = values.len().div_ceil(MAX_LOOK).max(1);
    let steps = values.windows(2).step_by(stride).map(|pair| (pair[1] - pair[0]).abs());
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0 && step.is_finite()).collect();
    if steps.is_empty() { 0.0 } else { median(&mut steps) }
}

/// Whether neighbouring values are near each other.
pub fn is_continuous(values: &[f64]) -> bool {
    usual_step(values) <= super::evidence::MAX_STEP_SHARE * half_range(values)
}

/// Path length: the sum of all steps.
pub fn path(values: impl Iterator<Item = f64>) -> f64 {
    let mut last: Option<f64> = None;
    let mut sum = 0.0;
    for value in values {
        sum += last.map_or(0.0, |last: f64| (value - last).abs());
        last = Some(value);
    }
    sum
}

/// Least and greatest value.
pub fn ends(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
}

/// The step that all values are multiples of: 1 for whole numbers; `None` for numbers of no visible step.
pub fn count_step(values: &[f64]) -> Option<f64> {
    if values.iter().all(|value| value.fract() == 0.0) {
        return Some(1.0);
    }
    let sorted = chosen(values, MAX_LOOK_FOR_STEP);
    let widest = sorted.last()?.abs().max(sorted.first()?.abs());
    let tiny = 1e-7 * widest;
    let least =
        sorted.windows(2).map(|p| p[1] - p[0]).filter(|step| *step > tiny).fold(f64::INFINITY, f64::min);
    if !least.is_finite() {
        return None;
    }
    // The numbers may be rounded: each larger value makes the step known more exactly.
    let mut magnitudes: Vec<f64> =
        sorted.iter().map(|value| value.abs()).filter(|value| *value > tiny).collect();
    magnitudes.sort_by(f64::total_cmp);
    let (mut step, mut known) = (least, least);
    for value in &magnitudes {
        let count = (value / step).round();
        if count > 0.0 && *value > known && *value < 50.0 * known {
            (step, known) = (value / count, *value);
        }
    }
    let off =
        magnitudes.iter().filter(|value| ((*value / step) - (*value / step).round()).abs() > 0.1).count();
    (off * 100 <= magnitudes.len() && step > 0.0).then_some(step)
}
