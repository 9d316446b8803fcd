//! What numbers can be: units that the geometry of the readings rules out, and those that it leaves.

use crate::input::text::grid::Grid;
use crate::input::text::rest::rounded;
use crate::input::unit::{Quantity, Unit};
use ironout_analysis::plausible::directions::equal_magnitudes_of;
use ironout_analysis::plausible::field::{Evidence, FieldSize, size_of};

/// Rows that are looked at.
const LOOK: usize = 5000;
/// Rows after one in which the next different reading is looked for: a log may be faster than its sensor.
const REPEATS: usize = 16;
/// A gyroscope comes to rest, a field does not: its least magnitude is above this share of its greatest.
const LEAST_SHARE: f64 = 0.02;
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
    /// Whether nothing changes.
    pub constant: bool,
    /// Whether all numbers are whole.
    pub whole: bool,
    /// The field that they turned in, as far as they tell.
    pub field: Option<FieldSize>,
    /// The magnitude that all have, as directions do.
    pub equal_magnitude: Option<f64>,
}

impl Size {
    /// The field's size in words.
    pub fn words(&self) -> String {
        match &self.field {
            Some(found) => match found.evidence {
                Evidence::Sphere | Evidence::PartOfSphere => {
                    format!("the readings lie on a sphere of radius {}", rounded(found.field_ut))
                }
                Evidence::Circle => format!(
                    "the readings lie on a circle of radius {}, so the field may be up to three times that",
                    rounded(found.field_ut)
                ),
                Evidence::Spread => format!(
                    "the sensor was rotated too little: the readings vary by {} only, so the offset is unknown",
                    rounded(found.field_ut)
                ),
            },
            None => "there are too few different readings to fit a sphere".to_string(),
        }
    }

    /// Whether the readings lie on a sphere that is the Earth's field in some unit.
    pub fn is_field(&self) -> bool {
        self.field.as_ref().is_some_and(FieldSize::is_radius) && !field_units(self).is_empty()
    }
}

/// The size of a triple of columns in these rows; `None` where there are no numbers.
pub fn size(grid: &Grid, triple: [usize; 3], rows: &[usize]) -> Option<Size> {
    let step = (rows.len() / LOOK).max(1);
    let columns = triple
        .map(|index| grid.columns.get(index).map(|column| column.values.as_slice()).unwrap_or_default());
    let at = |row: &usize| columns.map(|values| values.get(*row).copied().unwrap_or(f64::NAN));
    let finite = |vector: &[f64; 3]| vector.iter().all(|value| value.is_finite());
    let vectors: Vec<[f64; 3]> = rows.iter().step_by(step).map(at).filter(finite).collect();
    let norm = |v: &[f64; 3]| v.iter().map(|value| value * value).sum::<f64>().sqrt();
    let mut norms: Vec<f64> = vectors.iter().map(norm).collect();
    norms.sort_by(f64::total_cmp);
    let median = share(&norms, 0.5)?;
    let (low, high) = (share(&norms, 0.05)?, share(&norms, 0.95)?);
    let jumps: Vec<f64> = (0..rows.len())
        .step_by(step)
        .filter_map(|from| {
            let this = at(rows.get(from)?);
            let after = rows.get(from + 1..(from + 1 + REPEATS).min(rows.len()))?;
            let next = after.iter().map(at).find(|next| *next != this)?;
            Some(norm(&[next[0] - this[0], next[1] - this[1], next[2] - this[2]]))
        })
        .filter(|jump| jump.is_finite())
        .collect();
    let first = vectors.first()?;
    Some(Size {
        median,
        least_share: low / high,
        constant: vectors.iter().all(|vector| vector == first),
        whole: vectors.iter().flatten().all(|value| value.fract() == 0.0),
        field: size_of(&vectors, &jumps),
        equal_magnitude: equal_magnitudes_of(&vectors),
    })
}

fn share(sorted: &[f64], share: f64) -> Option<f64> {
    let at = ((sorted.len().max(1) - 1) as f64 * share).round() as usize;
    sorted.get(at).copied()
}

/// Whether the numbers can be a magnetometer's in this unit: the field that they turned in is the Earth's, whatever the offset.
pub fn can_be_field(size: &Size, unit: &Unit) -> bool {
    if size.equal_magnitude.is_some() {
        return false;
    }
    let Some(field) = &size.field else { return true };
    (field.is_radius() || size.least_share > LEAST_SHARE) && field.can_be_earth(unit.convert(1.0))
}

/// The units of a field that the numbers can be in.
pub fn field_units(size: &Size) -> Vec<Unit> {
    Unit::all(Quantity::Field).filter(|unit| can_be_field(size, unit)).collect()
}

/// The units of time in which the sensor turns no faster than a board does, where there are such.
pub fn turning_units(clock: &Clock, size: &Size) -> Vec<Unit> {
    let per_row =
        size.field.as_ref().filter(|field| field.is_radius()).map(|field| field.jump_ut / field.field_ut);
    let slow = |unit: &&Unit| per_row.is_none_or(|turn| turn <= FASTEST_RADPS * unit.convert(clock.step));
    let slow: Vec<Unit> = clock.units.iter().filter(slow).cloned().collect();
    // Between units it decides; of the only one there is it says nothing.
    if slow.is_empty() { clock.units.clone() } else { slow }
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
            (48.13, 480.0, "uT"),
            (44.0, 200.0, "uT"),
            (481.3, -4000.0, "mG"),
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
        assert!(directions.equal_magnitude.is_some() && field_units(&directions).is_empty());
        for radius in [1.0, 4.4, 100.0] {
            let (grid, rows) = sphere(radius, 3.0);
            let found = size(&grid, [0, 1, 2], &rows).expect("numbers");
            assert!(field_units(&found).is_empty(), "{radius}: {:?}", field_units(&found));
        }
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
