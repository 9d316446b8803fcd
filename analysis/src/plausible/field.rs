//! The size of the field that a log turned in: the radius of the sphere that the readings lie on, not their length, which
//! hard iron makes anything.

use crate::samples::samples::unique_rows;
use crate::samples::series::median;
use crate::table::Table;
use nalgebra::{Matrix3, Matrix4, Vector2, Vector3, Vector4};
use std::ops::RangeInclusive;

/// Magnitude of the field where people calibrate, µT: the Earth's is 22 to 67 µT, and the rest is a margin for iron in buildings. This
/// range alone decides the unit of a magnetometer: the sphere's radius in that unit must lie in it.
pub const EARTH_UT: RangeInclusive<f64> = 20.0..=70.0;

/// At most this many readings are looked at.
const MOST: usize = 4000;
/// Fewer say nothing.
const LEAST: usize = 16;
/// Directions must cover at least this: the least eigenvalue of their scatter (1/3 is a whole sphere, 0 a plane).
const COVERED: f64 = 0.06;
/// Readings lie on a sphere up to this share of its radius: soft iron makes it an ellipsoid, disturbances make it thick.
const THICK: f64 = 0.3;
/// A sphere is this many of the sensor's steps large: the corners of a cube of one step lie on a sphere too.
const STEPS: f64 = 8.0;
/// Noise jumps: on a sphere that was turned through, a reading lies this near to the one before, of the radius.
pub(super) const JUMP: f64 = 0.7;
/// Readings that are not shown to follow each other must cover this of the directions …
pub(super) const ALL_OVER: f64 = 0.15;
/// … and be this thin.
const THIN: f64 = 0.15;
/// Noise fills a ball; readings on a shell this thin were turned, even where each is far from the one before.
const SHELL: f64 = 0.06;
/// Gravity was turned where its mean direction is shorter than this.
const TILTED: f64 = 0.8;
/// Without a sphere, readings that spread by more than this are in no field that a magnetometer is used in, µT.
const BEYOND_UT: f64 = 2000.0;
/// Gains of soft iron that do not show without a sphere.
const MOST_GAIN: f64 = 1.5;
/// The axes of an ellipsoid lie within this many of its thickness (1σ) of its mean radius.
const AXES: f64 = 2.5;
/// Soft iron and disturbances are one deviation for each direction, not for each reading: so many are independent.
const INDEPENDENT: f64 = 10.0;
/// Radius of the circle that a turn about one axis leads around, µT: the horizontal field is smaller near the magnetic poles only.
const LEAST_CIRCLE_UT: f64 = 6.0;
/// Largest gap between directions on a circle that counts as closed, degrees.
const MOST_GAP_DEG: f64 = 100.0;

/// What the size of the field is concluded from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evidence {
    /// A sphere that the readings lie on, certain enough to contradict a unit that somebody states.
    Sphere,
    /// A part of a sphere, or a small one: enough to choose between units, not to contradict.
    PartOfSphere,
    /// A closed circle: one axis was turned.
    Circle,
    /// The spread of the readings alone.
    Spread,
}

/// How large the field is, as far as the readings tell, in the unit of the readings.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldSize {
    /// The radius; for a circle and a spread the least that the field can be.
    pub field_ut: f64,
    /// Bounds of the field.
    pub bounds_ut: [f64; 2],
    /// What it is concluded from.
    pub evidence: Evidence,
    /// Median distance from a reading to the next.
    pub jump_ut: f64,
    /// Readings looked at.
    pub readings: usize,
}

impl FieldSize {
    /// Whether the field can be the Earth's when one unit of the readings is this many µT.
    pub fn can_be_earth(&self, ut_per_unit: f64) -> bool {
        let [least, most] = self.bounds_ut.map(|bound| bound * ut_per_unit);
        least <= *EARTH_UT.end() && most >= *EARTH_UT.start()
    }

    /// Whether the readings, taken for µT, cannot be of the Earth's field.
    pub fn contradicts_earth(&self) -> bool {
        match self.evidence {
            Evidence::Sphere => !self.can_be_earth(1.0),
            Evidence::Circle => self.bounds_ut[0] > *EARTH_UT.end(),
            Evidence::Spread => self.field_ut > BEYOND_UT,
            Evidence::PartOfSphere => false,
        }
    }

    /// Whether this is the radius of a sphere that the readings lie on, or merely the least that the field can be.
    pub fn is_radius(&self) -> bool {
        matches!(self.evidence, Evidence::Sphere | Evidence::PartOfSphere)
    }
}

/// The size of the field of a log in µT; `None` where it says nothing of it.
pub fn size(table: &Table) -> Option<FieldSize> {
    evidence(table).filter(|found| found.evidence == Evidence::Sphere || found.contradicts_earth())
}

/// The same, whatever it is concluded from; `None` where there are too few readings, or only one.
pub(crate) fn evidence(table: &Table) -> Option<FieldSize> {
    let rows = unique_rows(table);
    let stride = stride(rows.len());
    let at = |row: usize| Vector3::from(table.field(row));
    let points: Vec<Vector3<f64>> = rows.iter().step_by(stride).map(|&row| at(row)).collect();
    let jumps = rows.windows(2).step_by(stride).map(|pair| (at(pair[1]) - at(pair[0])).norm());
    judge(&points, jumps, tilted(table, &rows), Some(*EARTH_UT.start()))
}

/// The size of the field of readings in an unknown unit; `None` where there are too few, or only one. `jumps` are distances from a reading
/// to the next that differs.
pub fn size_of(readings: &[[f64; 3]], jumps: &[f64]) -> Option<FieldSize> {
    let points: Vec<Vector3<f64>> =
        readings.iter().step_by(stride(readings.len())).map(|reading| Vector3::from(*reading)).collect();
    judge(&points, jumps.iter().copied(), None, None)
}

/// Judges points in their order. `large` is the radius from which on a sphere needs no further proof.
fn judge(
    points: &[Vector3<f64>],
    jumps: impl Iterator<Item = f64>,
    tilted: Option<bool>,
    large: Option<f64>,
) -> Option<FieldSize> {
    if points.len() < LEAST || points.iter().flatten().any(|value| !value.is_finite()) {
        return None;
    }
    let middle = middle_of(points);
    // Unit-free: the same answer in tesla and in nanotesla.
    let scale = median(&mut points.iter().map(|p| (p - middle).norm()).collect::<Vec<_>>());
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let unit: Vec<Vector3<f64>> = points.iter().map(|p| (p - middle) / scale).collect();
    let readings = unit.len();
    let step = (0..3).map(|axis| least_step(&unit, axis)).fold(0.0, f64::max);
    let jump = median(&mut jumps.map(|jump| jump / scale).collect::<Vec<_>>());
    let field_size = |size: f64, bounds: [f64; 2], evidence: Evidence| FieldSize {
        field_ut: size * scale,
        bounds_ut: bounds.map(|bound| bound * scale),
        evidence,
        jump_ut: jump * scale,
        readings,
    };
    // Of the inner nine tenths: what one reading does is not a spread.
    let mut lengths: Vec<f64> = unit.iter().map(Vector3::norm_squared).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.truncate((readings * 9 / 10).max(1));
    let spread = (lengths.iter().sum::<f64>() / lengths.len() as f64).sqrt();
    if let Some(found) = sphere(&unit).filter(|found| found.radius >= STEPS * step) {
        let follows = jump <= JUMP * found.radius;
        // What moves the readings of a board at rest can run over something round, but never over all of a sphere.
        let all_over = found.spread >= ALL_OVER && found.thickness <= THIN;
        let is_large = large.is_some_and(|large| found.radius * scale >= large);
        // About the vertical alone a field runs around a circle: a sphere without tilt is none of the turning.
        let is_turned = match tilted {
            Some(tilted) => tilted && (is_large || follows || all_over),
            None => is_large || all_over,
        };
        let bounds = [found.radius - found.error, found.radius + found.error];
        if is_turned {
            return Some(field_size(found.radius, bounds, Evidence::Sphere));
        }
        let is_shell = found.thickness <= if follows { THIN } else { SHELL };
        if tilted.is_none() && is_shell {
            return Some(field_size(found.radius, bounds, Evidence::PartOfSphere));
        }
    }
    let circle = circle(&unit).filter(|[radius, _]| *radius >= STEPS * step && jump <= JUMP * radius);
    if let Some([radius, error]) = circle {
        let least = radius - error;
        return Some(field_size(
            least,
            [least, *EARTH_UT.start() / LEAST_CIRCLE_UT * (radius + error)],
            Evidence::Circle,
        ));
    }
    // Half the diameter of what the readings fill, about; soft iron widens that.
    Some(field_size(spread, [spread / MOST_GAIN, f64::INFINITY], Evidence::Spread))
}

/// Median of each axis.
fn middle_of(points: &[Vector3<f64>]) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| median(&mut points.iter().map(|p| p[axis]).collect::<Vec<_>>()))
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
fn stride(rows: usize) -> usize {
    rows.div_ceil(MOST).max(1)
}

/// Readings, evenly chosen, and their median; `None` where they are few, or no numbers.
pub(super) fn points(table: &Table, rows: &[usize]) -> Option<(Vec<Vector3<f64>>, Vector3<f64>)> {
    let chosen = rows.iter().step_by(stride(rows.len()));
    let points: Vec<Vector3<f64>> = chosen.map(|&row| table.field(row).into()).collect();
    if points.len() < LEAST || points.iter().flatten().any(|value| !value.is_finite()) {
        return None;
    }
    let middle = Vector3::from_fn(|axis, _| median(&mut points.iter().map(|p| p[axis]).collect::<Vec<_>>()));
    Some((points, middle))
}

/// The centre of the sphere that the readings lie on: the offset, but for soft iron. `None` where they lie on none.
pub(crate) fn centre(table: &Table) -> Option<Vector3<f64>> {
    let rows = unique_rows(table);
    let points: Vec<Vector3<f64>> =
        rows.iter().step_by(stride(rows.len())).map(|&row| table.field(row).into()).collect();
    if points.len() < LEAST || points.iter().flatten().any(|value| !value.is_finite()) {
        return None;
    }
    let middle = middle_of(&points);
    let about: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
    sphere(&about).map(|found| middle + found.centre)
}

/// A sphere that points lie on.
pub(super) struct Sphere {
    centre: Vector3<f64>,
    /// Its radius.
    pub(super) radius: f64,
    /// How far the field can be from the radius: the axes of an ellipsoid, and what the directions leave open.
    error: f64,
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
        let inverse = normal.cholesky()?;
        let solution = inverse.solve(&right);
        let centre = Vector3::new(solution[0], solution[1], solution[2]);
        let radius = (solution[3] + centre.norm_squared()).sqrt();
        if !radius.is_finite() {
            return None;
        }
        let off = |p: &Vector3<f64>| ((p - centre).norm() - radius).abs();
        let usual = median(&mut points.iter().map(off).collect::<Vec<_>>());
        // Of the radius with the centre: its variance per unit variance of one squared distance.
        let slope = Vector4::new(centre.x, centre.y, centre.z, 0.5) / radius;
        let variance = slope.dot(&inverse.solve(&slope)) * kept.len() as f64;
        found = Some((centre, radius, usual, variance));
        kept = points.iter().filter(|p| off(p) <= 4.5 * usual.max(1e-9 * radius)).collect();
        if kept.len() * 2 < points.len() {
            return None;
        }
    }
    let (centre, radius, usual, variance) = found?;
    let scatter = kept.iter().fold(Matrix3::zeros(), |sum, p| {
        let direction = (*p - centre).normalize();
        sum + direction * direction.transpose()
    }) / kept.len() as f64;
    let mean = kept.iter().map(|p| (*p - centre).normalize()).sum::<Vector3<f64>>() / kept.len() as f64;
    let spread = (scatter - mean * mean.transpose()).symmetric_eigenvalues().min();
    // A median deviation is two thirds of a standard deviation.
    let thickness = 1.5 * usual / radius;
    let of_fit = 2.0 * (variance.max(0.0) / INDEPENDENT).sqrt() * 2.0 * radius * thickness * radius;
    let error = AXES * thickness * radius + of_fit;
    (spread >= COVERED && thickness <= THICK).then_some(Sphere { centre, radius, error, spread, thickness })
}

/// Radius, and its uncertainty, of a closed circle that the points lie on, seen along the direction in which they vary least.
fn circle(points: &[Vector3<f64>]) -> Option<[f64; 2]> {
    let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let scatter = points.iter().fold(Matrix3::zeros(), |sum, p| sum + (p - mean) * (p - mean).transpose());
    let eigen = scatter.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let [a, b] = [(least + 1) % 3, (least + 2) % 3].map(|axis| eigen.eigenvectors.column(axis).into_owned());
    let flat: Vec<Vector2<f64>> =
        points.iter().map(|p| Vector2::new(a.dot(&(p - mean)), b.dot(&(p - mean)))).collect();
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for p in &flat {
        let row = Vector3::new(2.0 * p.x, 2.0 * p.y, 1.0);
        normal += row * row.transpose();
        right += row * p.norm_squared();
    }
    let solution = normal.cholesky()?.solve(&right);
    let centre = Vector2::new(solution[0], solution[1]);
    let radius = (solution[2] + centre.norm_squared()).sqrt();
    let usual = median(&mut flat.iter().map(|p| ((p - centre).norm() - radius).abs()).collect::<Vec<_>>());
    let thickness = 1.5 * usual / radius;
    let mut angles: Vec<f64> = flat.iter().map(|p| (p.y - centre.y).atan2(p.x - centre.x)).collect();
    angles.sort_by(f64::total_cmp);
    let around = angles.first()? + std::f64::consts::TAU;
    let gap = angles.iter().skip(1).chain([&around]).zip(&angles).map(|(next, this)| next - this);
    let closed = gap.fold(0.0, f64::max) <= MOST_GAP_DEG.to_radians();
    (closed && thickness <= THIN).then_some([radius, AXES * thickness * radius])
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNITS: [(&str, f64); 6] =
        [("uT", 1.0), ("nT", 1e-3), ("mG", 0.1), ("G", 100.0), ("mT", 1e3), ("T", 1e6)];

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
        for (unit, ut_per_unit) in UNITS {
            for offset in [0.0, 300.0, -2000.0] {
                let axes = log(1.0 / ut_per_unit, offset, 1.0);
                let found = of(&axes).expect(unit);
                assert!((found.field_ut * ut_per_unit / 50.0 - 1.0).abs() < 0.1, "{unit}: {found:?}");
                let readings: Vec<[f64; 3]> =
                    (0..2000).map(|i| [axes[0][i], axes[1][i], axes[2][i]]).collect();
                let found = size_of(&readings, &[]).expect(unit);
                let can: Vec<&str> =
                    UNITS.iter().filter(|(_, ut)| found.can_be_earth(*ut)).map(|(name, _)| *name).collect();
                assert_eq!(can, [unit], "{found:?}");
            }
        }
    }

    #[test]
    fn a_radius_between_the_units_is_in_none_of_them() {
        for radius in [4.4, 10.0, 100.0, 160.0] {
            let axes = log(radius / 50.0, 30.0, 1.0);
            let readings: Vec<[f64; 3]> = (0..2000).map(|i| [axes[0][i], axes[1][i], axes[2][i]]).collect();
            let found = size_of(&readings, &[]).expect("a sphere");
            let can: Vec<&str> =
                UNITS.iter().filter(|(_, ut)| found.can_be_earth(*ut)).map(|(name, _)| *name).collect();
            assert!(can.is_empty(), "{radius}: {can:?} {found:?}");
            assert!(of(&axes).is_some_and(|found| found.contradicts_earth()), "{radius}");
        }
    }

    #[test]
    fn one_turn_about_one_axis_bounds_the_field() {
        let axes = log(1.0, 20.0, 0.0);
        let readings: Vec<[f64; 3]> = (0..2000).map(|i| [axes[0][i], axes[1][i], axes[2][i]]).collect();
        let found = size_of(&readings, &[0.0; 9]).expect("a circle");
        assert_eq!(found.evidence, Evidence::Circle, "{found:?}");
        assert!(found.bounds_ut[0] < 55.0 && found.bounds_ut[1] > 100.0, "{found:?}");
        let can: Vec<&str> =
            UNITS.iter().filter(|(_, ut)| found.can_be_earth(*ut)).map(|(name, _)| *name).collect();
        // Soft iron makes the circle of 52 an ellipse: what is not a circle bounds less.
        assert_eq!(can, ["uT", "mG"], "{found:?}");
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
        assert!(!found.is_radius() && found.can_be_earth(1e-3), "{found:?}");
    }
}
