//! How far a board was tilted, as its accelerometer and its gyro tell it. The residual of the magnetometer cannot: an effect
//! that is not in the model spreads the readings as attitudes do.

use crate::samples::samples::Samples;

/// Below this tilt, degrees rms, a log carries no offset and matrix of its own.
pub const LEVEL_DEG: f64 = 12.0;
/// Turns are summed over so many seconds: in a banked turn the accelerometer believes itself level.
const SUMMED_S: f64 = 5.0;

fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (norm > 0.0 && norm.is_finite()).then(|| v.map(|x| x / norm))
}

/// Rms angle of down about its mean, degrees; with a gyro, of the turns across down too, whichever is more. `None` where too
/// few samples know down.
pub fn tilt_deg(samples: &Samples) -> Option<f64> {
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
    use crate::table::Table;

    fn tilt(roll: impl Fn(f64) -> f64) -> f64 {
        let n = 2000;
        let time: Vec<f64> = (0..n).map(|i| f64::from(i) * 0.02).collect();
        let g = 9.8;
        let y: Vec<f64> = time.iter().map(|t| -g * roll(*t).sin()).collect();
        let z: Vec<f64> = time.iter().map(|t| -g * roll(*t).cos()).collect();
        let zero = vec![0.0; n as usize];
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
        tilt_deg(&Samples::take(&table, &vec![false; n as usize], [true; 3])).expect("a tilt")
    }

    #[test]
    fn a_level_board_is_told_from_a_turned_one() {
        let wobble = tilt(|t| 0.1 * (3.0 * t).sin());
        assert!((wobble - 0.1_f64.to_degrees() / 2.0_f64.sqrt()).abs() < 0.5, "{wobble}");
        assert!(tilt(|t| t) > 80.0);
    }
}
