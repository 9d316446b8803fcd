//! Noise with a memory, sampled as firmware samples: are the predicted errors honest whatever the motion, the jitter of
//! the sampling and the rate, and does the verdict let bad calibrations through?
//!
//! Each log goes through a [`Session`] sample by sample, as on the board.

use super::attitude::Motion;
use super::log::{FIELD_UT, Log};
use ironout::fit::Method;
use ironout::gate::block_samples;
use ironout::sensor::Sample;
use ironout::session::{Session, SessionConfig};
use ironout_simulation::paper::{Sampler, Truth};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use serde_json::{Value, json};

/// Samples of a log.
pub const SAMPLES: usize = 1000;
/// An error of a corrected vector beyond this share of the field is wrong where no more than that was predicted at 3σ.
pub const WRONG: f64 = 0.01;
/// Standard errors are promised where the predicted error is no more than this share of the field.
const HONEST: f64 = 0.05;
/// Motion speeds, rad/s.
pub const SPEEDS_RADPS: [f64; 4] = [0.3, 1.0, 2.0, 3.0];
/// Full widths of the jitter of the sampling times, s.
pub const JITTERS_S: [f64; 3] = [0.0, 0.005, 0.02];
/// Correlations of the noise from sample to sample.
pub const RHOS: [f64; 5] = [0.0, 0.5, 0.8, 0.9, 0.95];
/// Sampling rates, Hz.
pub const RATES_HZ: [f64; 4] = [10.0, 25.0, 50.0, 100.0];

/// When samples are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clock {
    /// At a rate, each sample late or early by up to half of the jitter.
    Even {
        /// Samples per second.
        rate_hz: f64,
        /// Full width of the jitter, s.
        jitter_s: f64,
    },
    /// A chip of 75 Hz polled 50 times a second: intervals of 13 and 27 ms in turn.
    Polled,
}

/// A kind of log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Sampling.
    pub clock: Clock,
    /// How fast the board turns, rad/s.
    pub speed_radps: f64,
    /// Correlation of the slow part of the noise from sample to sample.
    pub rho: f64,
    /// Noise on each axis, σ, µT; `None` draws it, 0.05 … 2 % of the field.
    pub noise_ut: Option<f64>,
    /// Share of the noise's variance that is white.
    pub white: f64,
    /// White jitter of the attitude about each axis, σ, degrees.
    pub shake_deg: f64,
    /// Samples of the log.
    pub samples: usize,
}

impl Case {
    /// A case of the grid.
    pub fn even(rate_hz: f64, jitter_s: f64, speed_radps: f64, rho: f64) -> Self {
        Self {
            clock: Clock::Even { rate_hz, jitter_s },
            speed_radps,
            rho,
            noise_ut: None,
            white: 0.0,
            shake_deg: 0.0,
            samples: SAMPLES,
        }
    }

    /// A chip of 75 Hz polled at 50 Hz: noise of 0.5 µT and ρ = 0.9.
    pub fn polled(speed_radps: f64) -> Self {
        Self { clock: Clock::Polled, noise_ut: Some(0.5), ..Self::even(50.0, 0.0, speed_radps, 0.9) }
    }

    fn times_s(&self, sampler: &mut Sampler) -> Vec<f64> {
        let samples = 0..self.samples;
        let mut times: Vec<f64> = match self.clock {
            Clock::Even { rate_hz, jitter_s } => samples
                .map(|i| {
                    i as f64 / rate_hz
                        + if jitter_s > 0.0 { sampler.uniform(-0.5, 0.5) * jitter_s } else { 0.0 }
                })
                .collect(),
            Clock::Polled => samples.map(|i| (i / 2) as f64 * 0.04 + (i % 2) as f64 * 0.04 / 3.0).collect(),
        };
        times.sort_by(f64::total_cmp);
        times
    }

    fn rate_hz(&self) -> f64 {
        match self.clock {
            Clock::Even { rate_hz, .. } => rate_hz,
            Clock::Polled => 50.0,
        }
    }

    /// A log of this kind.
    pub fn log(&self, seed: u64) -> Log {
        let mut sampler = Sampler::new(seed);
        let noise_ut =
            self.noise_ut.unwrap_or_else(|| sampler.uniform(0.0005f64.ln(), 0.02f64.ln()).exp() * FIELD_UT);
        let mut truth = sampler.mild_truth(0.1);
        truth.b *= sampler.uniform(0.0, 3.0);
        let times = self.times_s(&mut sampler);
        let turn = Turn::new(&mut sampler, self.speed_radps);
        let ut_per_count = 0.1;
        let mut state = sampler.normal3();
        let (slow, white) = ((1.0 - self.white).sqrt() * noise_ut, self.white.sqrt() * noise_ut);
        let counts = turn
            .directions(&times)
            .into_iter()
            .map(|direction| {
                let shake = Rotation3::new(sampler.normal3() * self.shake_deg.to_radians());
                state = state * self.rho + sampler.normal3() * f64::sqrt(1.0 - self.rho * self.rho);
                let noise = state * slow + sampler.normal3() * white;
                let x = (truth.a * (shake * direction) + truth.b) * FIELD_UT + noise;
                std::array::from_fn(|a| (x[a] / ut_per_count).round() as i16)
            })
            .collect();
        Log { truth, motion: Motion::Full, ut_per_count, noise_ut, rho: self.rho, counts }
    }
}

/// Smooth turning at a constant speed about an axis that wanders.
struct Turn {
    speed_radps: f64,
    start: Vector3<f64>,
    /// Amplitude, angular frequency per radian turned, and phase of what the axis is made of.
    axis: Vec<(Vector3<f64>, f64, f64)>,
}

impl Turn {
    fn new(sampler: &mut Sampler, speed_radps: f64) -> Self {
        let axis = (0..3)
            .map(|_| (sampler.normal3(), sampler.uniform(0.05, 0.4), sampler.uniform(0.0, 6.0)))
            .collect();
        Self { speed_radps, start: sampler.direction(Vector3::z(), 1.0), axis }
    }

    fn directions(&self, times_s: &[f64]) -> Vec<Vector3<f64>> {
        // Small steps, so that the path is smooth however it is sampled.
        let mut here = self.start;
        let mut turned = times_s.first().map_or(0.0, |t| t * self.speed_radps);
        times_s
            .iter()
            .map(|t| {
                let to = t * self.speed_radps;
                let steps = ((to - turned) / 0.05).ceil().max(1.0);
                let step = (to - turned) / steps;
                for _ in 0..steps as usize {
                    let axis: Vector3<f64> = self
                        .axis
                        .iter()
                        .map(|(size, rate, phase)| size * (rate * turned + phase).sin())
                        .sum();
                    if let Some(axis) = Unit::try_new(axis, 1e-9) {
                        here = Rotation3::from_axis_angle(&axis, -step) * here;
                    }
                    turned += step;
                }
                here
            })
            .collect()
    }
}

/// What a session made of one log.
#[derive(Clone, Copy, Debug)]
pub struct Judged {
    /// Whether the calibration was accepted.
    pub accepted: bool,
    /// The largest error of a corrected vector, over the field.
    pub error: f64,
    /// The error predicted, 1σ, over the field.
    pub predicted: f64,
    /// Mean square over the axes of the offset's error over its standard error.
    pub z2: f64,
    /// Independent samples over samples, as the session has it.
    pub share: f64,
}

/// Runs a log through a session; `None` where it gives no calibration.
pub fn judge(case: &Case, log: &Log) -> Option<Judged> {
    let mut session = Session::new(SessionConfig {
        ut_per_count: [log.ut_per_count; 3],
        field_ut: Some(FIELD_UT),
        method: Method::Adjusted,
        samples_per_block: block_samples(case.rate_hz()),
        axes: None,
    });
    session.start();
    for counts in &log.counts {
        session.push(Sample::valid(*counts));
    }
    let outcome = session.stop().ok()?;
    let report = outcome.report.as_ref()?;
    let Truth { b, .. } = log.truth;
    let z = |axis: usize| {
        (report.calibration.offset_ut[axis] - b[axis] * FIELD_UT) / report.std_errors.offset_ut[axis]
    };
    let c = Matrix3::from_fn(|i, k| report.calibration.matrix[i][k]);
    Some(Judged {
        accepted: outcome.verdict.accepted,
        error: log.worst_error(&report.calibration.offset_ut.into(), &c),
        predicted: report.predicted_error_ut / report.calibration.field_ut,
        z2: (0..3).map(|axis| z(axis) * z(axis)).sum::<f64>() / 3.0,
        share: report.effective_samples / report.samples as f64,
    })
}

/// What became of the logs of a group.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Logs.
    pub logs: usize,
    /// Calibrations whose standard errors are promised.
    pub fits: usize,
    z2: f64,
    z4: f64,
    /// Accepted.
    pub accepted: usize,
    /// No more than [`WRONG`] predicted at 3σ.
    pub sure: usize,
    /// Of these, off by more than [`WRONG`] somewhere.
    pub wrong: usize,
    /// Accepted, and off by more than three times the error predicted.
    pub far: usize,
    /// Off by less than half of [`WRONG`] everywhere, yet refused.
    pub lost: usize,
    shares: f64,
}

impl Tally {
    /// Counts one more.
    pub fn add(&mut self, judged: Option<&Judged>) {
        self.logs += 1;
        let Some(judged) = judged else { return };
        self.lost += usize::from(!judged.accepted && judged.error < 0.5 * WRONG);
        if judged.predicted <= HONEST {
            self.fits += 1;
            self.z2 += judged.z2;
            self.z4 += judged.z2 * judged.z2;
            self.shares += judged.share;
        }
        self.accepted += usize::from(judged.accepted);
        let sure = judged.accepted && 3.0 * judged.predicted <= WRONG;
        self.sure += usize::from(sure);
        // Negated, so that a NaN is wrong.
        self.wrong += usize::from(sure && !(judged.error <= WRONG));
        self.far += usize::from(judged.accepted && !(judged.error <= 3.0 * judged.predicted));
    }

    /// Rms of the offset's errors over their standard errors, and one standard error of that over the logs.
    pub fn z_rms(&self) -> (f64, f64) {
        let n = self.fits.max(1) as f64;
        let mean = self.z2 / n;
        let spread = (self.z4 / n - mean * mean).max(0.0) / n;
        (mean.sqrt(), 0.5 * spread.sqrt() / mean.sqrt())
    }

    /// Upper end of the 95 % interval (Wilson) of the share of the sure calibrations that are wrong; one without any.
    pub fn wrong_at_most(&self) -> f64 {
        const Z: f64 = 1.645;
        let (n, wrong) = (self.sure as f64, self.wrong as f64);
        if n == 0.0 {
            return 1.0;
        }
        let p = wrong / n;
        let centre = p + Z * Z / (2.0 * n);
        let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        (centre + half) / (1.0 + Z * Z / n)
    }

    /// Mean share of the samples that counted as independent.
    pub fn share(&self) -> f64 {
        self.shares / self.fits.max(1) as f64
    }

    fn merge(&mut self, other: &Self) {
        self.logs += other.logs;
        self.fits += other.fits;
        self.z2 += other.z2;
        self.z4 += other.z4;
        self.accepted += other.accepted;
        self.sure += other.sure;
        self.wrong += other.wrong;
        self.far += other.far;
        self.lost += other.lost;
        self.shares += other.shares;
    }
}

/// A row of the table.
pub type Row = (String, Tally);

/// Runs `seeds` logs of a case.
pub fn run(case: &Case, seeds: std::ops::Range<u64>) -> Tally {
    let mut tally = Tally::default();
    for seed in seeds {
        let log = case.log(0xc022 + seed);
        tally.add(judge(case, &log).as_ref());
    }
    tally
}

/// The cases beside the grid, each with its words.
pub fn cases() -> Vec<(String, Case)> {
    let mut cases = vec![];
    for speed in [1.0, 2.5] {
        cases.push((format!("0.9, 75 Hz read at 50 Hz, {speed} rad/s"), Case::polled(speed)));
    }
    let white = Case { rho: 0.0, ..Case::polled(2.5) };
    cases.push(("white, 75 Hz read at 50 Hz, 2.5 rad/s".into(), white));
    let even = Case { clock: Clock::Even { rate_hz: 50.0, jitter_s: 0.0 }, ..Case::polled(1.0) };
    cases.push(("0.9, 50 Hz, 1 rad/s".into(), even));
    cases.push(("0.9, 50 Hz, 1 rad/s, shaken by 0.3 deg".into(), Case { shake_deg: 0.3, ..even }));
    cases.push((
        "0.9, 10 Hz, 2 rad/s".into(),
        Case { noise_ut: Some(0.5), ..Case::even(10.0, 0.0, 2.0, 0.9) },
    ));
    for (rho, samples) in [(0.9, 1000), (0.97, 4000), (0.99, 4000)] {
        let mixed = Case { white: 0.5, rho, samples, ..Case::even(50.0, 0.0, 1.0, rho) };
        cases.push((format!("half white, half {rho}, {samples} samples"), mixed));
    }
    cases
}

/// Runs everything, `seeds` logs for each cell of the grid and twenty times as many for each case beside it.
pub fn measure(seeds: u64) -> Vec<Row> {
    let mut grid = vec![];
    let mut cell = 0;
    for rate in RATES_HZ {
        for jitter in JITTERS_S {
            for speed in SPEEDS_RADPS {
                for rho in RHOS {
                    cell += 1;
                    let tally =
                        run(&Case::even(rate, jitter, speed, rho), cell * 10_000..cell * 10_000 + seeds);
                    grid.push(([rate, jitter, speed, rho], tally));
                }
            }
        }
    }
    let sum = |take: &dyn Fn(&[f64; 4]) -> bool| {
        let mut sum = Tally::default();
        grid.iter().filter(|(key, _)| take(key)).for_each(|(_, tally)| sum.merge(tally));
        sum
    };
    let mut rows = vec![("grid: all".into(), sum(&|_| true))];
    for rho in RHOS {
        rows.push((format!("grid: correlation {rho}"), sum(&|key| key[3] == rho)));
    }
    for speed in SPEEDS_RADPS {
        rows.push((format!("grid: {speed} rad/s"), sum(&|key| key[2] == speed)));
    }
    for jitter in JITTERS_S {
        rows.push((format!("grid: jitter {} ms", jitter * 1e3), sum(&|key| key[1] == jitter)));
    }
    for rate in RATES_HZ {
        rows.push((format!("grid: {rate} Hz"), sum(&|key| key[0] == rate)));
    }
    rows.extend(cases().iter().map(|(words, case)| (words.clone(), run(case, 0..20 * seeds))));
    rows
}

/// The table.
pub fn text(rows: &[Row]) -> String {
    let mut text = format!(
        "Noise with a memory, through a session sample by sample; 1000 samples a log unless said. fits: calibrations whose\n\
         predicted error is at most {} % of the field; z: rms of the offset's errors over their standard errors, with its own\n\
         standard error; share: of the samples, independent ones; sure: accepted with at most {} % predicted at 3 sigma; wrong:\n\
         of these, off by more than that somewhere, and the upper end of the 95 % interval of their share; far: accepted and\n\
         off by more than 3 sigma somewhere; lost: refused though off by less than {} % everywhere.\n\n\
         {:<42} {:>5} {:>5} {:>5} {:>5} {:>6} {:>6} {:>5} {:>5} {:>8} {:>4} {:>4}\n",
        HONEST * 100.0,
        WRONG * 100.0,
        WRONG * 50.0,
        "sampling, correlation of neighbours",
        "logs",
        "fits",
        "z",
        "+-",
        "share",
        "accept",
        "sure",
        "wrong",
        "at most",
        "far",
        "lost"
    );
    for (words, tally) in rows {
        let (z, error) = tally.z_rms();
        text += &format!(
            "{:<42} {:5} {:5} {:5.2} {:5.2} {:6.3} {:6} {:5} {:5} {:6.1} % {:4} {:4}\n",
            words,
            tally.logs,
            tally.fits,
            z,
            error,
            tally.share(),
            tally.accepted,
            tally.sure,
            tally.wrong,
            tally.wrong_at_most() * 100.0,
            tally.far,
            tally.lost
        );
    }
    text
}

/// The table as JSON.
pub fn json(rows: &[Row]) -> Value {
    rows.iter()
        .map(|(words, tally)| {
            let (z, error) = tally.z_rms();
            json!({"case": words, "logs": tally.logs, "fits": tally.fits, "z_rms": z, "z_rms_std_error": error,
                   "independent_share": tally.share(), "accepted": tally.accepted, "sure": tally.sure,
                   "wrong": tally.wrong, "wrong_share_at_most": tally.wrong_at_most(), "far": tally.far, "lost": tally.lost})
        })
        .collect()
}
