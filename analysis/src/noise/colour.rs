//! Which noise a residual is: white, of first order, a rolling mean, or 1/f, by the likelihood of its spectrum (Whittle),
//! and whether it is any of them.
//!
//! Structure that an effect leaves has a spectrum of its own: slow beside white noise, or in lines. None of these few
//! shapes has that, so what fits none of them is more than noise.

use crate::noise::power::{Band, bands, padded, symmetric, transforms};
use crate::noise::turning::Turning;
use crate::samples::series::median;
use crate::threads::halves;
use serde::Serialize;

/// Exponents of 1/f noise that are tried.
const EXPONENTS: [f64; 4] = [0.6, 0.8, 1.0, 1.2];
/// Shares of white noise beside it. With more of that anything slow would look like 1/f noise.
const WHITE: [f64; 5] = [0.0, 0.08, 0.16, 0.25, 0.35];
/// The same beside a rolling mean: what is added after the filter (its words' rounding, a column's own noise).
const WHITE_AFTER: [f64; 7] = [0.0, 0.01, 0.025, 0.05, 0.1, 0.18, 0.3];
/// The longest rolling mean that is looked for.
const LONGEST_MEAN: usize = 64;
/// Noise of first order falls to 60 % within so many samples ...
const AR1: f64 = 5.3;
/// ... and a rolling mean is at most as long as this ...
const MEAN: f64 = 12.0;
/// ... or either is over after this, s: whatever turns with the board takes longer.
const MEMORY_S: f64 = 0.42;
/// The steepest noise that is called 1/f: what electronics make has an exponent of 0.8 to 1.2.
const STEEPEST: f64 = 1.225;
/// No noise has a colour to the letter, and a fit takes out a little more of slow noise than of white: in every band this share of
/// the power is left open.
const TO_THE_LETTER: f64 = 0.08;
/// A spectrum that is another one than a colour's by more standard deviations beyond that is not that colour's ...
const LIKE: f64 = 4.0;
/// ... nor one that is by more of them to the letter: a line in a wide band is little of its power.
const LIKE_TO_THE_LETTER: f64 = 10.0;
/// White noise that fits this well is not looked at further, standard deviations.
const PLAIN: f64 = 1.0;
/// A mean beside white noise must be likelier than one without by so much (twice the logarithm).
const UNCERTAIN: f64 = 6.0;
/// Fewer samples tell no colour.
const FEWEST: usize = 60;

/// A colour of noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Colour {
    /// Every sample its own.
    White,
    /// First order, with this correlation from one sample to the next.
    Ar1(f64),
    /// A rolling mean, and a share of white noise.
    RollingMean {
        /// Over so many samples.
        of: usize,
        /// Share of the variance that is white.
        white: f64,
    },
    /// 1/f: power in proportion to the frequency to the power of minus `exponent`, and a share of white noise.
    Flicker {
        /// The exponent.
        exponent: f64,
        /// Share of the variance that is white.
        white: f64,
        /// Whether what lies beyond half the sampling rate is folded back into it: sampled without a filter before.
        folded: bool,
    },
}

impl Colour {
    /// In words.
    pub fn words(self) -> String {
        match self {
            Colour::White => "white".into(),
            Colour::Ar1(correlation) => {
                format!("correlated noise (correlation {correlation:.2} from sample to sample)")
            }
            Colour::RollingMean { of, white } if white > 0.0 => {
                format!(
                    "a moving average over {of} samples with {:.0} % of white noise",
                    (100.0 * white).max(1.0)
                )
            }
            Colour::RollingMean { of, .. } => format!("a moving average over {of} samples"),
            Colour::Flicker { exponent, white, .. } if white > 0.0 => {
                format!("1/f noise (exponent {exponent:.1}) with {:.0} % of white noise", 100.0 * white)
            }
            Colour::Flicker { exponent, .. } => format!("1/f noise (exponent {exponent:.1})"),
        }
    }

    /// Whether a sensor's noise may be so: steeper than 1/f, or with a longer memory than a filter gives it, it is an error
    /// that moves. `step_s` is the time from sample to sample, 0 where unknown.
    pub fn is_of_a_sensor(self, step_s: f64) -> bool {
        let short =
            |samples: f64, most: f64| samples <= most || (step_s > 0.0 && samples * step_s <= MEMORY_S);
        match self {
            Colour::White => true,
            // Samples until it has fallen to 60 %.
            Colour::Ar1(rho) => short(0.6_f64.ln() / rho.clamp(1e-9, 1.0 - 1e-9).ln(), AR1),
            Colour::RollingMean { of, .. } => short(of as f64, MEAN),
            Colour::Flicker { exponent, .. } => exponent <= STEEPEST,
        }
    }

    /// A word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Colour::White => "white",
            Colour::Ar1(_) => "fading",
            Colour::RollingMean { .. } => "rolling-mean",
            Colour::Flicker { .. } => "flicker",
        }
    }

    /// How many numbers it was chosen by.
    fn parameters(self) -> f64 {
        match self {
            Colour::White => 0.0,
            Colour::Ar1(_) => 1.0,
            Colour::RollingMean { white, .. } => 1.0 + f64::from(u8::from(white > 0.0)),
            Colour::Flicker { .. } => 2.0,
        }
    }

    /// Its autocorrelation at the lags from 0 to half of `size`.
    pub(crate) fn correlation(self, size: usize) -> Vec<f64> {
        let lags = size / 2 + 1;
        match self {
            Colour::White => (0..lags).map(|lag| f64::from(u8::from(lag == 0))).collect(),
            Colour::Ar1(rho) => (0..lags).map(|lag| rho.powi(lag as i32)).collect(),
            Colour::RollingMean { of, white } => {
                let mean = |lag: usize| (1.0 - lag as f64 / of.max(1) as f64).max(0.0);
                (0..lags).map(|lag| if lag == 0 { 1.0 } else { (1.0 - white) * mean(lag) }).collect()
            }
            Colour::Flicker { exponent, white, folded } => {
                let power: Vec<f64> = (0..lags)
                    .map(|bin| {
                        let angle = std::f64::consts::PI * bin.max(1) as f64 / size as f64;
                        // The sine rises to what is folded back.
                        if folded { angle.sin() } else { angle }.powf(-exponent)
                    })
                    .collect();
                let mut values = symmetric(&power, size);
                let whole = values[0].max(f64::MIN_POSITIVE);
                values.iter_mut().for_each(|value| *value *= (1.0 - white) / whole);
                values[0] = 1.0;
                values
            }
        }
    }
}

/// The noise that a residual is most like.
#[derive(Debug, Clone)]
pub struct Described {
    /// The colour.
    pub colour: Colour,
    /// Power by bin of the half spectrum.
    pub power: Vec<f64>,
    /// Twice the logarithm by which its spectrum is less likely than one that fits every band, and how many bands are free.
    pub deviance: f64,
    /// The same with the share left open that no colour is followed to.
    pub loose_deviance: f64,
    /// Bands beyond what was chosen.
    pub free: f64,
    /// Share of the variance by which some bands stand out above the others.
    pub excess: f64,
}

impl Described {
    /// Whether it is noise as a sensor has it, and nothing more.
    pub fn is_noise(&self, step_s: f64) -> bool {
        let loose = self.beyond_chance(self.loose_deviance);
        loose < LIKE && self.misfit() < LIKE_TO_THE_LETTER && self.colour.is_of_a_sensor(step_s)
    }

    /// By how many standard deviations the spectrum is another one than this.
    pub fn misfit(&self) -> f64 {
        self.beyond_chance(self.deviance)
    }

    fn beyond_chance(&self, deviance: f64) -> f64 {
        (deviance - self.free) / (2.0 * self.free.max(1.0)).sqrt()
    }
}

/// Colours of one family, of which the best is looked for.
enum Family {
    Ar1,
    RollingMean,
    Flicker { folded: bool },
}

/// What a residual is compared with.
pub struct Seen<'t> {
    size: usize,
    n: usize,
    /// Power by bin.
    pub power: Vec<f64>,
    bands: Vec<Band>,
    turning: &'t Turning,
    absorbed: &'t [f64],
    /// Share of the variance that is the readings' rounding, white beside any colour.
    rounding: f64,
}

impl<'t> Seen<'t> {
    /// Of a residual from which a fit has `absorbed` its share of white noise by bin.
    pub fn of(residuals: &[f64], turning: &'t Turning, absorbed: &'t [f64], rounding: f64) -> Self {
        let n = residuals.len();
        let size = padded(n);
        let transform = transforms(std::slice::from_ref(&residuals.to_vec()), size).swap_remove(0);
        let power: Vec<f64> =
            transform.iter().map(|(re, im)| (re * re + im * im) / n.max(1) as f64).collect();
        let bands = bands(&power, n, size);
        Seen { size, n, power, bands, turning, absorbed, rounding: rounding.clamp(0.0, 1.0) }
    }

    /// The power that this colour would show before anything is taken out, at unit variance.
    fn expected(&self, colour: Colour) -> Vec<f64> {
        if colour == Colour::White {
            return vec![1.0; self.size / 2 + 1];
        }
        let alike = &self.turning.alike[..self.n.min(self.turning.alike.len())];
        seen_through(&colour.correlation(self.size), alike, self.rounding, self.size)
    }

    fn left(&self, bin: usize) -> f64 {
        1.0 - self.absorbed.get(bin).copied().unwrap_or(0.0).clamp(0.0, 0.98)
    }

    /// How well a colour fits, its size the most likely one.
    pub fn fit(&self, colour: Colour) -> Described {
        self.fit_to(colour, self.expected(colour))
    }

    fn fit_to(&self, colour: Colour, mut power: Vec<f64>) -> Described {
        let sums: Vec<(f64, f64, f64)> = self
            .bands
            .iter()
            .map(|band| {
                let expected: f64 = band.bins.clone().map(|bin| power[bin].max(1e-9) * self.left(bin)).sum();
                let left: f64 = band.bins.clone().map(|bin| self.left(bin)).sum();
                (expected, band.seen, band.count * left / band.bins.len().max(1) as f64)
            })
            .collect();
        let count: f64 = sums.iter().map(|one| one.2).sum();
        let scale = sums.iter().map(|(expected, seen, count)| count * seen / expected).sum::<f64>() / count;
        let open = if colour == Colour::White { 0.0 } else { TO_THE_LETTER * TO_THE_LETTER };
        let (mut deviance, mut loose_deviance) = (0.0, 0.0);
        for (expected, seen, count) in &sums {
            let ratio = (seen / (scale * expected)).max(1e-12);
            let a_value = 2.0 * (ratio - 1.0 - ratio.ln());
            deviance += count * a_value;
            loose_deviance += count / (1.0 + count * open) * a_value;
        }
        power.iter_mut().for_each(|value| *value = value.max(1e-9) * scale);
        // Against the median: a line or a slow part raises the mean.
        let mut ratios: Vec<f64> = sums.iter().map(|(expected, seen, _)| seen / (scale * expected)).collect();
        let usual = median(&mut ratios) * scale;
        let whole: f64 = sums.iter().map(|one| one.1).sum();
        let above: f64 = sums.iter().map(|(expected, seen, _)| (seen - usual * expected).max(0.0)).sum();
        let excess = (above / whole.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let free = (self.bands.len() as f64 - 1.0 - colour.parameters()).max(1.0);
        Described { colour, power, deviance, loose_deviance, free, excess }
    }

    /// The most likely of the colours.
    pub fn describe(&self) -> Described {
        let cost = |one: &Described| one.deviance + (self.n as f64).ln() * one.colour.parameters();
        let white = self.fit(Colour::White);
        if white.misfit() < PLAIN || self.n < FEWEST {
            return white;
        }
        let own = self.correlation();
        let best = |family: &Family| match family {
            Family::Ar1 => self.best_fading(&own),
            Family::RollingMean => self.best_mean(&own),
            Family::Flicker { folded } => self.best_flicker(*folded),
        };
        let all = |half: &[Family]| half.iter().map(best).collect::<Vec<_>>();
        let (one, two) = (
            [Family::Ar1, Family::Flicker { folded: true }],
            [Family::RollingMean, Family::Flicker { folded: false }],
        );
        let (one, two) = halves((one.as_slice(), two.as_slice()), all);
        let mut list = vec![white];
        for (first, second) in one.into_iter().zip(two) {
            list.extend([first, second]);
        }
        list.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        list.swap_remove(0)
    }

    fn best_fading(&self, own: &[f64]) -> Described {
        let mut near = own.get(1).copied().unwrap_or(0.0).clamp(0.05, 0.98);
        let mut best = self.fit(Colour::Ar1(near));
        for step in [0.5, 0.25, 0.1, 0.04] {
            for rho in [near - step * (1.0 - near), near + step * (1.0 - near)] {
                let rho = rho.clamp(0.01, 0.995);
                let next = self.fit(Colour::Ar1(rho));
                if next.deviance < best.deviance {
                    (best, near) = (next, rho);
                }
            }
        }
        best
    }

    /// A rolling mean forgets all at once.
    fn best_mean(&self, own: &[f64]) -> Described {
        let end = own.iter().position(|value| *value < 0.125).unwrap_or(own.len()).max(2);
        let end = ((end as f64 / 0.875).round() as usize).max(3);
        let at = |of: usize, white: f64| self.fit(Colour::RollingMean { of, white });
        let better =
            |best: Described, next: Described| if next.deviance < best.deviance { next } else { best };
        let mut best = at(end, 0.0);
        for of in [end - 1, end + 1] {
            best = better(best, at(of, 0.0));
        }
        let plain = best.clone();
        for of in [end - 1, end, end + 1] {
            best = WHITE_AFTER[1..].iter().fold(best, |best, white| better(best, at(of, *white)));
        }
        // A share that says little more is none.
        if plain.deviance < best.deviance + UNCERTAIN { plain } else { best }
    }

    /// 1/f noise, sampled with a filter before it or without.
    fn best_flicker(&self, folded: bool) -> Described {
        let at = |exponent: f64| {
            let plain = self.expected(Colour::Flicker { exponent, white: 0.0, folded });
            let fits = WHITE
                .iter()
                .map(|&white| self.fit_to(Colour::Flicker { exponent, white, folded }, mixed(&plain, white)));
            fits.reduce(|best, next| if next.deviance < best.deviance { next } else { best })
        };
        let mut best = self.fit(Colour::Flicker { exponent: EXPONENTS[0], white: 0.0, folded });
        let mut near = EXPONENTS[0];
        // A slow cause passes for steep 1/f noise: how steep it is is told ever more closely.
        let closer = |around: f64, by: f64| vec![around - by, around + by];
        for round in 0..3 {
            let list = match round {
                0 => EXPONENTS.to_vec(),
                1 => closer(near, 0.1),
                _ => closer(near, 0.05),
            };
            for exponent in list {
                if let Some(next) = at(exponent).filter(|next| next.deviance < best.deviance) {
                    (best, near) = (next, exponent);
                }
            }
        }
        best
    }

    /// The autocorrelation of what was seen, at short lags.
    fn correlation(&self) -> Vec<f64> {
        let mut values = symmetric(&self.power, self.size);
        values.truncate(LONGEST_MEAN);
        let whole = values.first().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
        values.iter().map(|value| value / whole).collect()
    }
}

/// The power by bin of noise of this autocorrelation (and a share of `rounding`, white beside it) that shows by so much after so
/// many samples.
pub(crate) fn seen_through(own: &[f64], alike: &[f64], rounding: f64, size: usize) -> Vec<f64> {
    let mut folded = vec![0.0; size / 2 + 1];
    for (lag, alike) in alike.iter().enumerate() {
        let place = lag.min(size - lag);
        // Half a turn away the two ends meet in one place.
        let twice = if 2 * place == size { 2.0 } else { 1.0 };
        let white = if lag == 0 { rounding } else { 0.0 };
        folded[place] += twice * alike * (own[place] * (1.0 - rounding) + white);
    }
    symmetric(&folded, size)
}

/// A spectrum of unit variance with a share of white noise.
fn mixed(plain: &[f64], white: f64) -> Vec<f64> {
    plain.iter().map(|value| white + (1.0 - white) * value).collect()
}
