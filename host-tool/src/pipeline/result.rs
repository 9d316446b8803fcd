//! What came out of a fit.

use super::align::align_solution;
use super::{Alignment, Data, FaultKind, Options, SetAside, Solution, floor, holdout};
use crate::cal_file::{CalFile, EffectEntry, FitObject, VERSION};
use crate::cli::Expected;
use ironout::calibration::norm;
use ironout::coverage::CoverageMap;
use ironout::fit::{FitError, FitOptions, FitReport};
use ironout::quality::{Reason, Verdict, judge_figures};

/// The outcome of [`super::run`], for words and for JSON.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// What was known of the field.
    pub expected: Expected,
    /// Rows of the log.
    pub rows: usize,
    /// Samples: rows without repeats.
    pub samples: usize,
    /// Samples of a moving board.
    pub moving: usize,
    /// Samples set aside, by reason.
    pub aside: Vec<(FaultKind, usize)>,
    /// Set where outliers were so many that they were kept.
    pub too_many_outliers: Option<usize>,
    /// Samples the fit is of.
    pub used: usize,
    /// The calibration, where there is one.
    pub solution: Option<Solution>,
    /// Rms of `‖measured‖` about its mean, over the mean: the error before any calibration.
    pub before: Option<(f64, f64)>,
    /// Independent samples among those used.
    pub effective_samples: Option<f64>,
    /// Rms error on held-out blocks of time, µT.
    pub holdout_rms_ut: Option<f64>,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_floor_ut: Option<f64>,
    /// What that noise makes of the corrected magnitude, rms, µT.
    pub residual_floor_ut: Option<f64>,
    /// Dip of the field: of the world magnetic model, or as the accelerometer shows it.
    pub dip_deg: Option<f64>,
    /// Predicted 1σ error of the heading of a level reading, degrees; unknown without the dip.
    pub heading_error_deg: Option<f64>,
    /// Covered part of the sphere of directions.
    pub coverage: Option<f64>,
    /// The largest gap between directions, degrees.
    pub gap_deg: Option<f64>,
    /// Whether the calibration may be used.
    pub accepted: bool,
    /// Why not, or what to know.
    pub reasons: Vec<String>,
}

impl Fitted {
    pub(super) fn new(data: &Data, moving: usize, aside: &SetAside, options: &Options) -> Self {
        let mut counts: Vec<(FaultKind, usize)> = Vec::new();
        for (_, kind) in &aside.samples {
            match counts.iter_mut().find(|(known, _)| known == kind) {
                Some((_, count)) => *count += 1,
                None => counts.push((*kind, 1)),
            }
        }
        Fitted {
            expected: options.expected,
            rows: data.log.rows,
            samples: data.rows.len(),
            moving,
            aside: counts,
            too_many_outliers: aside.too_many,
            used: moving - aside.samples.len(),
            solution: None,
            before: None,
            effective_samples: None,
            holdout_rms_ut: None,
            noise_floor_ut: None,
            residual_floor_ut: None,
            dip_deg: None,
            heading_error_deg: None,
            coverage: None,
            gap_deg: None,
            accepted: false,
            reasons: Vec::new(),
        }
    }

    pub(super) fn refuse(&mut self, error: FitError) {
        self.reasons = Verdict::of_error(error).reasons.iter().map(Reason::to_string).collect();
    }

    pub(super) fn complete(&mut self, data: &Data, used: &[u32], core: &FitOptions, report: &FitReport) {
        let calibration = report.calibration;
        let residual = data.residual(used, &calibration);
        self.effective_samples = core.effective_samples;
        self.holdout_rms_ut = holdout::rms_ut(data, used, core, calibration.field_ut);

        // rms‖Cᵀu‖: what a unit of noise on each axis makes of the corrected magnitude.
        let gain = report.residual_floor_ut / report.noise_ut;
        let fast = floor::second_difference_sigma(used, &residual).map(|sigma| sigma / gain);
        let noise = fast.map_or(report.noise_ut, |fast| fast.min(report.noise_ut));
        self.noise_floor_ut = Some(noise);
        self.residual_floor_ut = Some(noise * gain);

        let mut solution = Solution::of_report(report);
        align_solution(data, used, &mut solution, &report.spread.covariance());
        self.judge(data, used, solution);
    }

    /// What a solution is worth: coverage, heading, verdict.
    pub(super) fn judge(&mut self, data: &Data, used: &[u32], solution: Solution) {
        let calibration = solution.calibration;
        self.before = Some(spread_of_magnitude(used.iter().map(|&sample| norm(data.field(sample)))));
        self.dip_deg =
            self.expected.earth.map(|earth| earth.dip_deg).or_else(|| data.dip_deg(used, &calibration));
        self.heading_error_deg = self.dip_deg.map(|dip_deg| {
            let level_ut = calibration.field_ut * dip_deg.to_radians().cos();
            let error_ut = solution.predicted_error_ut.hypot(solution.rms_ut);
            error_ut.atan2(level_ut.abs()).to_degrees()
        });
        let mut map = CoverageMap::new();
        for &sample in used {
            map.add(calibration.apply(data.field(sample)).map(|value| value as f32));
        }
        let coverage = map.coverage();
        self.coverage = Some(f64::from(coverage.fraction));
        self.gap_deg = Some(f64::from(coverage.gap_deg));
        let figures = solution.figures(self.used as u64);
        let verdict = judge_figures(&figures, Some(&coverage), self.clipped(), self.expected.field_ut);
        self.accepted = verdict.accepted;
        self.reasons = verdict.reasons.iter().map(Reason::to_string).collect();
        if let Alignment::Mirrored { order } = &solution.alignment {
            self.accepted = false;
            self.reasons.insert(
                0,
                format!(
                    "against the accelerometer, the magnetometer's axes stand for {order}: the axes of a left hand, so that \
                     corrected vectors would point elsewhere; mend the driver, or read the log with --rotate mag:{}",
                    inverse_order(order)
                ),
            );
        }
        self.solution = Some(solution);
    }

    /// Samples at the end of the sensor's range.
    fn clipped(&self) -> u64 {
        let clipped = self.aside.iter().filter(|(kind, _)| matches!(kind, FaultKind::Clipping { .. }));
        clipped.map(|(_, count)| *count as u64).sum()
    }

    /// Samples set aside in all.
    pub fn set_aside(&self) -> usize {
        self.aside.iter().map(|(_, count)| count).sum()
    }

    /// The object of `fit --json`.
    pub fn object(&self, method: &str) -> FitObject {
        let solution = self.solution.as_ref();
        FitObject {
            method: method.to_string(),
            samples_used: self.used as u64,
            samples_set_aside: self.set_aside() as u64,
            field_ut: solution.map(|s| s.calibration.field_ut),
            offset_ut: solution.map(|s| s.calibration.offset_ut),
            matrix: solution.map(|s| s.calibration.matrix),
            effects: solution.map_or(Vec::new(), |s| s.effects.iter().map(EffectEntry::from).collect()),
            std_errors: solution.map(|s| s.std_errors.clone()),
            rms_ut: solution.map(|s| s.rms_ut),
            holdout_rms_ut: self.holdout_rms_ut,
            noise_floor_ut: self.noise_floor_ut,
            residual_floor_ut: self.residual_floor_ut,
            heading_error_deg: self.heading_error_deg,
            coverage: self.coverage,
            gap_deg: self.gap_deg,
            accepted: self.accepted,
            reasons: self.reasons.clone(),
        }
    }

    /// The calibration file.
    pub fn cal_file(&self, method: &str) -> CalFile {
        let information = self.solution.as_ref().and_then(|solution| solution.information.clone());
        CalFile { version: VERSION, fit: self.object(method), information }
    }
}

/// Body x,y,z from the log's axes, where `order` says which body axis each of the log's axes stands for.
fn inverse_order(order: &str) -> String {
    let axes: Vec<&str> = order.split(',').collect();
    let names = ["x", "y", "z"].map(|body| {
        let place = axes.iter().position(|axis| axis.trim_start_matches('-') == body).unwrap_or_default();
        let sign = if axes.get(place).is_some_and(|axis| axis.starts_with('-')) { "-" } else { "" };
        format!("{sign}{}", ["x", "y", "z"][place])
    });
    names.join(",")
}

/// Mean of magnitudes, and their rms about it.
pub fn spread_of_magnitude(magnitudes: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = magnitudes.clone().count().max(1) as f64;
    let mean = magnitudes.clone().sum::<f64>() / n;
    (mean, (magnitudes.map(|m| (m - mean) * (m - mean)).sum::<f64>() / n).sqrt())
}
