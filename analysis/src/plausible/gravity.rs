//! What the accelerometer reads when nothing but gravity acts on it.

use crate::samples::series::median;
use crate::table::Table;

/// Specific force at rest, m/s², with room for a sensor that was never calibrated.
const GRAVITY_MPS2: std::ops::RangeInclusive<f64> = 8.0..=11.8;
/// Units that accelerations are written in, and their size in m/s².
pub const UNITS: [(&str, f64); 2] = [("g", 9.806_65), ("mg", 9.806_65e-3)];
/// A board that is turned by hand reads gravity alone most of the time: this share of its readings …
const QUIET: f64 = 0.5;
/// … lies this near to their median.
const NEAR: f64 = 0.1;
/// A unit is named where gravity comes out within this share of its value.
const UNIT: f64 = 0.1;
/// Where nine tenths of the readings are below this, there is no gravity in them, m/s².
const WEIGHTLESS_MPS2: f64 = 6.0;
/// Fewer readings say nothing.
const LEAST: usize = 50;

/// An accelerometer whose rest is not that of gravity.
#[derive(Debug, Clone, PartialEq)]
pub struct OddGravity {
    /// Median magnitude as read, m/s².
    pub magnitude_mps2: f64,
    /// Readings.
    pub readings: usize,
    /// The unit that the columns are in, with its size in m/s²; `None` where none fits.
    pub unit: Option<(&'static str, f64)>,
    /// Whether there is no gravity in the readings at all (a phone's linear acceleration).
    pub weightless: bool,
}

/// What is odd about the accelerometer; `None` where nothing is, or where it never comes to rest.
pub fn odd(table: &Table) -> Option<OddGravity> {
    let accel = table.accel_mps2?;
    let mut sizes: Vec<f64> = (0..table.rows())
        .map(|row| {
            accel.iter().filter_map(|axis| axis.get(row)).map(|value| value * value).sum::<f64>().sqrt()
        })
        .filter(|size| size.is_finite())
        .collect();
    if sizes.len() < LEAST {
        return None;
    }
    let readings = sizes.len();
    let magnitude_mps2 = median(&mut sizes);
    let near = sizes.iter().filter(|size| (*size / magnitude_mps2 - 1.0).abs() < NEAR).count();
    let quiet = near as f64 >= QUIET * readings as f64 && magnitude_mps2 > 0.0;
    let most = *sizes.select_nth_unstable_by(readings * 9 / 10, f64::total_cmp).1;
    let unit = UNITS.into_iter().find(|(_, size)| (magnitude_mps2 * size / 9.806_65 - 1.0).abs() < UNIT);
    let unit = unit.filter(|_| quiet);
    let weightless = unit.is_none() && most < WEIGHTLESS_MPS2;
    let odd = (quiet && !GRAVITY_MPS2.contains(&magnitude_mps2)) || weightless;
    odd.then_some(OddGravity { magnitude_mps2, readings, unit, weightless })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(size: f64, shake: f64) -> Option<OddGravity> {
        let axes: [Vec<f64>; 3] = [0.0_f64, 2.1, 4.2].map(|phase| {
            (0..600_u32)
                .map(|i| {
                    let t = f64::from(i) * 0.01;
                    let noise = f64::from((i * 7919) % 101) / 50.0 - 1.0;
                    size * ((t + phase).sin() * (2.0_f64 / 3.0).sqrt() + shake * noise)
                })
                .collect()
        });
        let none: &[f64] = &[0.0; 600];
        odd(&Table {
            field_ut: [none; 3],
            accel_mps2: Some(axes.each_ref().map(Vec::as_slice)),
            ..Table::default()
        })
    }

    #[test]
    fn units_are_told_by_gravity() {
        for (size, unit) in [(1.0, "g"), (1000.0, "mg"), (981.0, "mg"), (1.04, "g")] {
            let odd = of(size, 0.02).unwrap_or_else(|| panic!("{size}"));
            assert_eq!(odd.unit.map(|(name, _)| name), Some(unit), "{odd:?}");
        }
        assert_eq!(of(16_384.0, 0.02).and_then(|odd| odd.unit), None);
        assert!(of(16_384.0, 0.02).is_some());
    }

    #[test]
    fn gravity_is_not_odd_and_a_shaken_board_tells_nothing() {
        for (size, shake) in [(9.81, 0.02), (10.3, 0.05), (9.4, 0.0), (9.81, 0.8), (30.0, 1.5)] {
            assert_eq!(of(size, shake), None, "{size} {shake}");
        }
        assert!(of(0.3, 0.9).is_some_and(|odd| odd.weightless));
        assert_eq!(odd(&Table::default()), None);
    }
}
