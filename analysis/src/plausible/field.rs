//! The size of the field that a log turned in: the radius of the sphere that the readings lie on, not their length, which
//! hard iron makes anything.

use crate::samples::samples::unique_rows;
use crate::samples::series::median;
use crate::table::Table;
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// Magnitudes that the field has on Earth, with room for indoor iron and gains, µT.
pub const EARTH_UT: std::ops::RangeInclusive<f64> = 12.0..=120.0;
/// Units that fields are written in, and their size in µT.
pub const UNITS: [(&str, f64); 5] = [("nT", 1e-3), ("mG", 0.1), ("G", 100.0), ("mT", 1e3), ("T", 1e6)];

/// At most this many readings are looked at.
const MOST: usize = 4000;
/// Fewer say nothing.
const LEAST: usize = 50;
/// Directions must cover at least this: the least eigenvalue of their scatter (1/3 is a whole sphere, 0 a plane).
const COVERED: f64 = 0.06;
/// Readings lie on a sphere up to this share of its radius: soft iron makes it an ellipsoid, disturbances make it thick.
const THICK: f64 = 0.3;
/// A sphere is this many of the sensor's steps large: the corners of a cube of one step lie on a sphere too.
const STEPS: f64 = 8.0;
/// A sphere too small for the Earth is one that the board was turned over where a reading lies this near to the one before,
/// of the radius: noise jumps.
pub(super) const JUMP: f64 = 0.7;
/// Without an accelerometer that shows the turning, a small sphere must be covered by this …
pub(super) const ALL_OVER: f64 = 0.15;
/// … and be this thin.
const THIN: f64 = 0.15;
/// Gravity was turned where its mean direction is shorter than this.
const TILTED: f64 = 0.8;
/// Without a sphere, readings that spread by more than this are in no field that a magnetometer is used in, µT.
const BEYOND_UT: f64 = 2000.0;

/// How large the field is, as far as a log tells.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldSize {
    /// µT as read.
    pub field_ut: f64,
    /// Whether this is the radius of a sphere that the readings lie on, or merely the least that it can be.
    pub is_radius: bool,
    /// Readings looked at.
    pub readings: usize,
}

impl FieldSize {
    /// The units that the columns may be in instead, with what the field is then, µT; the likeliest first.
    pub fn units(&self) -> Vec<(&'static str, f64)> {
        let least = if self.is_radius { 15.0 } else { 1.5 };
        let mut list: Vec<(&str, f64)> = UNITS
            .into_iter()
            .map(|(unit, size)| (unit, self.field_ut * size))
            .filter(|(_, field)| (least..=100.0).contains(field))
            .collect();
        let distance = |field: f64| (field / 45.0).ln().abs();
        list.sort_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        list
    }
}

/// The size of the field; `None` where the board was not turned enough to tell.
pub fn size(table: &Table) -> Option<FieldSize> {
    let rows = unique_rows(table);
    let (points, middle) = points(table, &rows)?;
    // Unit-free: the same answer in tesla and in nanotesla.
    let scale = median(&mut points.iter().map(|p| (p - middle).norm()).collect::<Vec<_>>());
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let unit: Vec<Vector3<f64>> = points.iter().map(|p| (p - middle) / scale).collect();
    let readings = unit.len();
    let step = (0..3).map(|axis| least_step(&unit, axis)).fold(0.0, f64::max);
    let mut jumps: Vec<f64> = rows
        .windows(2)
        .step_by(stride(&rows))
        .map(|pair| {
            (Vector3::from(table.field(pair[1])) - Vector3::from(table.field(pair[0]))).norm() / scale
        })
        .collect();
    let jump = median(&mut jumps);
    // What moves the readings of a board at rest can run over something round, but never over all of a sphere.
    let turned = |found: &Sphere| match tilted(table, &rows) {
        Some(tilted) => tilted,
        None => found.spread >= ALL_OVER && found.thickness <= THIN,
    };
    let is_one = |found: &Sphere| {
        let large = found.radius * scale >= *EARTH_UT.start();
        found.radius >= STEPS * step && (large || (jump <= JUMP * found.radius && turned(found)))
    };
    if let Some(found) = sphere(&unit).filter(is_one) {
        return Some(FieldSize { field_ut: found.radius * scale, is_radius: true, readings });
    }
    // Of the inner nine tenths: what one reading does is no spread.
    let mut lengths: Vec<f64> = unit.iter().map(Vector3::norm_squared).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.truncate(readings * 9 / 10);
    let spread_ut = (lengths.iter().sum::<f64>() / lengths.len() as f64).sqrt() * scale;
    (spread_ut > BEYOND_UT).then_some(FieldSize { field_ut: spread_ut, is_radius: false, readings })
}

/// The least distance between two values that occur on an axis.
pub(super) fn least_step(points: &[Vector3<f64>], axis: usize) -> f64 {
    let mut values: Vec<f64> = points.iter().map(|p| p[axis]).collect();
    values.sort_by(f64::total_cmp);
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 1e-9);
    let least = steps.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// Whether gravity shows that the board was turned; `None` without an accelerometer.
pub(super) fn tilted(table: &Table, rows: &[usize]) -> Option<bool> {
    let accel = table.accel_mps2?;
    let at = |row: usize| Vector3::from_fn(|axis, _| accel[axis].get(row).copied().unwrap_or(f64::NAN));
    let directions = rows.iter().map(|&row| at(row)).filter(|a| a.norm() > 0.0 && a.norm().is_finite());
    let (count, sum) =
        directions.fold((0_usize, Vector3::zeros()), |(n, sum), a| (n + 1, sum + a.normalize()));
    (count >= LEAST).then(|| sum.norm() < TILTED * f64::from(count as u32))
}

/// Between two readings that are looked at.
fn stride(rows: &[usize]) -> usize {
    rows.len().div_ceil(MOST).max(1)
}

/// Readings, evenly chosen, and their median; `None` where they are few, or no numbers.
pub(super) fn points(table: &Table, rows: &[usize]) -> Option<(Vec<Vector3<f64>>, Vector3<f64>)> {
    let chosen = rows.iter().step_by(stride(rows));
    let points: Vec<Vector3<f64>> = chosen.map(|&row| table.field(row).into()).collect();
    if points.len() < LEAST || points.iter().flatten().any(|value| !value.is_finite()) {
        return None;
    }
    let middle = Vector3::from_fn(|axis, _| median(&mut points.iter().map(|p| p[axis]).collect::<Vec<_>>()));
    Some((points, middle))
}

/// The centre of the sphere that the readings lie on: the offset, but for soft iron. `None` where they lie on none.
pub(crate) fn centre(table: &Table) -> Option<Vector3<f64>> {
    let (points, middle) = points(table, &unique_rows(table))?;
    let about: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
    sphere(&about).map(|found| middle + found.centre)
}

/// A sphere that points lie on.
pub(super) struct Sphere {
    centre: Vector3<f64>,
    /// Its radius.
    pub(super) radius: f64,
    /// Least eigenvalue of the scatter of the directions.
    pub(super) spread: f64,
    /// How far the points lie off it, 1σ, as a share of the radius.
    thickness: f64,
}

/// The sphere that most of the points lie on.
pub(super) fn sphere(points: &[Vector3<f64>]) -> Option<Sphere> {
    let mut kept: Vec<&Vector3<f64>> = points.iter().collect();
    let mut found = None;
    for _ in 0..4 {
        let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
        for p in &kept {
            let row = Vector4::new(2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0);
            normal += row * row.transpose();
            right += row * p.norm_squared();
        }
        let solution = normal.cholesky()?.solve(&right);
        let centre = Vector3::new(solution[0], solution[1], solution[2]);
        let radius = (solution[3] + centre.norm_squared()).sqrt();
        if !radius.is_finite() {
            return None;
        }
        let off = |p: &Vector3<f64>| ((p - centre).norm() - radius).abs();
        let usual = median(&mut points.iter().map(off).collect::<Vec<_>>());
        found = Some((centre, radius, usual));
        kept = points.iter().filter(|p| off(p) <= 4.5 * usual.max(1e-9 * radius)).collect();
        if kept.len() * 2 < points.len() {
            return None;
        }
    }
    let (centre, radius, usual) = found?;
    let scatter = kept.iter().fold(Matrix3::zeros(), |sum, p| {
        let direction = (*p - centre).normalize();
        sum + direction * direction.transpose()
    }) / kept.len() as f64;
    let mean = kept.iter().map(|p| (*p - centre).normalize()).sum::<Vector3<f64>>() / kept.len() as f64;
    let spread = (scatter - mean * mean.transpose()).symmetric_eigenvalues().min();
    // A median deviation is two thirds of a standard deviation.
    let thickness = 1.5 * usual / radius;
    (spread >= COVERED && thickness <= THICK).then_some(Sphere { centre, radius, spread, thickness })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of a field of 50 in some unit, around an offset, with soft iron.
    fn log(scale: f64, offset: f64, turn: f64) -> [Vec<f64>; 3] {
        let mut axes = [vec![], vec![], vec![]];
        for i in 0..2000 {
            let t = f64::from(i) / 2000.0;
            let z = turn * (2.0 * t - 1.0);
            let r = (1.0 - z * z).sqrt();
            let (sin, cos) = (97.0 * t).sin_cos();
            for (axis, value) in axes.iter_mut().zip([1.1 * r * cos, 0.95 * r * sin, z]) {
                axis.push(scale * (50.0 * value + offset));
            }
        }
        axes
    }

    fn of(axes: &[Vec<f64>; 3]) -> Option<FieldSize> {
        size(&Table { field_ut: axes.each_ref().map(Vec::as_slice), ..Table::default() })
    }

    #[test]
    fn the_radius_is_found_in_every_unit_whatever_the_offset() {
        for (unit, size) in UNITS.into_iter().chain([("uT", 1.0)]) {
            for offset in [0.0, 300.0, -2000.0] {
                let found = of(&log(1.0 / size, offset, 1.0)).expect(unit);
                assert!(
                    found.is_radius && (found.field_ut * size / 50.0 - 1.0).abs() < 0.1,
                    "{unit}: {found:?}"
                );
                if unit != "uT" {
                    assert_eq!(found.units().first().map(|(name, _)| *name), Some(unit), "{found:?}");
                }
            }
        }
    }

    #[test]
    fn what_was_hardly_turned_tells_nothing() {
        assert_eq!(of(&log(1.0, 20.0, 0.0)), None, "a plane");
        let rest = [0, 1, 2]
            .map(|axis| (0..500).map(|i| f64::from((i * (7 + axis)) % 11) * 0.1).collect::<Vec<_>>());
        assert_eq!(of(&rest), None, "rest");
        // The least noise there is: each axis between two of the sensor's steps, at all corners of a cube.
        let corner = |i: u32, axis: u32| f64::from((i.wrapping_mul(2_654_435_761) >> (9 + axis)) & 1) * 0.15;
        let cube = [0, 1, 2].map(|axis| (0..900).map(|i| corner(i, axis)).collect::<Vec<_>>());
        assert_eq!(of(&cube), None, "a cube");
        // And noise of many steps.
        let wide = |i: u32, k: u32| {
            f64::from((i.wrapping_mul(2_654_435_761 ^ (k * 77_777)) >> 8) % 1000) / 1000.0 - 0.5
        };
        let ball = |axis: u32| {
            (0..900).map(|i| wide(i, axis) + wide(i, axis + 3) + wide(i, axis + 6)).collect::<Vec<_>>()
        };
        assert_eq!(of(&[ball(0), ball(1), ball(2)]), None, "noise");
        assert_eq!(of(&[vec![1.0; 500], vec![2.0; 500], vec![3.0; 500]]), None, "constant");
        assert_eq!(of(&[vec![], vec![], vec![]]), None, "empty");
    }

    #[test]
    fn a_plane_in_nanotesla_is_still_beyond_every_field() {
        let found = of(&log(1000.0, 20.0, 0.0)).expect("beyond");
        assert!(
            !found.is_radius && found.units().first().is_some_and(|(unit, _)| *unit == "nT"),
            "{found:?}"
        );
    }
}
