//! The spectrum of the residuals, averaged over pieces of the log (Welch's method).

use crate::samples::fft;
use crate::samples::series::median;
use serde::Serialize;

/// Samples of a piece; pieces overlap by half.
const PIECE: usize = 1024;
const SHORTEST: usize = 64;

/// Amplitude density of the residuals by frequency.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Density {
    /// Frequency, Hz.
    pub hz: Vec<f32>,
    /// Of offset and matrix only, µT/√Hz.
    pub without: Vec<f32>,
    /// Of the whole model, µT/√Hz.
    pub with: Vec<f32>,
    /// That of white noise of the floor's size, µT/√Hz; `None` where the floor is not known.
    pub noise: Option<f32>,
}

/// The spectra of two residuals, one value a sample in the order of time; samples are taken as evenly spaced by their median
/// step. `None` without a clock, or of a log too short.
pub fn density(time_s: Option<&[f64]>, without: &[f64], with: &[f64], floor_ut: f64) -> Option<Density> {
    let time_s = time_s?;
    let mut steps: Vec<f64> =
        time_s.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    if steps.len() < SHORTEST || without.len() != with.len() {
        return None;
    }
    let step_s = median(&mut steps);
    let mut piece = PIECE;
    while piece > without.len() {
        piece /= 2;
    }
    if piece < SHORTEST || !(step_s > 0.0 && step_s.is_finite()) {
        return None;
    }
    let window: Vec<f64> = (0..piece)
        .map(|i| 0.5 - 0.5 * (std::f64::consts::TAU * (i as f64 + 0.5) / piece as f64).cos())
        .collect();
    let power: f64 = window.iter().map(|w| w * w).sum();
    let mut sums = vec![(0.0, 0.0); piece / 2];
    let mut pieces = 0_u32;
    for from in (0..=without.len() - piece).step_by(piece / 2) {
        // Both at once: one as the real part, the other as the imaginary.
        let mut data: Vec<(f64, f64)> = without
            .iter()
            .zip(with)
            .skip(from)
            .zip(&window)
            .map(|((a, b), w)| (finite(*a) * w, finite(*b) * w))
            .collect();
        fft::forward(&mut data);
        for (bin, sum) in sums.iter_mut().enumerate().skip(1) {
            let ((a, b), (c, d)) = (data[bin], data[piece - bin]);
            sum.0 += (0.25 * ((a + c).powi(2) + (b - d).powi(2))) / power;
            sum.1 += (0.25 * ((a - c).powi(2) + (b + d).powi(2))) / power;
        }
        pieces += 1;
    }
    let root = |sum: f64| (2.0 * step_s * sum / f64::from(pieces.max(1))).sqrt() as f32;
    let bins = sums.iter().enumerate().skip(1);
    Some(Density {
        hz: bins.clone().map(|(bin, _)| (bin as f64 / (piece as f64 * step_s)) as f32).collect(),
        without: bins.clone().map(|(_, sum)| root(sum.0)).collect(),
        with: bins.map(|(_, sum)| root(sum.1)).collect(),
        noise: (floor_ut > 0.0).then(|| (floor_ut * (2.0 * step_s).sqrt()) as f32),
    })
}

fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_stands_where_it_is_and_the_power_is_kept() {
        let n = 4096;
        let time: Vec<f64> = (0..n).map(|i| i as f64 / 100.0).collect();
        let tone: Vec<f64> = time.iter().map(|t| (std::f64::consts::TAU * 12.5 * t).sin()).collect();
        let zero = vec![0.0; n];
        let density = density(Some(&time), &tone, &zero, 0.5).expect("long enough");
        let (at, _) =
            density.without.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).expect("there are bins");
        assert!((density.hz[at] - 12.5).abs() < 0.1, "{}", density.hz[at]);
        let df = f64::from(density.hz[1] - density.hz[0]);
        let variance: f64 = density.without.iter().map(|a| f64::from(*a).powi(2) * df).sum();
        assert!((variance - 0.5).abs() < 0.01, "{variance}");
        assert!(density.with.iter().all(|value| *value < 1e-6));
        assert!(super::density(None, &tone, &zero, 0.5).is_none());
    }
}
