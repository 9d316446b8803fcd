//! What numbers can be: units that their size rules out, and those that it leaves.

use crate::input::text::grid::Grid;
use crate::input::unit::{Quantity, Unit};

/// Rows that are looked at.
const LOOK: usize = 5000;
/// The median magnitude of a raw, uncalibrated magnetometer on the Earth, µT: the field (22 to 67) and a hard iron of a few times it.
const RAW_UT: [f64; 2] = [8.0, 250.0];
/// Half the range of an axis that was turned through the field: at most the strongest field with a gain far off, …
const SWING_MOST_UT: f64 = 130.0;
/// … and where all three axes swing alike, at least about the weakest.
const SWING_LEAST_UT: f64 = 17.0;
/// The step between samples of a log, s: 2 kHz to 3 s.
const STEP_S: [f64; 2] = [0.000_5, 3.0];
/// Seconds since 1970 of this century's logs: 2001 to 2096.
const EPOCH_S: [f64; 2] = [1e9, 4e9];
/// A resting accelerometer is within this share of one g.
const G_SHARE: f64 = 0.08;
/// No gyroscope on a board turns faster, rad/s (2300 °/s).
const FASTEST_RADPS: f64 = 40.0;

/// What is known of a triple's numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Size {
    /// Median magnitude.
    pub median: f64,
    /// The fifth percentile of the magnitude over the 95th: a gyroscope comes to rest, a field does not.
    pub least_share: f64,
    /// Half the range of each axis, extremes left out, sorted.
    pub swing: [f64; 3],
    /// Whether all numbers are whole.
    pub whole: bool,
    /// Whether all magnitudes are one, as of a direction.
    pub directions: bool,
}

/// The size of a triple of columns in these rows; `None` where there are no numbers.
pub fn size(grid: &Grid, triple: [usize; 3], rows: &[usize]) -> Option<Size> {
    let step = (rows.len() / LOOK).max(1);
    let columns = triple
        .map(|index| grid.columns.get(index).map(|column| column.values.as_slice()).unwrap_or_default());
    let vectors: Vec<[f64; 3]> = rows
        .iter()
        .step_by(step)
        .map(|row| columns.map(|values| values.get(*row).copied().unwrap_or(f64::NAN)))
        .filter(|vector| vector.iter().all(|value| value.is_finite()))
        .collect();
    let mut norms: Vec<f64> = vectors.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt()).collect();
    norms.sort_by(f64::total_cmp);
    let median = share(&norms, 0.5)?;
    let (low, high) = (share(&norms, 0.05)?, share(&norms, 0.95)?);
    let mut swing = [0.0; 3];
    for (axis, slot) in swing.iter_mut().enumerate() {
        let mut values: Vec<f64> = vectors.iter().map(|vector| vector[axis]).collect();
        values.sort_by(f64::total_cmp);
        *slot = (share(&values, 0.98)? - share(&values, 0.02)?) / 2.0;
    }
    swing.sort_by(f64::total_cmp);
    Some(Size {
        median,
        least_share: low / high,
        swing,
        whole: vectors.iter().flatten().all(|value| value.fract() == 0.0),
        directions: (low - 1.0).abs() < 0.02 && (high - 1.0).abs() < 0.02,
    })
}

fn share(sorted: &[f64], share: f64) -> Option<f64> {
    let at = ((sorted.len().max(1) - 1) as f64 * share).round() as usize;
    sorted.get(at).copied()
}

/// Whether a raw magnetometer can have these numbers in this unit.
pub fn can_be_field(size: &Size, unit: &Unit) -> bool {
    let [median, most, least] = [size.median, size.swing[2], size.swing[0]].map(|value| unit.convert(value));
    let turned = least > 0.5 * most && most > 0.0;
    (RAW_UT[0]..=RAW_UT[1]).contains(&median)
        && most <= SWING_MOST_UT
        && !(turned && size.swing[2] > 0.3 * size.median && most < SWING_LEAST_UT)
        && !size.directions
        && size.least_share > 0.02
}

/// The units of a field that the numbers can be in.
pub fn field_units(size: &Size) -> Vec<Unit> {
    Unit::all(Quantity::Field).filter(|unit| can_be_field(size, unit)).collect()
}

/// The unit of a specific force that the numbers are in: at rest it is one g.
pub fn accel_unit(size: &Size) -> Option<Unit> {
    Unit::all(Quantity::Acceleration)
        .find(|unit| (unit.convert(size.median) / 9.806_65 - 1.0).abs() < G_SHARE && size.least_share > 0.2)
}

/// The units of an angular rate that the numbers can be in: radians only where nothing turns too fast for them.
pub fn rate_units(grid: &Grid, triple: [usize; 3], rows: &[usize]) -> Vec<Unit> {
    let most = triple
        .iter()
        .filter_map(|index| grid.columns.get(*index))
        .flat_map(|column| rows.iter().filter_map(|row| column.values.get(*row)))
        .filter(|value| value.is_finite())
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    ["rad/s", "deg/s"]
        .into_iter()
        .filter_map(|name| Unit::of(name, Quantity::Rate))
        .filter(|unit| unit.convert(most) < FASTEST_RADPS)
        .collect()
}

/// A column as time.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    /// The units that it can be in.
    pub units: Vec<Unit>,
    /// The median step, in the column's own numbers.
    pub step: f64,
    /// Since 1970.
    pub epoch: bool,
}

/// Whether the column runs forward in these rows, and in which units that is a log of a sensor.
pub fn clock(values: &[f64], rows: &[usize]) -> Option<Clock> {
    let times: Vec<f64> =
        rows.iter().filter_map(|row| values.get(*row)).copied().filter(|v| v.is_finite()).collect();
    if times.len() * 10 < rows.len() * 9 {
        return None;
    }
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let backward = steps.iter().filter(|step| **step < 0.0).count();
    steps.retain(|step| *step > 0.0);
    if steps.is_empty() || backward * 50 > times.len() {
        return None;
    }
    steps.sort_by(f64::total_cmp);
    let first = times.first().copied()?;
    // Several rows of one stamp share its step out.
    let is_shared = times.len() >= 2 * (steps.len() + 1);
    let step =
        if is_shared { (times.last()? - first) / (times.len() - 1) as f64 } else { share(&steps, 0.5)? };
    let units = || Unit::all(Quantity::Time);
    let epoch: Vec<Unit> =
        units().filter(|unit| (EPOCH_S[0]..=EPOCH_S[1]).contains(&unit.convert(first))).collect();
    if let [unit] = epoch.as_slice()
        // Microseconds since the start are as large as seconds since 1970, and then the steps tell.
        && (STEP_S[0]..=STEP_S[1]).contains(&unit.convert(step))
    {
        return Some(Clock { units: epoch, step, epoch: true });
    }
    let units = units().filter(|unit| (STEP_S[0]..=STEP_S[1]).contains(&unit.convert(step))).collect();
    Some(Clock { units, step, epoch: false })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::text::grid::GridColumn;

    fn sphere(radius: f64, offset: f64) -> (Grid, Vec<usize>) {
        let mut grid = Grid::default();
        for axis in 0..3 {
            let mut column = GridColumn::new("");
            for i in 0..400 {
                let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 400.0;
                let (r, turn) = ((1.0 - z * z).sqrt(), f64::from(i) * 2.399_963);
                column.values.push(radius * [r * turn.cos(), r * turn.sin(), z][axis] + offset);
            }
            grid.columns.push(column);
        }
        (grid, (0..400).collect())
    }

    #[test]
    fn the_size_of_a_field_tells_its_unit() {
        for (radius, offset, expected) in [
            (48.13, 10.2, "uT"),
            (481.3, 102.0, "mG"),
            (0.4813, 0.102, "G"),
            (48_130.0, 10_200.0, "nT"),
            (4.813e-5, 1e-5, "T"),
        ] {
            let (grid, rows) = sphere(radius, offset);
            let found = field_units(&size(&grid, [0, 1, 2], &rows).expect("numbers"));
            let names: Vec<&str> = found.iter().map(|unit| unit.name.as_ref()).collect();
            assert_eq!(names, [expected], "{radius}");
        }
        let (grid, rows) = sphere(1.0, 0.0);
        let directions = size(&grid, [0, 1, 2], &rows).expect("numbers");
        assert!(directions.directions && field_units(&directions).is_empty());
        let (grid, rows) = sphere(9.8, 0.0);
        let gravity = size(&grid, [0, 1, 2], &rows).expect("numbers");
        assert_eq!(accel_unit(&gravity).map(|unit| unit.name.to_string()), Some("m/s2".into()));
        assert!(field_units(&gravity).is_empty(), "{:?}", field_units(&gravity));
    }

    #[test]
    fn the_step_tells_the_unit_of_time_or_leaves_two() {
        let rows: Vec<usize> = (0..100).collect();
        for (start, step, expected) in [
            (0.0, 0.02, vec!["s"]),
            (5.0, 20.0, vec!["ms"]),
            (5e6, 20_000.0, vec!["us"]),
            (0.0, 2e7, vec!["ns"]),
            (0.0, 1.0, vec!["s", "ms"]),
            (0.0, 1000.0, vec!["ms", "us"]),
            (1.7e9, 0.02, vec!["s"]),
            (1.7e9, 1.0, vec!["s"]),
            (1.7e9, 20_000.0, vec!["us"]),
            (1.7e12, 1.0, vec!["ms"]),
            (1.7e18, 2e7, vec!["ns"]),
        ] {
            let values: Vec<f64> = rows.iter().map(|row| start + step * *row as f64).collect();
            let found = clock(&values, &rows).expect("runs forward");
            let names: Vec<&str> = found.units.iter().map(|unit| unit.name.as_ref()).collect();
            assert_eq!(names, expected, "{start} {step}");
        }
        let still = vec![1.0; 100];
        assert_eq!(clock(&still, &rows), None);
    }
}
