//! What a residual looks like against the quantities that may explain it.
//!
//! An offset that the model does not know averages out of the residual of the magnitude, since the board turns under
//! it. So in each bin of a column the *local offset* is fitted, the vector `d` in `r = u·d` (u the direction of the
//! field), besides the plain mean of `r`; what is drawn is the one that explains more.

use nalgebra::{Matrix3, SMatrix, SVector, SymmetricEigen, Vector3};

/// Places of a curve.
pub const BINS: usize = 28;
/// A bin of fewer samples is left blank.
const LEAST: f64 = 6.0;

/// A curve over equal bins from `low` to `high`.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Where the first bin begins, in the quantity's unit.
    pub low: f64,
    /// Where the last bin ends.
    pub high: f64,
    /// One value a bin, µT; `None` where there is nothing.
    pub values: Vec<Option<f64>>,
    /// Whether the values are local offsets rather than means.
    pub offset: bool,
    /// Direction of the local offsets; they are components along it.
    pub direction: Option<[f64; 3]>,
}

/// The residuals to draw.
#[derive(Debug, Clone, Copy)]
pub struct Residuals<'a> {
    /// One value a sample: the magnitude; or one series for each axis of a board at rest.
    pub series: &'a [Vec<f64>],
    /// Unit vectors of the field; empty at rest.
    pub directions: &'a [[f64; 3]],
}

#[derive(Debug, Clone, Copy)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    /// The range of nearly all values: single far values do not squeeze the rest into one bin.
    fn of(x: &[f64]) -> Option<Range> {
        let mut sorted: Vec<f64> = x.iter().copied().filter(|value| value.is_finite()).collect();
        if sorted.len() < 2 * BINS {
            return None;
        }
        sorted.sort_by(f64::total_cmp);
        let (first, last) = (sorted[0], sorted[sorted.len() - 1]);
        let (low, high) = (sorted[sorted.len() / 200], sorted[sorted.len() - 1 - sorted.len() / 200]);
        // Where the outer values lie close by, the whole range is the honest one.
        let (low, high) = if last - first < 1.5 * (high - low) { (first, last) } else { (low, high) };
        (high > low).then_some(Range { low, high })
    }

    fn place(self, value: f64) -> Option<usize> {
        let at = (value - self.low) / (self.high - self.low) * BINS as f64;
        (-0.5..BINS as f64 + 0.5).contains(&at).then(|| (at.max(0.0) as usize).min(BINS - 1))
    }
}

struct Bin {
    normal: SMatrix<f64, 4, 4>,
    right: SVector<f64, 4>,
    count: f64,
}

impl Bin {
    fn new() -> Self {
        Bin { normal: SMatrix::zeros(), right: SVector::zeros(), count: 0.0 }
    }

    fn mean(&self) -> Option<f64> {
        (self.count >= LEAST).then(|| self.right[3] / self.count)
    }

    /// The local offset, held near zero where the directions of the bin do not tell it (all over the sphere each axis
    /// has a third of the samples; one that has under a fiftieth is not told). Drawn curves are not fits.
    fn offset(&self) -> Option<Vector3<f64>> {
        let ridge = 0.25 + 0.02 * self.count;
        let normal = self.normal.fixed_view::<3, 3>(0, 0) + Matrix3::identity() * ridge;
        let right = self.right.fixed_view::<3, 1>(0, 0).into_owned();
        (self.count >= LEAST).then(|| normal.cholesky().map(|factor| factor.solve(&right))).flatten()
    }
}

impl Residuals<'_> {
    fn rms(&self) -> f64 {
        let (sum, n) = self.series.iter().flatten().fold((0.0, 0.0), |(sum, n), r| (sum + r * r, n + 1.0));
        (sum / f64::max(n, 1.0)).sqrt()
    }

    /// The curve against `x` (one value a sample).
    pub fn against(&self, x: &[f64]) -> Option<Curve> {
        let range = Range::of(x)?;
        match self.series {
            [magnitude] => Some(self.magnitude(x, magnitude, range, None)),
            [] => None,
            axes => Some(vectors(x, axes, range, None)),
        }
    }

    /// The same against `x` in the terms of another curve: its range, its kind, its direction.
    pub fn like(&self, x: &[f64], other: &Curve) -> Option<Curve> {
        let range = Range { low: other.low, high: other.high };
        match self.series {
            [magnitude] => Some(self.magnitude(x, magnitude, range, Some(other))),
            [] => None,
            axes => Some(vectors(x, axes, range, other.direction)),
        }
    }

    /// Rms of the residual against `x`.
    pub fn spread(&self, x: &[f64]) -> Option<Curve> {
        let [magnitude] = self.series else { return None };
        let squares = [magnitude.iter().map(|r| r * r).collect::<Vec<f64>>()];
        let mut curve = Residuals { series: &squares, directions: &[] }.means(x)?;
        for value in curve.values.iter_mut().flatten() {
            *value = value.max(0.0).sqrt();
        }
        Some(curve)
    }

    /// Share of the squared residual that a straight line through zero in `x` takes away.
    pub fn share(&self, x: &[f64]) -> f64 {
        let [magnitude] = self.series else { return 0.0 };
        let (mut xx, mut xr, mut rr) = (0.0, 0.0, 0.0);
        for (x, r) in x.iter().zip(magnitude) {
            xx += x * x;
            xr += x * r;
            rr += r * r;
        }
        if xx * rr > 0.0 { xr * xr / (xx * rr) } else { 0.0 }
    }

    /// Plain means against `x`.
    pub fn means(&self, x: &[f64]) -> Option<Curve> {
        let Range { low, high } = Range::of(x)?;
        let plain = Curve { low, high, values: Vec::new(), offset: false, direction: None };
        self.like(x, &plain)
    }

    fn magnitude(&self, x: &[f64], residual: &[f64], range: Range, like: Option<&Curve>) -> Curve {
        let Range { low, high } = range;
        let mut bins: Vec<Bin> = (0..BINS).map(|_| Bin::new()).collect();
        let directed = self.directions.len() == residual.len();
        for (sample, (&value, &r)) in x.iter().zip(residual).enumerate() {
            let Some(bin) = range.place(value).and_then(|index| bins.get_mut(index)) else { continue };
            let [a, b, c] = if directed { self.directions[sample] } else { [0.0; 3] };
            let row = SVector::<f64, 4>::new(a, b, c, 1.0);
            bin.normal += row * row.transpose();
            bin.right += row * r;
            bin.count += 1.0;
        }
        let offsets: Vec<Option<Vector3<f64>>> =
            bins.iter().map(|bin| if directed { bin.offset() } else { None }).collect();
        let variance = self.rms().powi(2);
        let used = bins.iter().filter(|bin| bin.count >= LEAST).count() as f64;
        // What each explains beyond the chance of its number of coefficients.
        let by_mean: f64 = bins.iter().filter_map(|bin| Some(bin.mean()?.powi(2) * bin.count)).sum::<f64>()
            - used * variance;
        let by_offset: f64 = bins
            .iter()
            .zip(&offsets)
            .filter_map(|(bin, d)| {
                let right = bin.right.fixed_view::<3, 1>(0, 0);
                Some(d.as_ref()?.dot(&right))
            })
            .sum::<f64>()
            - 3.0 * used * variance;
        if like.map_or(by_offset > by_mean.max(0.0), |curve| curve.offset) {
            let counts: Vec<f64> = bins.iter().map(|bin| bin.count).collect();
            let (values, direction) = along(&offsets, &counts, like.and_then(|curve| curve.direction));
            Curve { low, high, values, offset: true, direction: Some(direction) }
        } else {
            let values = bins.iter().map(Bin::mean).collect();
            Curve { low, high, values, offset: false, direction: None }
        }
    }
}

/// Means of the vector of a board at rest, along their principal direction.
fn vectors(x: &[f64], axes: &[Vec<f64>], range: Range, direction: Option<[f64; 3]>) -> Curve {
    let Range { low, high } = range;
    let mut sums = vec![Vector3::zeros(); BINS];
    let mut counts = vec![0.0; BINS];
    for (sample, &value) in x.iter().enumerate() {
        let Some(index) = range.place(value) else { continue };
        for (axis, series) in axes.iter().take(3).enumerate() {
            sums[index][axis] += series.get(sample).copied().unwrap_or(0.0);
        }
        counts[index] += 1.0;
    }
    let means: Vec<Option<Vector3<f64>>> =
        sums.iter().zip(&counts).map(|(sum, count)| (*count >= LEAST).then(|| sum / *count)).collect();
    let (values, direction) = along(&means, &counts, direction);
    Curve { low, high, values, offset: true, direction: Some(direction) }
}

/// Components along a direction: the given one, or that in which the vectors vary most, pointing so that they rise from
/// left to right.
fn along(
    vectors: &[Option<Vector3<f64>>],
    counts: &[f64],
    direction: Option<[f64; 3]>,
) -> (Vec<Option<f64>>, [f64; 3]) {
    let direction = direction.map_or_else(|| principal(vectors, counts), Vector3::from);
    (vectors.iter().map(|v| v.as_ref().map(|v| v.dot(&direction))).collect(), direction.into())
}

fn principal(vectors: &[Option<Vector3<f64>>], counts: &[f64]) -> Vector3<f64> {
    let known = || vectors.iter().zip(counts).filter_map(|(v, n)| v.as_ref().map(|v| (v, *n)));
    let weight: f64 = known().map(|(_, n)| n).sum::<f64>().max(1.0);
    let mean = known().map(|(v, n)| v * n).sum::<Vector3<f64>>() / weight;
    let spread: Matrix3<f64> = known().map(|(v, n)| (v - mean) * (v - mean).transpose() * n).sum();
    let direction = SymmetricEigen::try_new(spread, 1e-12, 200)
        .and_then(|eigen| {
            let largest = eigen.eigenvalues.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?.0;
            Some(eigen.eigenvectors.column(largest).into_owned())
        })
        .unwrap_or_else(Vector3::x);
    let slope: f64 =
        known().enumerate().map(|(i, (v, n))| (i as f64 - 0.5 * BINS as f64) * n * v.dot(&direction)).sum();
    if slope < 0.0 { -direction } else { direction }
}

/// The spectrum of the residual: amplitude, µT, of the strongest line in each of `BINS` bands from zero to half of the
/// sampling rate; and the strongest of all with its frequency, Hz. The rate is the mean one.
pub fn spectrum(time_s: &[f64], residual: &[f64]) -> Option<(Curve, f64, f64)> {
    let n = residual.len().min(time_s.len());
    let seconds = time_s.get(n.checked_sub(1)?)? - time_s.first()?;
    if n < 8 * BINS || seconds <= 0.0 {
        return None;
    }
    let rate = (n - 1) as f64 / seconds;
    let size = n.next_power_of_two();
    // A Hann window: without it one strong line would fill the bands next to it.
    let window = |i: usize| 0.5 - 0.5 * (std::f64::consts::TAU * (i as f64 + 0.5) / n as f64).cos();
    let mut data: Vec<(f64, f64)> =
        residual[..n].iter().enumerate().map(|(i, r)| (r * window(i), 0.0)).collect();
    data.resize(size, (0.0, 0.0));
    ironout_analysis::samples::fft::forward(&mut data);
    let mut values = vec![Some(0.0_f64); BINS];
    let mut peak = (0.0, 0.0);
    for (k, (re, im)) in data.iter().enumerate().take(size / 2).skip(1) {
        let amplitude = 4.0 * re.hypot(*im) / n as f64;
        let hz = k as f64 * rate / size as f64;
        let band = ((2.0 * hz / rate * BINS as f64) as usize).min(BINS - 1);
        if let Some(value) = values[band].as_mut() {
            *value = value.max(amplitude);
        }
        if amplitude > peak.1 {
            peak = (hz, amplitude);
        }
    }
    let curve = Curve { low: 0.0, high: rate / 2.0, values, offset: false, direction: None };
    Some((curve, peak.0, peak.1))
}

/// The curve as a sparkline between `bottom` and `top`; a blank where there is nothing.
pub fn sparkline(values: &[Option<f64>], bottom: f64, top: f64) -> String {
    const LEVELS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let span = (top - bottom).max(1e-12);
    values
        .iter()
        .map(|value| match value {
            Some(value) if value.is_finite() => {
                LEVELS[((((value - bottom) / span) * 8.0).max(0.0) as usize).min(7)]
            }
            _ => ' ',
        })
        .collect()
}

/// A bar of `share` (0 to 1) of `width` characters, to an eighth of one.
pub fn bar(share: f64, width: usize) -> String {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let eighths =
        if share.is_finite() { (share.clamp(0.0, 1.0) * 8.0 * width as f64).round() as usize } else { 0 };
    format!("{}{}", "█".repeat(eighths / 8), EIGHTHS[eighths % 8])
}

/// Smallest and largest value of several curves, at least `least` apart.
pub fn limits<'a>(curves: impl Iterator<Item = &'a Curve>, least: f64) -> (f64, f64) {
    let (low, high) = curves
        .flat_map(|curve| curve.values.iter().flatten())
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)));
    if low > high {
        return (-0.5 * least, 0.5 * least);
    }
    let short = 0.5 * (least - (high - low)).max(0.0);
    (low - short, high + short)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions all over the sphere, without chance.
    fn directions(n: usize) -> Vec<[f64; 3]> {
        (0..n)
            .map(|i| {
                let (z, a) = (1.0 - 2.0 * (i as f64 + 0.5) / n as f64, 2.399_963 * i as f64);
                let r = (1.0 - z * z).sqrt();
                [r * a.cos(), r * a.sin(), z]
            })
            .collect()
    }

    /// A column that goes up and down in step with nothing else.
    fn column(n: usize) -> Vec<f64> {
        (0..n).map(|i| 20.0 + 10.0 * (i as f64 * 0.414_214).fract()).collect()
    }

    #[test]
    fn an_offset_in_a_column_is_drawn_as_the_straight_line_it_is() {
        let n = 6400;
        let (u, x) = (directions(n), column(n));
        let theta = [0.06, -0.08, 0.0];
        let r: Vec<f64> = u
            .iter()
            .zip(&x)
            .map(|(u, x)| (0..3).map(|axis| u[axis] * theta[axis] * (x - 25.0)).sum())
            .collect();
        let series = [r];
        let curve = Residuals { series: &series, directions: &u }.against(&x).expect("a curve");
        assert!(curve.offset);
        assert!((curve.low - 20.0).abs() < 0.1 && (curve.high - 30.0).abs() < 0.1);
        for (bin, value) in curve.values.iter().enumerate() {
            let expected = 0.1 * (10.0 * (bin as f64 + 0.5) / BINS as f64 - 5.0);
            let value = value.expect("a full bin");
            assert!((value - expected).abs() < 0.05, "bin {bin}: {value} for {expected}");
        }
        let text = sparkline(&curve.values, -0.5, 0.5);
        assert_eq!(text.chars().count(), BINS);
        assert!(text.starts_with('▁') && text.ends_with('█'), "{text}");
    }

    #[test]
    fn a_change_of_the_field_is_drawn_as_its_mean() {
        let n = 6400;
        let (u, x) = (directions(n), column(n));
        let series = [x.iter().map(|x| 0.2 * (x - 25.0)).collect::<Vec<f64>>()];
        let curve = Residuals { series: &series, directions: &u }.against(&x).expect("a curve");
        assert!(!curve.offset);
        assert!((curve.values[0].expect("full") + 0.97).abs() < 0.05, "{:?}", curve.values[0]);
    }

    #[test]
    fn a_resting_board_shows_its_vector() {
        let x = column(2000);
        let series = [
            x.iter().map(|x| 3.0 * (x - 25.0)).collect::<Vec<f64>>(),
            x.iter().map(|x| -4.0 * (x - 25.0)).collect(),
        ];
        let curve = Residuals { series: &series, directions: &[] }.against(&x).expect("a curve");
        let last = curve.values[BINS - 1].expect("full");
        assert!((last - 24.2).abs() < 0.5, "{last}");
    }

    #[test]
    fn a_constant_or_short_column_has_no_curve() {
        let series = [vec![1.0; 100]];
        let residuals = Residuals { series: &series, directions: &[] };
        assert_eq!(residuals.against(&[4.0; 100]), None);
        assert_eq!(residuals.against(&[1.0, 2.0]), None);
        assert_eq!(residuals.against(&[f64::NAN; 100]), None);
    }

    #[test]
    fn a_line_in_the_spectrum_has_its_frequency_and_amplitude() {
        let t: Vec<f64> = (0..3000).map(|i| f64::from(i) * 0.02).collect();
        let r: Vec<f64> = t.iter().map(|t| 0.7 * (std::f64::consts::TAU * 11.3 * t).sin()).collect();
        let (curve, hz, amplitude) = spectrum(&t, &r).expect("a spectrum");
        assert!((hz - 11.3).abs() < 0.05, "{hz}");
        assert!((amplitude - 0.7).abs() < 0.1, "{amplitude}");
        assert!((curve.high - 25.0).abs() < 0.1);
        let top = curve.values.iter().flatten().fold(0.0_f64, |a, b| a.max(*b));
        assert_eq!(top, amplitude);
    }

    #[test]
    fn bars_are_as_long_as_they_say() {
        assert_eq!(bar(1.0, 4), "████");
        assert_eq!(bar(0.5, 4), "██");
        assert_eq!(bar(0.28, 4), "█▏");
        assert_eq!(bar(f64::NAN, 4), "");
        assert_eq!(bar(7.0, 4), "████");
    }
}
