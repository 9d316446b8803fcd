//! A column of one time base, asked at the times of another.

use crate::input::formats::stream::Between;

/// Where two samples of a stream are farther apart than so many of its median periods, there is a gap: what lies in it is
/// not known. Five bridges the jitter and the single losses of loggers, and no dropout.
pub const GAP_PERIODS: f64 = 5.0;

/// The longest step between two samples that is still no gap, s: [`GAP_PERIODS`] median periods; infinite with fewer than
/// three samples, whose period is not known.
pub fn gap_s(time_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> =
        time_s.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    if steps.len() < 2 {
        return f64::INFINITY;
    }
    let middle = steps.len() / 2;
    let (_, median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    GAP_PERIODS * *median
}

/// Values at `at_s` (not decreasing) from those at `time_s` (not decreasing). NaN before the first sample, after the last
/// one (held ones: a gap's length after it) and in gaps.
pub fn at_times(time_s: &[f64], values: &[f64], between: Between, gap_s: f64, at_s: &[f64]) -> Vec<f64> {
    let mut next = 0;
    let sample = |index: usize| Some((*time_s.get(index)?, *values.get(index)?));
    at_s.iter()
        .map(|&at| {
            while time_s.get(next).is_some_and(|time| *time <= at) {
                next += 1;
            }
            let (before, after) = (next.checked_sub(1).and_then(sample), sample(next));
            match (before, after) {
                (Some((time, value)), _) if time == at => value,
                (Some((time, value)), _) if between == Between::Hold => {
                    if at - time <= gap_s {
                        value
                    } else {
                        f64::NAN
                    }
                }
                (Some(before), Some(after)) if after.0 - before.0 <= gap_s => {
                    let share = (at - before.0) / (after.0 - before.0);
                    match between {
                        Between::Circle => circle(before.1, after.1, share),
                        _ => before.1 + (after.1 - before.1) * share,
                    }
                }
                _ => f64::NAN,
            }
        })
        .collect()
}

/// From `a` to `b` the shorter way round, in −180 … 180.
fn circle(a: f64, b: f64, share: f64) -> f64 {
    let step = (b - a + 540.0).rem_euclid(360.0) - 180.0;
    (a + step * share + 540.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_holds_circles_and_gaps() {
        let time: Vec<f64> = [0.0, 1.0, 2.0, 3.0, 13.0, 14.0].to_vec();
        let values = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0];
        let gap = gap_s(&time);
        assert_eq!(gap, 5.0);
        let at = [-0.5, 0.0, 0.25, 2.5, 3.0, 8.0, 13.5, 14.0, 15.0];
        let line = at_times(&time, &values, Between::Line, gap, &at);
        let expected = [f64::NAN, 0.0, 2.5, 25.0, 30.0, f64::NAN, 45.0, 50.0, f64::NAN];
        for (found, expected) in line.iter().zip(expected) {
            assert!(found.to_bits() == expected.to_bits(), "{line:?}");
        }
        let hold = at_times(&time, &values, Between::Hold, gap, &at);
        assert_eq!(hold[2..5], [0.0, 20.0, 30.0]);
        assert_eq!(hold[5], 30.0);
        assert_eq!(hold[8], 50.0);
        let circle = at_times(&[0.0, 1.0], &[179.0, -179.0], Between::Circle, f64::INFINITY, &[0.5, 0.75]);
        assert!((circle[0].abs() - 180.0).abs() < 1e-9 && (circle[1] + 179.5).abs() < 1e-9, "{circle:?}");
    }

    #[test]
    fn equal_times_divide_nothing_by_zero() {
        let found = at_times(&[0.0, 1.0, 1.0, 2.0], &[0.0, 1.0, 3.0, 4.0], Between::Line, 9.0, &[1.0, 1.5]);
        assert_eq!(found, [3.0, 3.5]);
    }
}
