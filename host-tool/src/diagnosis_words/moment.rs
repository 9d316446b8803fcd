//! What else of a log happens at the moment of a step.

use crate::diagnosis_words::numbers::significant;
use crate::input::Log;

/// Share of a log that counts as one moment.
const MOMENT: f64 = 0.01;
/// Samples of a moment at least.
const FEWEST: usize = 5;
/// A change or a peak is told where it is this many times the largest elsewhere.
const CLEARLY: f64 = 1.5;

/// Columns that change or have their peak at this time, in words.
pub(crate) fn at_moment(log: &Log, at_s: f64) -> Vec<String> {
    let Some(time_s) = &log.time_s else { return Vec::new() };
    let at = time_s.partition_point(|time| *time < at_s);
    let width = ((MOMENT * log.rows as f64) as usize).max(FEWEST);
    if at < 2 * width || at + 2 * width > log.rows {
        return Vec::new();
    }
    let change = |column: &crate::input::Covariate| {
        let values = &column.values;
        if values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        changes(values, at, width)
            .map(|[before, after]| {
                format!(
                    "{} changes from {} to {}",
                    column.name,
                    significant(before, 3),
                    significant(after, 3)
                )
            })
            .or_else(|| {
                let peak = peaks(values, at, width)?;
                Some(format!("{} has its peak of the log, {}", column.name, significant(peak, 3)))
            })
    };
    log.covariates.iter().filter_map(change).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The means before and after, where they differ more than anywhere else.
fn changes(values: &[f64], at: usize, width: usize) -> Option<[f64; 2]> {
    // The step is known to a part of the moment.
    let around = |place: usize| [mean(&values[place - width..place]), mean(&values[place..place + width])];
    let size = |[a, b]: [f64; 2]| (b - a).abs();
    let places =
        |from: usize, to: usize| (from.max(width)..to.min(values.len() - width)).step_by(width.div_ceil(4));
    let most =
        |range: &mut dyn Iterator<Item = usize>| range.map(|place| size(around(place))).fold(0.0, f64::max);
    let here = places(at - width / 2, at + width / 2 + 1)
        .max_by(|a, b| size(around(*a)).total_cmp(&size(around(*b))))?;
    let elsewhere = most(&mut places(0, at - 2 * width)).max(most(&mut places(at + 2 * width, values.len())));
    (size(around(here)) > CLEARLY * elsewhere).then(|| around(here))
}

/// The value that is furthest from the median, where it is at this moment and the rest of the log has none like it.
fn peaks(values: &[f64], at: usize, width: usize) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    let far = |value: &&f64| (**value - median).abs();
    let largest = |part: &[f64]| part.iter().max_by(|a, b| far(a).total_cmp(&far(b))).copied();
    let here = largest(&values[at - width..at + width])?;
    let elsewhere = [&values[..at - 2 * width], &values[(at + 2 * width).min(values.len())..]];
    let most =
        elsewhere.into_iter().filter_map(largest).map(|value| (value - median).abs()).fold(0.0, f64::max);
    ((here - median).abs() > CLEARLY * most).then_some(here)
}

#[cfg(test)]
mod tests {
    use super::{changes, peaks};

    #[test]
    fn a_switch_and_a_peak_are_told_where_they_are_and_nowhere_else() {
        let switch: Vec<f64> = (0..1000).map(|i| f64::from(u8::from(i >= 400))).collect();
        assert_eq!(changes(&switch, 402, 10).map(|[a, b]| (a < 0.3, b > 0.7)), Some((true, true)));
        assert_eq!(changes(&switch, 700, 10), None);
        let pulse: Vec<f64> = (0..1000).map(|i| if i == 300 { 40.0 } else { f64::from(i % 7) }).collect();
        assert_eq!(peaks(&pulse, 302, 10), Some(40.0));
        assert_eq!(peaks(&pulse, 600, 10), None);
    }
}
