//! The offset of one sensor over days: constant, drifting, or another one from some log on.

use crate::fleet::apart::MAX_P_VALUE;
use crate::fleet::entry::{Calibrated, FleetLog};
use ironout::study::f_tail;
use serde::Serialize;
use std::collections::BTreeMap;

/// Logs from which on a trend is tested.
const MIN_LOGS: usize = 4;
/// Logs on either side of a change.
const MIN_LOGS_BESIDE_CHANGE: usize = 2;
/// A move of the offset of less than this share of the field is of no interest.
const MIN_MOVE_SHARE: f64 = 0.005;

/// A steady motion of the offset.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Drift {
    /// Slope of each axis, µT per day.
    pub ut_per_day: [f64; 3],
    /// Standard errors of the slopes.
    pub std_ut_per_day: [f64; 3],
    /// Move over the time of the logs, µT.
    pub moved_ut: f64,
    /// Probability of such a slope by chance, all sensors counted.
    pub p_value: f64,
}

/// A sudden change of the offset.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// First log with the new offset.
    pub from_log: String,
    /// Day of that log, since 1970.
    pub from_day: f64,
    /// New mean offset less the old one, µT.
    pub offset_shift_ut: [f64; 3],
    /// Change of the matrix's diagonal.
    pub gain_shift: [f64; 3],
    /// Whether the gains changed too, which a new magnet does not do and another sensor does.
    pub gains_changed: bool,
    /// Probability of such a change by chance, all sensors and places counted.
    pub p_value: f64,
}

/// The offset of one log in a history.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HistoryPoint {
    /// The log.
    pub log: String,
    /// Days since 1970.
    pub day: f64,
    /// Offset at the same values of the columns that move it in all logs, µT.
    pub offset_ut: [f64; 3],
}

/// The offset of one sensor over its logs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct History {
    /// The vehicle.
    pub vehicle: String,
    /// The sensor; empty if unknown.
    pub sensor: String,
    /// Logs with a calibration and a day.
    pub logs: usize,
    /// Days from the first log to the last.
    pub days: f64,
    /// Mean offset, µT.
    pub offset_ut: [f64; 3],
    /// Rms of one axis about what explains the offsets best, µT.
    pub scatter_ut: f64,
    /// The logs in the order of their days.
    pub series: Vec<HistoryPoint>,
    /// A significant trend.
    pub drift: Option<Drift>,
    /// A significant change, where it explains the offsets better than a trend.
    pub change: Option<Change>,
}

/// One log of the series.
struct Point<'a> {
    name: &'a str,
    day: f64,
    /// At the same values of the columns that move it in all logs, µT.
    offset_ut: [f64; 3],
    calibrated: &'a Calibrated,
}

/// The offset of every log at the same values of the columns that move it: each calibration has its own reference, and without this a
/// flight of other currents would seem to have another offset.
fn to_common_reference(points: &mut [Point]) {
    let mut sums: BTreeMap<&str, (f64, usize)> = BTreeMap::new();
    for one in points.iter().flat_map(|point| &point.calibrated.moves) {
        let sum = sums.entry(&one.id).or_default();
        *sum = (sum.0 + one.reference, sum.1 + 1);
    }
    for point in points.iter_mut() {
        for one in &point.calibrated.moves {
            let Some((sum, count)) = sums.get(one.id.as_str()) else { continue };
            let way = sum / *count as f64 - one.reference;
            (0..3).for_each(|axis| point.offset_ut[axis] += one.coefficients[axis] * way);
        }
    }
}

/// The history of one sensor; `series` is the number of sensors that are tested.
pub fn history(logs: &[&FleetLog], series: usize) -> Option<History> {
    let mut points: Vec<Point> = logs
        .iter()
        .filter_map(|log| {
            let calibrated = log.calibrated.as_ref()?;
            Some(Point { name: &log.name, day: log.day?, offset_ut: calibrated.offset_ut, calibrated })
        })
        .collect();
    to_common_reference(&mut points);
    points.sort_by(|a, b| a.day.total_cmp(&b.day).then_with(|| a.name.cmp(b.name)));
    let (first, last) = (points.first()?, points.last()?);
    let (n, days) = (points.len(), last.day - first.day);
    let offsets: Vec<[f64; 3]> = points.iter().map(|point| point.offset_ut).collect();
    let field_ut = points.iter().map(|point| point.calibrated.field_ut).sum::<f64>() / n as f64;
    let constant = squares_about_mean(&offsets);
    let line = Line::of(&points);
    let tests = series.max(1) as f64;
    let drift = line.as_ref().filter(|_| n >= MIN_LOGS).and_then(|line| {
        let p_value = tests * tail(constant, line.squares, n, 2);
        let drift = line.drift(days, p_value.min(1.0));
        (p_value < MAX_P_VALUE && drift.moved_ut > MIN_MOVE_SHARE * field_ut).then_some(drift)
    });
    let change = change(&points, constant, tests).filter(|(change, _)| {
        change.p_value < MAX_P_VALUE && length(change.offset_shift_ut) > MIN_MOVE_SHARE * field_ut
    });
    let mut result = History {
        vehicle: logs.first()?.vehicle.clone(),
        sensor: logs.first()?.sensor.clone(),
        logs: n,
        days,
        offset_ut: mean(&offsets),
        scatter_ut: 0.0,
        series: points
            .iter()
            .map(|one| HistoryPoint { log: one.name.to_string(), day: one.day, offset_ut: one.offset_ut })
            .collect(),
        drift: None,
        change: None,
    };
    let free = |parameters: usize| (3 * n.saturating_sub(parameters)).max(1) as f64;
    let line_squares = line.map_or(constant, |line| line.squares);
    let (squares, freedom) = match (drift, change) {
        (Some(drift), Some((_, squares))) if line_squares <= squares => {
            result.drift = Some(drift);
            (line_squares, free(2))
        }
        (_, Some((change, squares))) => {
            result.change = Some(change);
            (squares, free(2))
        }
        (Some(drift), None) => {
            result.drift = Some(drift);
            (line_squares, free(2))
        }
        (None, None) => (constant, free(1)),
    };
    result.scatter_ut = (squares / freedom).sqrt();
    Some(result)
}

/// A straight line through each axis.
struct Line {
    slope: [f64; 3],
    /// Sum of squares of the days about their mean.
    spread: f64,
    squares: f64,
    /// Of each axis.
    squares_each: [f64; 3],
    n: usize,
}

impl Line {
    fn of(points: &[Point]) -> Option<Line> {
        let n = points.len();
        let middle = points.iter().map(|point| point.day).sum::<f64>() / n as f64;
        let spread: f64 = points.iter().map(|point| (point.day - middle).powi(2)).sum();
        if n < 3 || !(spread > 0.0) {
            return None;
        }
        let centre = mean(&points.iter().map(|point| point.offset_ut).collect::<Vec<_>>());
        let (mut slope, mut squares_each) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let of = |point: &Point| point.offset_ut[axis] - centre[axis];
            slope[axis] = points.iter().map(|point| (point.day - middle) * of(point)).sum::<f64>() / spread;
            squares_each[axis] =
                points.iter().map(|point| (of(point) - slope[axis] * (point.day - middle)).powi(2)).sum();
        }
        Some(Line { slope, spread, squares: squares_each.iter().sum(), squares_each, n })
    }

    fn drift(&self, days: f64, p_value: f64) -> Drift {
        let freedom = self.n.saturating_sub(2).max(1) as f64;
        Drift {
            ut_per_day: self.slope,
            std_ut_per_day: self.squares_each.map(|squares| (squares / freedom / self.spread).sqrt()),
            moved_ut: length(self.slope) * days,
            p_value,
        }
    }
}

/// The change that explains the offsets best, and what it leaves of their squares.
fn change(points: &[Point], constant: f64, tests: f64) -> Option<(Change, f64)> {
    let n = points.len();
    if n < MIN_LOGS {
        return None;
    }
    let offsets: Vec<[f64; 3]> = points.iter().map(|point| point.offset_ut).collect();
    let gains: Vec<[f64; 3]> = points.iter().map(|point| point.calibrated.gains).collect();
    let places = MIN_LOGS_BESIDE_CHANGE..=n - MIN_LOGS_BESIDE_CHANGE;
    let count = places.clone().count() as f64;
    let left = |all: &[[f64; 3]], at: usize| squares_about_mean(&all[..at]) + squares_about_mean(&all[at..]);
    let at = places.min_by(|a, b| left(&offsets, *a).total_cmp(&left(&offsets, *b)))?;
    let squares = left(&offsets, at);
    let shift = |all: &[[f64; 3]]| {
        let (before, after) = (mean(&all[..at]), mean(&all[at..]));
        [0, 1, 2].map(|axis| after[axis] - before[axis])
    };
    let gains_p_value = tests * tail(squares_about_mean(&gains), left(&gains, at), n, 2);
    let change = Change {
        from_log: points[at].name.to_string(),
        from_day: points[at].day,
        offset_shift_ut: shift(&offsets),
        gain_shift: shift(&gains),
        gains_changed: gains_p_value < MAX_P_VALUE,
        p_value: (tests * count * tail(constant, squares, n, 2)).min(1.0),
    };
    Some((change, squares))
}

/// Probability that three axes of `n` logs lose as much by chance when a model of `parameters` an axis takes the place of the mean.
fn tail(before: f64, after: f64, n: usize, parameters: usize) -> f64 {
    let freedom = 3.0 * n.saturating_sub(parameters) as f64;
    let added = 3.0 * (parameters - 1) as f64;
    f_tail(((before - after) / added) / (after / freedom), added, freedom)
}

fn mean(values: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|axis| values.iter().map(|value| value[axis]).sum::<f64>() / values.len().max(1) as f64)
}

fn squares_about_mean(values: &[[f64; 3]]) -> f64 {
    let centre = mean(values);
    values.iter().flat_map(|value| (0..3).map(move |axis| (value[axis] - centre[axis]).powi(2))).sum()
}

fn length(vector: [f64; 3]) -> f64 {
    vector.iter().map(|part| part * part).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::entry::Move;

    /// Twelve logs, one a day; the offset of x by day, and a scatter that repeats.
    fn logs(offset: impl Fn(usize) -> f64, gain: impl Fn(usize) -> f64) -> Vec<FleetLog> {
        let scatter = [0.02, -0.03, 0.01, 0.03, -0.02, -0.01, 0.0];
        (0..12)
            .map(|day| FleetLog {
                name: format!("{day:02}"),
                vehicle: "v".into(),
                day: Some(20_000.0 + day as f64),
                calibrated: Some(Calibrated {
                    offset_ut: [0, 1, 2].map(|axis| {
                        scatter[(3 * axis + day) % 7] + if axis == 0 { offset(day) } else { 5.0 }
                    }),
                    gains: [0, 1, 2].map(|axis| gain(day) + 0.01 * scatter[(day + axis) % 7]),
                    field_ut: 50.0,
                    moves: Vec::new(),
                }),
                ..FleetLog::default()
            })
            .collect()
    }

    fn of(logs: &[FleetLog]) -> History {
        history(&logs.iter().collect::<Vec<_>>(), 20).expect("a series")
    }

    #[test]
    fn what_rests_is_left_alone() {
        let steady = of(&logs(|_| 10.0, |_| 1.0));
        assert_eq!((steady.drift, steady.change), (None, None));
        assert!((steady.scatter_ut - 0.02).abs() < 0.01, "{}", steady.scatter_ut);
    }

    #[test]
    fn another_mean_of_a_column_is_no_change() {
        let mut logs = logs(|_| 10.0, |_| 1.0);
        // From the eighth day on the vehicle flies with more current, which moves x by 2 µT per A.
        for (day, log) in logs.iter_mut().enumerate() {
            let reference = if day < 7 { 3.0 } else { 5.0 };
            let calibrated = log.calibrated.as_mut().expect("a calibration");
            calibrated.offset_ut[0] += 2.0 * reference;
            let (id, coefficients) = ("offset:current_a".to_string(), [2.0, 0.0, 0.0]);
            calibrated.moves = vec![Move { id, coefficients, reference }];
        }
        let moved = of(&logs);
        assert_eq!((&moved.drift, &moved.change), (&None, &None));
        logs.iter_mut().flat_map(|log| &mut log.calibrated).for_each(|one| one.moves.clear());
        assert!(of(&logs).change.is_some());
    }

    #[test]
    fn a_drift_has_its_slope() {
        let drifting = of(&logs(|day| 10.0 + 0.3 * day as f64, |_| 1.0));
        let drift = drifting.drift.expect("a drift");
        assert!((drift.ut_per_day[0] - 0.3).abs() < 4.0 * drift.std_ut_per_day[0], "{drift:?}");
        assert!(drift.ut_per_day[1].abs() < 0.02 && drifting.change.is_none());
    }

    #[test]
    fn another_sensor_has_other_gains_and_a_magnet_has_not() {
        let swapped =
            of(&logs(|day| if day < 7 { 10.0 } else { -6.0 }, |day| if day < 7 { 1.0 } else { 1.03 }));
        let change = swapped.change.expect("a change");
        assert_eq!(change.from_log, "07");
        assert!(change.gains_changed && (change.offset_shift_ut[0] + 16.0).abs() < 0.1, "{change:?}");
        let magnet = of(&logs(|day| if day < 7 { 10.0 } else { -6.0 }, |_| 1.0)).change.expect("a change");
        assert!(!magnet.gains_changed, "{magnet:?}");
    }
}
