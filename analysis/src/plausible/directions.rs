//! Readings that are directions: every magnitude is the same, whatever it is called, and no calibration is left in them.

use crate::samples::samples::unique_rows;
use crate::table::Table;

/// Fewer readings say nothing.
const LEAST: usize = 16;
/// At most this many are looked at.
const MOST: usize = 4000;
/// The sensor was turned where the mean direction is shorter than this.
const TURNED: f64 = 0.97;
/// No sensor repeats a magnitude to this share of it.
const EXACT: f64 = 1e-6;
/// Rounded directions repeat it to this many steps of their last digit …
const STEPS: f64 = 1.3;
/// … where those steps are finer than what a calibrated sensor scatters by, of the magnitude.
const FINE: f64 = 1.5e-3;

/// The magnitude that all readings of a log have; `None` where they differ, or the sensor was not turned.
pub fn equal_magnitudes(table: &Table) -> Option<f64> {
    let rows = unique_rows(table);
    let stride = rows.len().div_ceil(MOST).max(1);
    equal_magnitudes_of(&rows.iter().step_by(stride).map(|&row| table.field(row)).collect::<Vec<_>>())
}

/// The same of readings in any unit.
pub fn equal_magnitudes_of(readings: &[[f64; 3]]) -> Option<f64> {
    let norm = |v: &[f64; 3]| v.iter().map(|value| value * value).sum::<f64>().sqrt();
    let mut norms: Vec<f64> = readings.iter().map(norm).filter(|norm| norm.is_finite()).collect();
    if norms.len() < LEAST || norms.len() < readings.len() {
        return None;
    }
    norms.sort_by(f64::total_cmp);
    let share = |share: f64| norms.get(((norms.len() - 1) as f64 * share).round() as usize).copied();
    let (low, middle, high) = (share(0.05)?, share(0.5)?, share(0.95)?);
    if middle <= 0.0 {
        return None;
    }
    let mean = readings.iter().fold([0.0; 3], |sum: [f64; 3], v| {
        let length = norm(v).max(f64::MIN_POSITIVE);
        [sum[0] + v[0] / length, sum[1] + v[1] / length, sum[2] + v[2] / length]
    });
    let turned = norm(&mean) < TURNED * readings.len() as f64;
    let step = (0..3).map(|axis| least_step(readings, axis)).fold(0.0, f64::max);
    let scatter = high - low;
    let equal = scatter <= EXACT * middle || scatter <= (STEPS * step).min(FINE * middle);
    (turned && equal).then_some(middle)
}

/// The least distance between two values of an axis.
fn least_step(readings: &[[f64; 3]], axis: usize) -> f64 {
    let mut values: Vec<f64> = readings.iter().map(|v| v[axis]).collect();
    values.sort_by(f64::total_cmp);
    let most = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 1e-9 * most);
    let least = steps.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spiral(length: f64, digits: i32, noise: f64, offset: f64) -> Vec<[f64; 3]> {
        let round = |value: f64| (value * 10_f64.powi(digits)).round() / 10_f64.powi(digits);
        (0..200_u32)
            .map(|i| {
                let z = 1.0 - (f64::from(i) + 0.5) / 100.0;
                let (r, turn) = ((1.0 - z * z).sqrt(), f64::from(i) * 2.399_963);
                let wobble = |k: u32| {
                    noise * (f64::from(i.wrapping_mul(2_654_435_761 ^ (k * 7919)) >> 16) / 32_768.0 - 1.0)
                };
                [
                    round(length * r * turn.cos() + wobble(1) + offset),
                    round(length * r * turn.sin() + wobble(2)),
                    round(length * z + wobble(3)),
                ]
            })
            .collect()
    }

    #[test]
    fn directions_of_any_length_are_known_and_readings_of_a_sensor_are_not() {
        for (length, digits) in [(1.0, 3), (1.0, 4), (48.0, 5), (48.0, 2), (100.0, 6), (1e-4, 12)] {
            assert!(equal_magnitudes_of(&spiral(length, digits, 0.0, 0.0)).is_some(), "{length} {digits}");
        }
        for (noise, digits, offset) in
            [(0.3, 1, 0.0), (0.3, 5, 0.0), (0.05, 2, 0.0), (0.0, 4, 0.5), (0.1, 0, 0.0)]
        {
            assert_eq!(
                equal_magnitudes_of(&spiral(48.0, digits, noise, offset)),
                None,
                "{noise} {digits} {offset}"
            );
        }
        assert_eq!(equal_magnitudes_of(&[[1.0, 2.0, 3.0]; 100]), None, "at rest");
        assert_eq!(equal_magnitudes_of(&[]), None);
    }
}
