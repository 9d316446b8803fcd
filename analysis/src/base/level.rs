//! How far a board was tilted, as its accelerometer and its gyro tell it. The residual of the magnetometer cannot: an effect
//! that is not in the model spreads the readings as attitudes do.

use crate::bounds::{FALLING, FLIES};
use crate::samples::samples::Samples;
use crate::samples::series::median;
use crate::table::Table;

/// Turns are summed over so many seconds: in a banked turn the accelerometer believes itself level.
const SUMMED_S: f64 = 5.0;

/// Specific force is averaged over so many seconds, which is longer than what shakes a board ...
const AVERAGED_S: f64 = 0.5;
/// ... from so many rows at least.
const AVERAGED_ROWS: usize = 3;

/// Whether the board fell now and then: what flies so is held by nothing but its thrust, which keeps to the board's own axis
/// however it turns, so that its accelerometer tells no attitude. Level flight falls at no time.
fn flies_freely(table: &Table) -> bool {
    let (Some(time), Some(accel)) = (table.time_s, table.accel_mps2) else { return false };
    let vectors = (0..time.len()).map(|row| accel.map(|axis| axis[row]));
    let known: Vec<(f64, [f64; 3])> =
        time.iter().copied().zip(vectors).filter(|(_, a)| a.iter().all(|value| value.is_finite())).collect();
    let (mut from, mut to, mut sum) = (0, 0, [0.0; 3]);
    let mut means = Vec::with_capacity(known.len());
    for (now, _) in &known {
        while to < known.len() && known[to].0 <= now + 0.5 * AVERAGED_S {
            sum = core::array::from_fn(|axis| sum[axis] + known[to].1[axis]);
            to += 1;
        }
        while known[from].0 < now - 0.5 * AVERAGED_S {
            sum = core::array::from_fn(|axis| sum[axis] - known[from].1[axis]);
            from += 1;
        }
        if to - from >= AVERAGED_ROWS {
            let norm = sum.iter().map(|value| value * value).sum::<f64>().sqrt();
            means.push(norm / (to - from) as f64);
        }
    }
    let usual = median(&mut means);
    let falling = means.iter().filter(|mean| **mean < FALLING * usual).count();
    falling as f64 > FLIES * means.len() as f64
}

fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (norm > 0.0 && norm.is_finite()).then(|| v.map(|x| x / norm))
}

/// Rms angle of down about its mean, degrees; with a gyro, of the turns across down too, whichever is more. `None` where too
/// few samples know down, or where what they know is no down.
pub fn tilt_deg(samples: &Samples, table: &Table) -> Option<f64> {
    if flies_freely(table) {
        return None;
    }
    let down: Vec<[f64; 3]> = samples.readings.iter().filter_map(|reading| reading.down).collect();
    if down.len() * 10 <= 3 * samples.len() {
        return None;
    }
    let sum = down.iter().fold([0.0; 3], |sum, d| core::array::from_fn(|i| sum[i] + d[i]));
    let Some(mean) = unit(sum) else { return Some(180.0) };
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let angle = |d: &[f64; 3]| dot(d, &mean).clamp(-1.0, 1.0).acos();
    let seen = (down.iter().map(|d| angle(d).powi(2)).sum::<f64>() / down.len() as f64).sqrt();
    Some(seen.max(turned(samples, &mean)).to_degrees())
}

/// Rms of the turns across `mean`, each fading after some seconds, rad; 0 without time or gyro.
fn turned(samples: &Samples, mean: &[f64; 3]) -> f64 {
    let Some(time) = &samples.time else { return 0.0 };
    let (mut angle, mut squares) = ([0.0; 3], 0.0);
    for (at, reading) in samples.readings.iter().enumerate().skip(1) {
        let step = (time[at] - time[at - 1]).clamp(0.0, 1.0);
        let fade = (-step / SUMMED_S).exp();
        let rate = reading.turn_radps.unwrap_or_default();
        let along: f64 = rate.iter().zip(mean).map(|(w, d)| w * d).sum();
        angle = core::array::from_fn(|i| angle[i] * fade + (rate[i] - along * mean[i]) * step);
        squares += angle.iter().map(|a| a * a).sum::<f64>();
    }
    (squares / samples.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 2000;

    /// A board whose accelerometer feels `thrust` (of gravity), leaning by `roll`.
    fn tilt(roll: impl Fn(f64) -> f64, thrust: impl Fn(f64) -> f64) -> Option<f64> {
        let time: Vec<f64> = (0..N).map(|i| i as f64 * 0.02).collect();
        let y: Vec<f64> = time.iter().map(|t| -9.8 * thrust(*t) * roll(*t).sin()).collect();
        let z: Vec<f64> = time.iter().map(|t| -9.8 * thrust(*t) * roll(*t).cos()).collect();
        let zero = vec![0.0; N];
        let field: Vec<f64> = time.iter().map(|t| 30.0 + t.sin()).collect();
        let table = Table::from_columns([
            ("t_s", time.as_slice()),
            ("mx_ut", field.as_slice()),
            ("my_ut", field.as_slice()),
            ("mz_ut", field.as_slice()),
            ("ax_mps2", zero.as_slice()),
            ("ay_mps2", y.as_slice()),
            ("az_mps2", z.as_slice()),
        ])
        .expect("a table");
        tilt_deg(&Samples::take(&table, &[false; N], [true; 3]), &table)
    }

    #[test]
    fn a_level_board_is_told_from_a_turned_one() {
        let wobble = tilt(|t| 0.1 * (3.0 * t).sin(), |_| 1.0).expect("a tilt");
        assert!((wobble - 0.1_f64.to_degrees() / 2.0_f64.sqrt()).abs() < 0.5, "{wobble}");
        assert!(tilt(|t| t, |_| 1.0).expect("a tilt") > 80.0);
    }

    #[test]
    fn thrust_is_no_gravity() {
        let lean = |t: f64| 0.1 * (3.0 * t).sin();
        // Thrust off for a second of every ten.
        let falls = |t: f64| if t % 10.0 < 1.0 { 0.2 } else { 1.0 };
        assert_eq!(tilt(lean, falls), None);
        // A shaken board and one that climbs and sinks are level all the same.
        assert!(tilt(lean, |t| 1.0 + 0.9 * (40.0 * t).sin()).is_some());
        assert!(tilt(lean, |t| 1.0 + 0.3 * t.sin()).is_some());
    }
}
