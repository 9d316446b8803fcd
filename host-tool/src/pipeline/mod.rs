//! From a log to a judged calibration: which samples count, the core's fit of them, and what the fit is worth.
//!
//! 1. a triple that repeats is one sample;
//! 2. faults of the data (clipping, gross outliers) are set aside, by a fit that is repeated without them;
//! 3. a resting board adds nothing (the core's gate);
//! 4. the core's fit, with the number of *independent* samples taken from the residual's second differences;
//! 5. held-out error, noise floor, coverage, and the core's verdict.

mod data;
mod faults;
mod floor;
mod holdout;
mod result;

pub use data::Data;
pub use faults::{FaultKind, SetAside};
pub use result::{Fitted, spread_of_magnitude};

use crate::cli::Expected;
use crate::input::Log;
use ironout::fit::{FitError, FitOptions, FitReport, Method, fit};
use ironout::whiteness::independent_share;

/// Magnitudes that the field has on Earth, with room for indoor iron, µT …
const EARTH_UT: std::ops::RangeInclusive<f64> = 12.0..=120.0;
/// … and one in the middle.
const TYPICAL_UT: f64 = 50.0;

/// What to fit and how.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// The method.
    pub method: Method,
    /// What is known of the field.
    pub expected: Expected,
}

/// Fits a log. The fit may be refused; the counts of what was used and set aside are there all the same.
pub fn run(log: &Log, options: &Options) -> Fitted {
    let data = Data::new(log);
    let fitted = run_gated(&data, options, 1.0);
    let own_field_ut = fitted.report.as_ref().map(|report| report.measured_field_ut);
    match own_field_ut.filter(|field| !EARTH_UT.contains(field)) {
        // No field of the Earth: the scale of the counts is not the true one, or --map took another unit.
        Some(field) => run_gated(&data, options, TYPICAL_UT / field),
        None => fitted,
    }
}

fn run_gated(data: &Data, options: &Options, unit: f64) -> Fitted {
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
                Ok(report) => fitted.complete(data, &used, &core, report),
            }
        }
    }
    fitted
}

/// The core's fit of these samples.
fn fit_rows(data: &Data, samples: &[u32], options: &FitOptions) -> Result<FitReport, FitError> {
    let mut sums = data.sums();
    samples.iter().for_each(|&sample| sums.push(data, sample));
    fit(&sums.finish(data)?, options)
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
