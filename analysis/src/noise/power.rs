//! The power of a series by frequency, and in bands of it.

use crate::samples::fft;

/// Room behind a series, so that its end does not meet its beginning within a short memory.
pub const PADDING: usize = 64;
/// A band is wider than the one below by this.
const WIDER: f64 = 1.25;
/// Fewer independent values are no band.
const FEWEST: f64 = 4.0;

/// The length of transforms of `n` values.
pub fn padded(n: usize) -> usize {
    (n + PADDING).next_power_of_two()
}

/// How often a bin of the half spectrum stands in the whole.
pub fn weight(bin: usize, size: usize) -> f64 {
    if bin == 0 || 2 * bin == size { 1.0 } else { 2.0 }
}

/// Transforms of real series, two at a time; the half spectrum of each.
pub fn transforms(series: &[Vec<f64>], size: usize) -> Vec<Vec<(f64, f64)>> {
    let mut out = Vec::with_capacity(series.len());
    for pair in series.chunks(2) {
        let mut data = vec![(0.0, 0.0); size];
        for (slot, value) in data.iter_mut().zip(&pair[0]) {
            slot.0 = *value;
        }
        if let Some(second) = pair.get(1) {
            for (slot, value) in data.iter_mut().zip(second) {
                slot.1 = *value;
            }
        }
        fft::forward(&mut data);
        let half = size / 2;
        let at = |bin: usize| (data[bin], data[(size - bin) % size]);
        let first = (0..=half).map(|bin| {
            let (a, b) = at(bin);
            (0.5 * (a.0 + b.0), 0.5 * (a.1 - b.1))
        });
        out.push(first.collect());
        if pair.len() > 1 {
            let second = (0..=half).map(|bin| {
                let (a, b) = at(bin);
                (0.5 * (a.1 + b.1), 0.5 * (b.0 - a.0))
            });
            out.push(second.collect());
        }
    }
    out
}

/// Adds the power of columns of length one, as a share of white noise of `n` values.
pub fn add_power(sum: &mut [f64], transforms: &[Vec<(f64, f64)>], n: usize) {
    for transform in transforms {
        for (slot, (re, im)) in sum.iter_mut().zip(transform) {
            *slot += (re * re + im * im) / n.max(1) as f64;
        }
    }
}

/// The transform of a symmetric series given by its half: real, and its half again.
pub fn symmetric(half: &[f64], size: usize) -> Vec<f64> {
    let mut turns = vec![(0.0, 0.0); size];
    for (bin, value) in half.iter().enumerate().take(size / 2 + 1) {
        turns[bin].0 = *value;
        turns[(size - bin) % size].0 = *value;
    }
    fft::forward(&mut turns);
    turns.iter().take(size / 2 + 1).map(|value| value.0).collect()
}

/// A band of frequencies.
#[derive(Debug, Clone)]
pub struct Band {
    /// Its bins.
    pub bins: std::ops::Range<usize>,
    /// How many independent values lie in it.
    pub count: f64,
    /// The sum of the power seen.
    pub seen: f64,
}

/// Bands of a half spectrum of `n` values that has the power `seen`, each a quarter wider than the one below.
pub fn bands(seen: &[f64], n: usize, size: usize) -> Vec<Band> {
    let a_bin = n as f64 / size as f64;
    let narrow = (FEWEST / a_bin).ceil() as usize;
    let mut list = Vec::new();
    // The mean is no noise: the field's magnitude takes it out.
    let mut from = (0.5 / a_bin).ceil() as usize;
    while from < seen.len() {
        let wide = (from as f64 * (WIDER - 1.0)).ceil() as usize;
        let mut to = (from + wide.max(narrow)).min(seen.len());
        if seen.len() - to < narrow {
            to = seen.len();
        }
        let sum = seen[from..to].iter().sum();
        list.push(Band { bins: from..to, count: (to - from) as f64 * a_bin, seen: sum });
        from = to;
    }
    list
}
