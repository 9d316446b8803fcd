//! Residuals in bins: against a column, and by their size.

use serde::Serialize;

/// Bins of a column.
const BINS: usize = 32;
/// Bins of a histogram.
const BARS: usize = 61;
/// A histogram reaches so many times the rms of what is left.
const REACH: f64 = 4.0;
/// Columns of fewer different samples are not drawn.
const FEWEST: usize = 8;

/// Residuals in bins of equal width over a column, rms in each.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Against {
    /// The column, `time`, `azimuth`, `elevation` or `rate of turn`.
    pub name: String,
    /// Its unit where it is known.
    pub unit: &'static str,
    /// Middle of each bin that has samples.
    pub at: Vec<f32>,
    /// Samples in it.
    pub samples: Vec<u32>,
    /// Rms of the residual of offset and matrix only, µT.
    pub without_ut: Vec<f32>,
    /// Rms of what the effects of the model make of the magnitude, with the noise floor next to it, µT.
    pub effect_ut: Vec<f32>,
    /// Mean of the residual, µT.
    pub mean_ut: Vec<f32>,
    /// Rms of the residual, µT.
    pub rms_ut: Vec<f32>,
}

/// The residuals of the samples of one log, all of equal length.
pub struct Residuals<'a> {
    /// Of offset and matrix only, µT.
    pub without_ut: &'a [f64],
    /// Of the whole model, µT.
    pub with_ut: &'a [f64],
    /// What noise leaves of the magnitude, µT; zero where it is not known.
    pub floor_ut: f64,
}

/// Sums of a bin.
#[derive(Default, Clone)]
struct Bin {
    n: u32,
    without: f64,
    effect: f64,
    sum: f64,
    squares: f64,
}

/// Bins residuals over a column; `None` where it is constant or empty.
pub fn against(name: &str, unit: &'static str, values: &[f64], residuals: &Residuals) -> Option<Against> {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let (least, most) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    if finite().count() < FEWEST || (most - least) <= 1e-9 * most.abs().max(least.abs()) {
        return None;
    }
    let width = (most - least) / BINS as f64;
    let mut bins = vec![Bin::default(); BINS];
    for ((value, without), with) in values.iter().zip(residuals.without_ut).zip(residuals.with_ut) {
        if !(value.is_finite() && without.is_finite() && with.is_finite()) {
            continue;
        }
        let bin = (((value - least) / width) as usize).min(BINS - 1);
        if let Some(bin) = bins.get_mut(bin) {
            bin.n += 1;
            bin.without += without * without;
            bin.effect += (without - with).powi(2);
            bin.sum += with;
            bin.squares += with * with;
        }
    }
    let filled: Vec<(usize, &Bin)> = bins.iter().enumerate().filter(|(_, bin)| bin.n > 0).collect();
    let each = |value: &dyn Fn(&Bin, f64) -> f64| -> Vec<f32> {
        filled.iter().map(|(_, bin)| value(bin, f64::from(bin.n)) as f32).collect()
    };
    Some(Against {
        name: name.to_string(),
        unit,
        at: filled.iter().map(|(index, _)| (least + (*index as f64 + 0.5) * width) as f32).collect(),
        samples: filled.iter().map(|(_, bin)| bin.n).collect(),
        without_ut: each(&|bin, n| (bin.without / n).sqrt()),
        effect_ut: each(&|bin, n| (bin.effect / n + residuals.floor_ut.powi(2)).sqrt()),
        mean_ut: each(&|bin, n| bin.sum / n),
        rms_ut: each(&|bin, n| (bin.squares / n).sqrt()),
    })
}

/// How often residuals of each size are, and what noise alone would make.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Histogram {
    /// Middle of each bar, µT.
    pub at_ut: Vec<f32>,
    /// Share of the samples of offset and matrix only.
    pub without: Vec<f32>,
    /// Share of the samples of the whole model.
    pub with: Vec<f32>,
    /// Share that Gaussian noise of the floor's size would have; empty where the floor is not known.
    pub noise: Vec<f32>,
}

/// The histogram of both residuals; `None` where there is nothing to count.
pub fn histogram(residuals: &Residuals) -> Option<Histogram> {
    let n = residuals.with_ut.len();
    let rms = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / n.max(1) as f64).sqrt();
    let reach = REACH * rms(residuals.without_ut).max(rms(residuals.with_ut));
    if n < FEWEST || !(reach > 0.0 && reach.is_finite()) {
        return None;
    }
    let width = 2.0 * reach / BARS as f64;
    let shares = |values: &[f64]| {
        let mut bars = [0_u32; BARS];
        for value in values {
            let bar = ((value + reach) / width).floor();
            if let Some(bar) = bars.get_mut(bar as usize).filter(|_| bar >= 0.0) {
                *bar += 1;
            }
        }
        bars.iter().map(|count| *count as f32 / n as f32).collect()
    };
    let at = |bar: usize| (bar as f64 + 0.5) * width - reach;
    let floor = residuals.floor_ut;
    // The share between a bar's edges, not the density at its middle: a floor below a bar's width would be lost between two middles.
    let below = |v: f64| 0.5 * libm::erfc(-v / (floor * std::f64::consts::SQRT_2));
    let bell = |v: f64| below(v + 0.5 * width) - below(v - 0.5 * width);
    Some(Histogram {
        at_ut: (0..BARS).map(|bar| at(bar) as f32).collect(),
        without: shares(residuals.without_ut),
        with: shares(residuals.with_ut),
        noise: if floor > 0.0 { (0..BARS).map(|bar| bell(at(bar)) as f32).collect() } else { Vec::new() },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_hold_every_sample_and_tell_what_follows_the_column() {
        let column: Vec<f64> = (0..1000).map(|i| f64::from(i % 100)).collect();
        let with: Vec<f64> = (0..1000).map(|i| if i % 2 == 0 { 0.1 } else { -0.1 }).collect();
        let without: Vec<f64> = column.iter().zip(&with).map(|(x, w)| 0.05 * x + w).collect();
        let residuals = Residuals { without_ut: &without, with_ut: &with, floor_ut: 0.1 };
        let bins = against("x", "", &column, &residuals).expect("it varies");
        assert_eq!(bins.samples.iter().sum::<u32>(), 1000);
        assert!(bins.rms_ut.iter().all(|rms| (rms - 0.1).abs() < 1e-6), "{:?}", bins.rms_ut);
        let (first, last) = (bins.without_ut[0], bins.without_ut[bins.without_ut.len() - 1]);
        assert!(last > 20.0 * first, "{first} {last}");
        assert!((bins.effect_ut[31] - last).abs() < 0.05);
        let bars = histogram(&residuals).expect("there are samples");
        assert!((bars.with.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        assert!((bars.noise.iter().sum::<f32>() - 1.0).abs() < 0.05);
        assert!(against("x", "", &[1.0; 1000], &residuals).is_none());
        assert!(against("x", "", &[f64::NAN; 1000], &residuals).is_none());
    }
}
