//! The steps of the time column: no magnetometer is read every twenty minutes, or a million times a second.

use crate::samples::series::median;
use crate::table::Table;

/// No log for a calibration has a row this seldom, s …
const SLOWEST_S: f64 = 1000.0;
/// … and hardly one this seldom.
const SLOW_S: f64 = 5.0;
/// No magnetometer is read this fast, s (fluxgates and tunnel sensors reach some 10 kHz) …
const FASTEST_S: f64 = 5e-6;
/// … and hardly one this fast.
const FAST_S: f64 = 5e-5;
/// Fewer steps say nothing.
const LEAST_STEPS: usize = 20;

/// Units that times are written in, and what a second is of them.
pub const UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];

/// A time column that is in another unit than it is read in.
#[derive(Debug, Clone, PartialEq)]
pub struct OddClock {
    /// Median of the steps that are none of zero, s as read.
    pub step_s: f64,
    /// From the first row to the last, s as read.
    pub seconds: f64,
    /// Steps.
    pub steps: usize,
    /// Whether no sensor has such steps, or merely few.
    pub certain: bool,
    /// Factors that make the step a usual one, the most usual first.
    pub factors: Vec<f64>,
}

/// What is odd about the time of a log.
pub fn odd(table: &Table) -> Option<OddClock> {
    let time = table.time_s?;
    let seconds = time.last()? - time.first()?;
    let mut steps: Vec<f64> = time
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|step| *step > 0.0 && step.is_finite())
        .collect();
    if steps.len() < LEAST_STEPS {
        return None;
    }
    let count = steps.len();
    let mean_s = seconds / count as f64;
    let step_s = median(&mut steps);
    // Logs arrive in bursts, and have gaps: both the usual step and the mean must be odd.
    let (least, most) = (step_s.min(mean_s), step_s.max(mean_s));
    let odd = least >= SLOW_S || most <= FAST_S;
    odd.then(|| OddClock {
        step_s,
        seconds,
        steps: count,
        certain: least >= SLOWEST_S || most <= FASTEST_S,
        factors: factors(step_s),
    })
}

/// Powers of a thousand that bring a step to between 0.5 ms and 2 s, the nearest to 20 ms first.
fn factors(step_s: f64) -> Vec<f64> {
    let mut list: Vec<f64> = [1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9]
        .into_iter()
        .filter(|factor| (5e-4..=2.0).contains(&(step_s * factor)))
        .collect();
    let distance = |factor: &f64| (step_s * factor / 0.02).ln().abs();
    list.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(step: f64) -> Option<OddClock> {
        let time: Vec<f64> = (0..100).map(|i| f64::from(i) * step).collect();
        odd(&Table { time_s: Some(&time), ..Table::default() })
    }

    #[test]
    fn units_are_told_by_the_step() {
        for (step, factor, certain) in
            [(20.0, 1e-3, false), (2e4, 1e-6, true), (2e7, 1e-9, true), (2e-8, 1e6, true), (2e-5, 1e3, false)]
        {
            let odd = of(step).unwrap_or_else(|| panic!("{step}"));
            assert_eq!((odd.factors.first().copied(), odd.certain), (Some(factor), certain), "{step}");
        }
    }

    #[test]
    fn rates_that_sensors_have_are_not_odd() {
        for step in [1e-4, 1e-3, 0.02, 0.1, 1.0, 1.3] {
            assert_eq!(of(step), None, "{step}");
        }
        // Rows that arrive in bursts, and a night between them.
        let time: Vec<f64> = (0..1000).map(|i| f64::from(i / 10) * 0.2 + f64::from(i % 10) * 1e-6).collect();
        assert_eq!(odd(&Table { time_s: Some(&time), ..Table::default() }), None);
        let night: Vec<f64> =
            (0..1000).map(|i| f64::from(i) * 0.02 + if i > 500 { 4e4 } else { 0.0 }).collect();
        assert_eq!(odd(&Table { time_s: Some(&night), ..Table::default() }), None);
        assert_eq!(odd(&Table::default()), None);
    }
}
