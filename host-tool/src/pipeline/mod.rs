//! From a log to a judged calibration: which samples count, the core's fit of them, and what the fit is worth.
//!
//! 1. a triple that repeats is one sample;
//! 2. faults of the data (clipping, gross outliers) are set aside, by a fit that is repeated without them;
//! 3. a resting board adds nothing (the core's gate);
//! 4. the core's fit, with the number of *independent* samples taken from the residual's second differences;
//! 5. held-out error, noise floor, coverage, and the core's verdict;
//! 6. with an accelerometer, the rotation that magnitudes leave open.
//!
//! With effects (`--add`) or on top of an earlier calibration (`--prior`) the study fits instead of steps 2, 4 and 5.

mod align;
mod data;
mod extended;
mod faults;
mod floor;
mod holdout;
mod result;
mod solution;

pub use align::triangle_of;
pub use data::Data;
pub use extended::known as known_effects;
pub use faults::{FaultKind, SetAside};
pub use result::{Fitted, spread_of_magnitude};
pub use solution::{Alignment, Solution, WithoutEffects};

use crate::cli::Expected;
use crate::failure::Outcome;
use crate::input::Log;
use crate::prior::Prior;
use ironout::fit::{FitError, FitOptions, FitReport, Method, fit};
use ironout::whiteness::independent_share;

/// Magnitudes that the field has on Earth, with room for indoor iron, µT …
const EARTH_UT: std::ops::RangeInclusive<f64> = 12.0..=120.0;
/// … and one in the middle.
const TYPICAL_UT: f64 = 50.0;

/// An accelerometer whose dip spreads by more than this, at best, shows no gravity (or is another board's), degrees.
const MOST_SPREAD_DEG: f64 = 15.0;

/// What to fit and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The method.
    pub method: Method,
    /// What is known of the field.
    pub expected: Expected,
    /// Ids of the effects in the model.
    pub add: Vec<String>,
    /// An earlier calibration to build on.
    pub prior: Option<Prior>,
}

impl Options {
    /// The field to scale to: as expected, or else that of the earlier calibration.
    fn field_ut(&self) -> Option<f64> {
        self.expected.field_ut.or_else(|| self.prior.as_ref().map(Prior::field_ut))
    }
}

/// Fits a log. The fit may be refused; the counts of what was used and set aside are there all the same.
///
/// # Errors
/// Only where `options` ask for an effect that is not known or that this log does not allow.
pub fn run(log: &Log, options: &Options) -> Outcome<Fitted> {
    let data = Data::new(log);
    let mut unit = 1.0;
    let (mut fitted, mut moving) = run_gated(&data, options, unit);
    let own_field_ut = fitted.solution.as_ref().map(|solution| solution.measured_field_ut);
    if let Some(field) = own_field_ut.filter(|field| !EARTH_UT.contains(field)) {
        // No field of the Earth: the scale of the counts is not the true one, or --map took another unit.
        unit = TYPICAL_UT / field;
        (fitted, moving) = run_gated(&data, options, unit);
        fitted.reasons.push(format!(
            "note: the measurements have a magnitude of {field:.4} µT, which the Earth's field (22 to 67 µT) nowhere has: check the \
             unit of the columns (1 gauss is 100 µT, 1000 nT are 1 µT) or --ut-per-count"
        ));
    }
    if options.add.is_empty() && options.prior.is_none() {
        return Ok(fitted);
    }
    extended::run(&data, &moving, options, fitted)
}

fn run_gated(data: &Data, options: &Options, unit: f64) -> (Fitted, Vec<u32>) {
    let core =
        FitOptions { method: options.method, field_ut: options.expected.field_ut, ..Default::default() };
    let moving = data.moving(unit);
    let (used, aside) = faults::set_aside(data, &moving, &core);
    let mut fitted = Fitted::new(data, moving.len(), &aside, options);
    match fit_rows(data, &used, &core) {
        Err(error) => fitted.refuse(error),
        Ok(first) => {
            let core = FitOptions { effective_samples: effective_samples(data, &used, &first), ..core };
            match fit_rows(data, &used, &core) {
                Err(error) => fitted.refuse(error),
                Ok(report) => fitted.complete(data, &used, &core, &report),
            }
        }
    }
    (fitted, moving)
}

/// The core's fit of these samples.
fn fit_rows(data: &Data, samples: &[u32], options: &FitOptions) -> Result<FitReport, FitError> {
    let mut sums = data.sums();
    samples.iter().for_each(|&sample| sums.push(data, sample));
    let scatter = sums.finish(data)?;
    let mut report = fit(&scatter, options)?;
    report.add_noise_bias(&scatter);
    Ok(report)
}

/// Independent samples among those fitted: where the residual's second differences are smaller than its noise, the
/// noise is slow, and averaging removes less of it.
fn effective_samples(data: &Data, used: &[u32], report: &FitReport) -> Option<f64> {
    let residual = data.residual(used, &report.calibration);
    let gain = report.residual_floor_ut / report.noise_ut;
    let white_ut = floor::second_difference_sigma(used, &residual)? / gain;
    let share = independent_share(white_ut * white_ut, report.noise_ut * report.noise_ut);
    Some((used.len() as f64 * share).max(1.0))
}
