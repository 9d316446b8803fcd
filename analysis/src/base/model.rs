//! The base model: the core's fit of the samples that count, as on the board, with the noise as its residual shows it.

use crate::base::alignment::align;
use crate::base::axes::{Aligned, Found};
use crate::base::counted::Counted;
use crate::base::dip_errors::DipErrors;
use crate::base::engine::Design;
use crate::base::hemisphere::{Evidence, settle};
use crate::base::holdout;
use crate::base::prior::Prior;
use crate::base::quality::{NoiseEstimate, Sizes, gradients, memory_of_scores, residue_of};
use crate::base::solution::Solution;
use crate::base::start::{self, NO_ROTATION};
use crate::noise::own::OwnNoise;
use crate::plain;
use crate::samples::data::Data;
use ironout::calibration::{Calibration, norm};
use ironout::fit::{FitError, FitOptions, FitReport, Method, Order, fit};
use ironout::study::{Model, Residual};
use serde::Serialize;

/// The offset of a journey stands when it moves by less than this share of the field ...
const DRAWN: f64 = 1e-9;
/// ... which takes a few rounds.
const MOST_DRAWN: usize = 12;

/// A base model and what is known about it.
#[derive(Debug, Clone, Serialize)]
pub struct Base {
    /// The method.
    #[serde(serialize_with = "plain::method")]
    pub method: Method,
    /// The core's answer, with the number of independent samples.
    #[serde(skip)]
    pub report: FitReport,
    /// What its residual is made of.
    pub residue: NoiseEstimate,
    /// Calibration, errors and alignment.
    pub solution: Solution,
    /// Rms error on held-out blocks of time, µT.
    pub holdout_rms_ut: Option<f64>,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_floor_ut: f64,
    /// What that noise makes of the corrected magnitude, rms, µT.
    pub residual_floor_ut: f64,
    /// The same if all that is slow is an error that moves, µT.
    pub residual_floor_least_ut: f64,
}

impl Base {
    /// Fits the samples that count, scaled to `field_ut`. The dip of the place, or the log's reference heading, tells a
    /// mounting from a mirror image.
    ///
    /// # Errors
    /// The core's.
    pub fn of(
        counted: &Counted,
        method: Method,
        field_ut: Option<f64>,
        dip_deg: Option<f64>,
    ) -> Result<Self, FitError> {
        let used = &counted.used;
        let white = FitOptions { method, field_ut, ..FitOptions::default() };
        let drawn = in_one_field(counted, &white)?;
        let data = drawn.as_ref().unwrap_or(&counted.data);
        let first = fit_samples(data, used, &white)?;
        let residual = data.residual(used, &first.calibration);
        let step_s = counted.samples.step_s() / counted.samples.stride as f64;
        // Where noise has a memory, or structure remains, averaging removes less of it.
        let memory = Sizes::of(&residual).memory();
        let independent = used.len() as f64 / memory;
        let options = FitOptions { effective_samples: Some(independent.max(1.0)), ..white };
        let mut report = fit_samples(data, used, &options)?;
        let by_scores = scores_memory(counted, &report.calibration);
        if by_scores > memory {
            // The order stays: what is left may be an effect that is not known yet, and says nothing of it.
            let lower_orders = report.model != Order::Ellipsoid;
            let effective_samples = Some((used.len() as f64 / by_scores).max(1.0));
            report = fit_samples(data, used, &FitOptions { effective_samples, lower_orders, ..options })?;
        }
        let directions = gradients(used.iter().map(|&sample| data.field(sample)), &report.calibration);
        let left = data.residual(used, &report.calibration);
        let noise = OwnNoise::of(&left, &directions, 1, step_s);
        let residue = residue_of(&left, noise, report.model.parameters());
        // rms‖Cᵀu‖: what a unit of noise on each axis makes of the corrected magnitude.
        let gain = report.residual_floor_ut / report.noise_ut;
        let mut base = Base {
            method,
            holdout_rms_ut: holdout::rms_ut(data, used, &options, report.calibration.field_ut),
            noise_floor_ut: residue.floor / gain,
            residual_floor_ut: residue.floor,
            residual_floor_least_ut: residue.floor_least,
            solution: Solution::of_report(&report),
            residue,
            report,
        };
        if let Some(aligned) = base.aligned(counted, dip_deg) {
            base.solution.take(aligned);
        }
        Ok(base)
    }

    /// The model of the core's fit, for a study to go on from.
    pub fn model(&self) -> Option<Model<f64>> {
        let calibration = &self.report.calibration;
        Model::new(calibration.offset_ut, calibration.matrix, calibration.field_ut, NO_ROTATION, 0.0)
    }

    /// Predicted error of a corrected vector in the worst direction, as a share of the field.
    pub fn predicted_share(&self) -> f64 {
        self.report.predicted_error_ut / self.report.calibration.field_ut
    }

    fn aligned(&self, counted: &Counted, dip_deg: Option<f64>) -> Option<Aligned> {
        let samples = &counted.samples;
        let down = samples.readings.iter().filter(|reading| reading.down.is_some()).count();
        if counted.rests || down * 10 <= 3 * samples.len() {
            return None;
        }
        // There are no effects here whose shape could fail.
        let found = align(samples, &self.model()?).ok()??;
        let evidence = Evidence { heading_deg: counted.table.heading_deg, dip_deg };
        let (order_status, model) = settle(samples, &found, &[], evidence);
        let rotation = DipErrors::of(samples, &model, &[], None).ok()?.map(|errors| errors.rotation(None));
        let dip = Found {
            before_deg: found.before_deg,
            after_deg: found.after_deg,
            angle_deg: found.angle_deg,
            order_status,
            rotation: rotation.as_ref(),
        };
        let covariance = self.report.spread.covariance();
        Aligned::of(&model.full_matrix(), &covariance, self.predicted_share(), Some(dip))
    }
}

/// [`memory_of_scores`] of the core's fit; 1 where there is no such model.
fn scores_memory(counted: &Counted, calibration: &Calibration<f64>) -> f64 {
    let Calibration { offset_ut, matrix, field_ut } = *calibration;
    let design = Design::new(&counted.samples, Residual::Magnitude);
    let model = Model::new(offset_ut, matrix, field_ut, NO_ROTATION, 0.0);
    // There is no effect here whose shape could fail.
    let held = model.and_then(|model| design.hold(model, Vec::new(), &Prior::default()).ok());
    held.map_or(1.0, |held| memory_of_scores(&design, &held))
}

/// The samples of a journey as if the field were one, which the core's fit needs; `None` where it is. The offset about which they are
/// drawn and that of the fit are the same in the end: each round leaves of their difference what the field changes by.
fn in_one_field<'a>(counted: &Counted<'a>, options: &FitOptions) -> Result<Option<Data<'a>>, FitError> {
    let (data, used) = (&counted.data, &counted.used);
    let rough = start::sphere(&counted.samples).map_or([0.0; 3], |(centre, _)| centre);
    let Some(mut drawn) = data.in_one_field(rough) else { return Ok(None) };
    let mut about = rough;
    for _ in 0..MOST_DRAWN {
        let Calibration { offset_ut, field_ut, .. } = fit_samples(&drawn, used, options)?.calibration;
        let moved = norm([0, 1, 2].map(|axis| offset_ut[axis] - about[axis]));
        let Some(next) = data.in_one_field(offset_ut) else { break };
        (drawn, about) = (next, offset_ut);
        if moved < DRAWN * field_ut {
            break;
        }
    }
    Ok(Some(drawn))
}

/// The core's fit of these samples.
fn fit_samples(data: &Data, samples: &[u32], options: &FitOptions) -> Result<FitReport, FitError> {
    let mut sums = data.sums();
    samples.iter().for_each(|&sample| sums.push(data, sample));
    let scatter = sums.finish(data)?;
    let mut report = fit(&scatter, options)?;
    report.add_noise_bias(&scatter);
    Ok(report)
}
