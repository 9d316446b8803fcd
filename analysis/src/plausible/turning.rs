//! Whether gyro, magnetometer and accelerometer tell of one turning: the gyro's unit, and axes that stand for others.

use crate::plausible::field::centre;
use crate::plausible::follow::{Fit, Follow, LEAST, Pair};
use crate::plausible::orders::Order;
use crate::samples::samples::unique_rows;
use crate::samples::series::median;
use crate::table::Table;
use nalgebra::Vector3;

/// Axes that explain this share of what a vector does are right.
const FITS: f64 = 0.7;
/// Axes are wrong where they explain less than this …
const FAILS: f64 = 0.5;
/// … and others this much.
const OTHERS_FIT: f64 = 0.8;
/// Scale and offset of the magnetometer can be distinguished if this much of the scale is its own …
const DETERMINED: f64 = 0.2;
/// … and nearly where it is this much: then the scale is within a factor of three or so, …
const HARDLY_DETERMINED: f64 = 0.05;
/// … which is enough where it is wrong by more than this.
const FAR: f64 = 10.0;
/// The dip spreads by at most this share in the magnetometer's other order where it is the magnetometer that stands otherwise ...
const MAGNETOMETERS: f64 = 0.8;
/// ... and by at least so many times as much where it is the gyro; ...
const GYROS: f64 = 1.25;
/// ... below this nothing speaks against the magnetometer.
const UNDECIDED: f64 = 1.1;
/// A scale is wrong beyond this factor: no gyro is.
const SCALE: f64 = 2.5;
/// A unit is named within this factor of its size.
const UNIT: f64 = 1.3;
/// Units that rates are written in, and their size in rad/s. The third is what becomes of rad/s that were taken for degrees.
pub const UNITS: [(&str, f64); 4] = [
    ("deg/s", std::f64::consts::PI / 180.0),
    ("mdeg/s", std::f64::consts::PI / 180e3),
    ("rad/s, labelled as deg/s", 180.0 / std::f64::consts::PI),
    ("mrad/s, or 16.4 counts per deg/s", 1e-3),
];

/// Whose axes stand for others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Whose {
    /// The gyro's: accelerometer and magnetometer agree.
    Gyro,
    /// The accelerometer's: gyro and magnetometer agree.
    Accelerometer,
    /// The magnetometer's: gyro and accelerometer agree.
    Magnetometer,
    /// The gyro's or the magnetometer's: there is nothing to decide between them.
    GyroOrMagnetometer,
    /// The gyro's or the magnetometer's, and more likely this: gravity says nothing against it, and a gyro is mostly on one chip
    /// with the accelerometer.
    LikelyMagnetometer,
    /// The gyro's or the accelerometer's.
    GyroOrAccelerometer,
}

/// Axes that do not agree.
#[derive(Debug, Clone, PartialEq)]
pub struct OddAxes {
    /// Whose.
    pub whose: Whose,
    /// The orders in which they agree, as `--rotate` takes them for that sensor (for the gyro where it is not known whose);
    /// several where the log was turned about too few axes to tell. Of accelerometer and magnetometer the order or its
    /// opposite: a vector turns as its opposite does.
    pub orders: Vec<Order>,
    /// Share of the turning that the axes explain as they are …
    pub explained: f64,
    /// … and in that order.
    pub explained_then: f64,
    /// Stretches of the log.
    pub stretches: usize,
}

/// A gyro that is in another unit than it is read in.
#[derive(Debug, Clone, PartialEq)]
pub struct OddRate {
    /// What its numbers must be multiplied by.
    pub factor: f64,
    /// The unit they are in, and its size; `None` where none fits.
    pub unit: Option<(&'static str, f64)>,
    /// Share of the turning that is explained then.
    pub explained: f64,
    /// Stretches of the log.
    pub stretches: usize,
    /// Whether it is the field, or else gravity, that was followed.
    pub by_field: bool,
}

/// What does not agree.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Turning {
    /// Axes.
    pub axes: Option<OddAxes>,
    /// The gyro's unit.
    pub rate: Option<OddRate>,
}

/// Compares the three sensors with each other. A log with hardly any rotation gives no result.
pub fn judge(table: &Table) -> Turning {
    let (Some(time_s), Some(rate)) = (table.time_s, table.gyro_radps) else { return Turning::default() };
    let field = by_field(table, time_s, rate);
    let gravity = by_gravity(table, time_s, rate);
    let tells = |follow: &&Follow| follow.best.explained >= FITS;
    let (field, gravity) = (field.as_ref().filter(tells), gravity.as_ref().filter(tells));
    let mut axes = axes(field, gravity);
    if let (Some(odd), Some(field)) = (&mut axes, field)
        && odd.whose == Whose::GyroOrMagnetometer
        && let Some(more) = spreads_more(table, field)
    {
        // A shaken accelerometer does not show how the board turns, but the angle between field and gravity is more constant in
        // the right order anyway.
        let turned_back = more <= UNDECIDED;
        odd.whose = match more {
            _ if more <= MAGNETOMETERS => Whose::Magnetometer,
            _ if turned_back => Whose::LikelyMagnetometer,
            _ if more >= GYROS => Whose::Gyro,
            _ => Whose::GyroOrMagnetometer,
        };
        if turned_back {
            odd.orders = odd.orders.iter().map(Order::back).collect();
        }
    }
    Turning { axes, rate: scale(field, gravity) }
}

/// How many times as much the angle between field and gravity spreads with the magnetometer's axes in the order in which they
/// agree with the gyro's as it does with those of the log. `None` where one of them is not known.
fn spreads_more(table: &Table, field: &Follow) -> Option<f64> {
    let (accel, centre) = (table.accel_mps2?, centre(table)?);
    let order = field.best.order.back();
    if !field.equal.is_empty() {
        return None;
    }
    let (mut own, mut turned) = (Vec::new(), Vec::new());
    for row in unique_rows(table) {
        let down = Vector3::from_fn(|axis, _| accel[axis].get(row).copied().unwrap_or(f64::NAN));
        let h = Vector3::from(table.field(row)) - centre;
        let sine = |h: &Vector3<f64>| h.dot(&down) / (h.norm() * down.norm());
        let (one, two) = (sine(&h), sine(&Vector3::from_fn(|i, _| order.sign(i) * h[order.axis[i]])));
        if one.is_finite() && two.is_finite() {
            own.push(one.clamp(-1.0, 1.0).asin());
            turned.push(two.clamp(-1.0, 1.0).asin());
        }
    }
    let spread = |angles: &[f64]| {
        let mean = angles.iter().sum::<f64>() / angles.len() as f64;
        (angles.iter().map(|angle| (angle - mean).powi(2)).sum::<f64>() / angles.len() as f64).sqrt()
    };
    (own.len() >= LEAST).then(|| spread(&turned) / spread(&own)).filter(|more| more.is_finite())
}

fn by_field(table: &Table, time_s: &[f64], rate: [&[f64]; 3]) -> Option<Follow> {
    let rows = unique_rows(table);
    let mut square = 0.0;
    for axis in table.field_ut {
        let middle = median(&mut rows.iter().map(|&row| axis[row]).collect::<Vec<_>>());
        let mut off: Vec<f64> = rows.iter().map(|&row| (axis[row] - middle).abs()).collect();
        square += (1.5 * median(&mut off)).powi(2);
    }
    Pair { time_s, rate, vector: table.field_ut, rows: &rows, size: square.sqrt(), offset: true }.follow()
}

fn by_gravity(table: &Table, time_s: &[f64], rate: [&[f64]; 3]) -> Option<Follow> {
    let vector = table.accel_mps2?;
    let rows: Vec<usize> = (0..table.rows())
        .filter(|&row| vector.iter().all(|axis| axis.get(row).is_some_and(|value| value.is_finite())))
        .collect();
    let norm =
        |row: &usize| vector.iter().filter_map(|axis| axis.get(*row)).map(|v| v * v).sum::<f64>().sqrt();
    let size = median(&mut rows.iter().map(norm).collect::<Vec<_>>());
    Pair { time_s, rate, vector, rows: &rows, size, offset: false }.follow()
}

fn axes(field: Option<&Follow>, gravity: Option<&Follow>) -> Option<OddAxes> {
    let wrong = |follow: &Follow| {
        let Follow { own, best, .. } = follow;
        own.explained < FAILS && best.explained >= OTHERS_FIT && best.determined >= HARDLY_DETERMINED
    };
    let right = |follow: &Follow| follow.own.explained >= FITS;
    let odd = |whose: Whose, follow: &Follow, turned_back: bool| {
        let all = std::iter::once(follow.best.order).chain(follow.equal.iter().copied());
        OddAxes {
            whose,
            orders: all.map(|order| if turned_back { order.back() } else { order }).collect(),
            explained: follow.own.explained.max(0.0),
            explained_then: follow.best.explained,
            stretches: follow.stretches,
        }
    };
    match (field, gravity) {
        (Some(field), Some(gravity)) if right(field) && wrong(gravity) => {
            Some(odd(Whose::Accelerometer, gravity, true))
        }
        (Some(field), Some(gravity)) if wrong(field) && right(gravity) => {
            Some(odd(Whose::Magnetometer, field, true))
        }
        // Gravity is the sharper of the two: there is no soft iron in it.
        (Some(field), Some(gravity)) if wrong(field) && wrong(gravity) => {
            Some(odd(Whose::Gyro, gravity, false))
        }
        (Some(field), None) if wrong(field) => Some(odd(Whose::GyroOrMagnetometer, field, false)),
        (None, Some(gravity)) if wrong(gravity) => Some(odd(Whose::GyroOrAccelerometer, gravity, false)),
        _ => None,
    }
}

fn scale(field: Option<&Follow>, gravity: Option<&Follow>) -> Option<OddRate> {
    // Gravity where it explains enough: there is no offset and no soft iron in it.
    let gravity = gravity.filter(|follow| follow.best.explained >= OTHERS_FIT);
    let (follow, by_field) = gravity.map(|follow| (follow, false)).or(field.map(|follow| (follow, true)))?;
    let Fit { factor, explained, determined, .. } = follow.best;
    let far = !(FAR.recip()..=FAR).contains(&factor);
    let determined = determined >= DETERMINED || (determined >= HARDLY_DETERMINED && far);
    let odd =
        determined && factor > 0.0 && explained >= OTHERS_FIT && !(SCALE.recip()..=SCALE).contains(&factor);
    let unit = UNITS.into_iter().find(|(_, size)| (factor / size).ln().abs() < UNIT.ln());
    odd.then_some(OddRate { factor, unit, explained, stretches: follow.stretches, by_field })
}

#[cfg(test)]
mod tests;
