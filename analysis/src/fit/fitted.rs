//! What came out of a fit.

use crate::base::axes::Alignment;
use crate::base::beside_gyro::{BesideGyro, beside_gyro};
use crate::base::counted::{Aside, Counted, Why};
use crate::base::ground::Ground;
use crate::base::quality::error_beyond;
use crate::base::solution::Solution;
use crate::calibration::{Accelerometer, EffectEntry, HoldsFor};
use crate::correct::Corrector;
use crate::effects::calibrated;
use crate::fit::turn::where_to_turn;
use crate::outcome::contradiction::Contradiction;
use crate::outcome::outcome::Diagnosis;
use crate::outcome::request::Options;
use crate::reason::Reason;
use crate::samples::gravity::accelerometer;
use crate::samples::samples::{Condition, Samples};
use crate::samples::series::median;
use crate::table::Table;
use crate::unlogged::recordings::Recordings;
use ironout::calibration::{Calibration, norm};
use ironout::coverage::CoverageMap;
use ironout::effect::Registry;
use ironout::fit::{FitError, MAX_PREDICTED_ERROR};
use ironout::quality::{self, Verdict, judge_figures};
use serde::Serialize;
use std::collections::BTreeMap;

/// From this coverage on, and with gaps smaller than this, no side of the board is missing.
const ALL_ROUND: f32 = 0.9;
const ALL_ROUND_GAP_DEG: f32 = 40.0;

/// An error of this many times the noise floor is worth a diagnosis; a smaller one is the noise itself.
pub const MIN_ERROR_RATIO_TO_DIAGNOSE: f64 = 1.2;

/// The outcome of a fit.
#[derive(Debug, Clone, Serialize)]
pub struct Fitted {
    /// The magnitude of the field as it was given, µT.
    pub expected_field_ut: Option<f64>,
    /// [`crate::table::Table::fingerprint`] of the log.
    #[serde(skip)]
    pub log: String,
    /// Rows of the log.
    pub rows: usize,
    /// Rows that repeat the one before them.
    pub repeated: usize,
    /// Samples of a resting board.
    pub at_rest: usize,
    /// Samples set aside, by reason.
    pub aside: Vec<Aside>,
    /// Samples the fit is of.
    pub used: usize,
    /// The calibration, where there is one.
    pub solution: Option<Solution>,
    /// Rms of `‖measured‖` about its mean, over the mean: the error before any calibration.
    pub before: Option<(f64, f64)>,
    /// Rms error on held-out blocks of time, µT.
    pub holdout_rms_ut: Option<f64>,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_floor_ut: Option<f64>,
    /// What that noise makes of the corrected magnitude, rms, µT.
    pub residual_floor_ut: Option<f64>,
    /// The least that noise may make of it, µT: where this is lower, part of the error may be noise with a memory or an error
    /// that moves, which a residual alone does not tell.
    pub residual_floor_least_ut: Option<f64>,
    /// Dip of the field: of the world magnetic model, or as the accelerometer shows it.
    pub dip_deg: Option<f64>,
    /// Predicted 1σ error of the heading of a level reading, degrees; unknown without the dip.
    pub heading_error_deg: Option<f64>,
    /// Covered part of the sphere of directions.
    pub coverage: Option<f64>,
    /// The largest gap between directions, degrees.
    pub gap_deg: Option<f64>,
    /// How the columns were over the samples: what acts by them had its mean effect meanwhile.
    pub conditions: BTreeMap<String, Condition>,
    /// The calibration of the accelerometer, where it has something to correct: heading and rotation are by it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accelerometer: Option<Accelerometer>,
    /// What the gyro leaves of the field's direction, where the log has one that turns as the field does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beside_gyro: Option<BesideGyro>,
    /// What the log says against the earlier calibration that it was fitted on top of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contradiction: Option<Contradiction>,
    /// The attitudes that the calibration is for, where it is not for all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds_for: Option<HoldsFor>,
    /// The offsets of several recordings, where they differ: the calibration is of the last of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recordings: Option<Recordings>,
    /// Whether the calibration may be used.
    pub accepted: bool,
    /// Why not, or what to know.
    pub reasons: Vec<Reason>,
    /// Whether it is refused for samples at the end of the sensor's range and for nothing else: a fault of the data, which says
    /// nothing of the model.
    #[serde(skip)]
    pub only_saturated: bool,
    /// Whether nothing but the predicted error refuses it.
    #[serde(skip)]
    only_for_attitudes: bool,
    /// Whether effects were added to the model.
    #[serde(skip)]
    adds: bool,
}

impl Fitted {
    /// Of this log, whose recordings may have been moved to one offset.
    pub(crate) fn of_recordings(mut self, table: &Table, recordings: Option<Recordings>) -> Self {
        (self.log, self.recordings) = (table.fingerprint(), recordings);
        self
    }

    pub(crate) fn new(counted: &Counted, options: &Options) -> Self {
        Fitted {
            expected_field_ut: options.field_ut,
            recordings: None,
            log: counted.table.fingerprint(),
            rows: counted.table.rows(),
            repeated: counted.repeated,
            at_rest: counted.at_rest,
            aside: counted.aside.clone(),
            used: counted.used.len(),
            solution: None,
            before: None,
            holdout_rms_ut: None,
            noise_floor_ut: None,
            residual_floor_ut: None,
            residual_floor_least_ut: None,
            dip_deg: options.dip_deg,
            heading_error_deg: None,
            coverage: None,
            gap_deg: None,
            conditions: counted.samples.conditions(),
            accelerometer: accelerometer(counted.table),
            beside_gyro: None,
            contradiction: None,
            holds_for: None,
            accepted: false,
            reasons: Vec::new(),
            only_saturated: false,
            only_for_attitudes: false,
            adds: !options.add.is_empty(),
        }
    }

    pub(crate) fn of_base(mut self, ground: &Ground, registry: Registry) -> Self {
        match &ground.base {
            Err(error) => self.refuse(*error),
            Ok(base) => {
                self.holdout_rms_ut = base.holdout_rms_ut;
                self.noise_floor_ut = Some(base.noise_floor_ut);
                self.residual_floor_ut = Some(base.residual_floor_ut);
                self.residual_floor_least_ut = Some(base.residual_floor_least_ut);
                self.judge(&ground.counted, base.solution.clone(), registry);
            }
        }
        self.reasons.extend(ground.note());
        self
    }

    /// Whether the error of a solution is that of the sensor's noise.
    fn is_noise(&self, solution: &Solution) -> bool {
        self.residual_floor_ut.is_some_and(|floor| solution.rms_ut < MIN_ERROR_RATIO_TO_DIAGNOSE * floor)
    }

    fn refuse(&mut self, error: FitError) {
        self.reasons = Verdict::of_error(error).reasons.iter().map(of_core).collect();
    }

    /// What a solution is worth: coverage, heading, verdict.
    pub(crate) fn judge(&mut self, counted: &Counted, mut solution: Solution, registry: Registry) {
        // What held-out time shows is a lower bound, whatever the noise of the residual says.
        let held_out_ut = self.held_out_error_ut(&solution).unwrap_or(0.0);
        let shown_by_held_out = held_out_ut > solution.predicted_error_ut;
        solution.predicted_error_ut = solution.predicted_error_ut.max(held_out_ut);
        let calibration = solution.calibration;
        let fields = || counted.used.iter().map(|&sample| counted.data.field(sample));
        self.before = Some(spread_of_magnitude(fields().map(norm)));
        self.beside_gyro = Self::held_against_gyro(counted, &solution, registry);
        if let Some(beside) = self.varying_field(&solution) {
            solution.field_varies_by_ut = beside * calibration.field_ut;
        }
        // Axes that are not told from their mirror image have no dip, and no heading.
        let unknown = matches!(solution.alignment, Alignment::Mirrored(_) | Alignment::Open(_));
        self.dip_deg = match unknown {
            true => None,
            // An accelerometer whose dip spreads so far shows no gravity, and so no dip either.
            false if matches!(solution.alignment, Alignment::NoDip { .. }) => self.dip_deg,
            false => self.dip_deg.or_else(|| median_dip_deg(&counted.samples, &calibration)),
        };
        self.heading_error_deg = self.dip_deg.map(|dip_deg| {
            let level_ut = calibration.field_ut * dip_deg.to_radians().cos();
            let error_ut = solution.vector_error_ut().hypot(solution.rms_ut);
            error_ut.atan2(level_ut.abs()).to_degrees()
        });
        let mut map = CoverageMap::new();
        fields().for_each(|field| map.add(calibration.apply(field).map(|value| value as f32)));
        let coverage = map.coverage();
        self.coverage = Some(f64::from(coverage.fraction));
        self.gap_deg = Some(f64::from(coverage.gap_deg));
        let figures = solution.figures(self.used as u64);
        let verdict =
            judge_figures(&figures, Some(&coverage), counted.clipped() as u64, self.expected_field_ut);
        self.accepted = verdict.accepted;
        let refuses = verdict.reasons.iter().filter(|reason| reason.refuses());
        self.only_for_attitudes =
            refuses.clone().all(|reason| matches!(reason, quality::Reason::ErrorTooLarge { .. }));
        let mut refusals = refuses.peekable();
        self.only_saturated = refusals.peek().is_some()
            && refusals.all(|reason| matches!(reason, quality::Reason::Saturated { .. }));
        let vector_percent = 100.0 * solution.vector_error_ut() / calibration.field_ut;
        let all_round = coverage.fraction > ALL_ROUND && coverage.gap_deg < ALL_ROUND_GAP_DEG;
        self.reasons = (verdict.reasons.iter())
            .map(|reason| match reason {
                quality::Reason::ErrorTooLarge { percent, .. } if shown_by_held_out => {
                    Reason::new("held-out-error", of_unseen_time(*percent, self.adds))
                }
                quality::Reason::ErrorTooLarge { .. } if !all_round => {
                    let start_down = counted.samples.readings.iter().find_map(|reading| reading.down);
                    let words = format!(
                        "The predicted error of the corrected vector is {vector_percent:.2} % of the field (limit {:.0} %). \
                         Fix: {}",
                        100.0 * MAX_PREDICTED_ERROR,
                        where_to_turn(coverage.gap_direction, start_down, self.dip_deg)
                    );
                    Reason::new("too-few-orientations", words)
                }
                quality::Reason::ErrorTooLarge { .. } => {
                    Reason::new("log-too-short", of_a_short_log(vector_percent))
                }
                quality::Reason::ResidualTooLarge { percent } if self.is_noise(&solution) => {
                    Reason::new("residual-too-large", of_noise(*percent))
                }
                other => of_core(other),
            })
            .collect();
        if let Some(beside) = self.varying_field(&solution) {
            (self.accepted, self.only_saturated, self.only_for_attitudes) = (false, false, false);
            // A longer log is not a remedy for another field.
            self.reasons.clear();
            let words = of_another_field(beside, solution.rms_ut / calibration.field_ut);
            self.reasons.push(Reason::new("field-not-uniform", words));
        }
        if let Alignment::Mirrored(order_status) | Alignment::Open(order_status) = &solution.alignment {
            (self.accepted, self.only_saturated) = (false, false);
            let words = order_status.words().into_iter().map(|words| Reason::new("axis-order", words));
            self.reasons.splice(0..0, words);
        }
        self.solution = Some(solution);
    }

    /// The corrected field next to the gyro.
    fn held_against_gyro(counted: &Counted, solution: &Solution, registry: Registry) -> Option<BesideGyro> {
        counted.table.gyro_radps?;
        let entries: Vec<EffectEntry> = solution.effects.iter().map(EffectEntry::from).collect();
        let whole = calibrated(solution.calibration, &entries, registry).ok()?;
        let corrector = Corrector::new(whole, counted.table).ok()?;
        let corrected: Option<Vec<[f64; 3]>> =
            counted.samples.row.iter().map(|&row| corrector.correct(row).ok()).collect();
        beside_gyro(&counted.samples, &corrected?, solution.calibration.field_ut)
    }

    /// Rms of one axis across the field, over the field, where the gyro says that the field is another one from place to place.
    fn varying_field(&self, solution: &Solution) -> Option<f64> {
        let beside = self
            .beside_gyro
            .filter(|beside| beside.varies(solution.rms_ut / solution.calibration.field_ut))?;
        Some(beside.field)
    }

    /// The error of the calibration that held-out blocks of time show, µT rms along the field at the attitudes of the log.
    fn held_out_error_ut(&self, solution: &Solution) -> Option<f64> {
        Some(error_beyond(self.holdout_rms_ut?, solution.rms_ut)).filter(|error| error.is_finite())
    }

    /// Takes the counts of a study: next to the effects of a fit other samples stand out than of the base model.
    pub(crate) fn counts_as(&mut self, diagnosis: &Diagnosis) {
        self.used = diagnosis.samples_used;
        let others: usize =
            self.aside.iter().filter(|one| one.why != Why::Burst).map(|one| one.samples).sum();
        self.aside.retain(|one| one.why != Why::Burst);
        let samples = diagnosis.samples_set_aside.saturating_sub(others);
        if samples > 0 {
            self.aside.push(Aside { why: Why::Burst, samples });
        }
    }

    /// Whether nothing but the predicted error of a vector in any direction refuses it.
    pub(crate) fn is_refused_for_attitudes_only(&self) -> bool {
        self.only_for_attitudes
    }

    /// Whether it is refused for axes that do not stand as the accelerometer's.
    pub(crate) fn is_of_other_axes(&self) -> bool {
        let alignment = self.solution.as_ref().map(|solution| &solution.alignment);
        matches!(alignment, Some(Alignment::Mirrored(_) | Alignment::Open(_)))
    }

    /// Whether it is refused for a field that differs from place to place.
    pub(crate) fn is_of_another_field(&self) -> bool {
        self.solution.as_ref().is_some_and(|solution| self.varying_field(solution).is_some())
    }

    /// Samples set aside in all.
    pub fn set_aside(&self) -> usize {
        self.aside.iter().map(|one| one.samples).sum()
    }
}

/// A reason of the core's verdict.
fn of_core(reason: &quality::Reason) -> Reason {
    Reason::new(reason.code(), reason.to_string())
}

/// The reason where the residual is too large because of the noise of the sensor.
fn of_noise(percent: f64) -> String {
    format!(
        "the residual is {percent:.1} % of the field (limit {:.0} %), and nearly all of it is sensor noise. Fix: average several \
         readings, or choose a lower bandwidth of the sensor",
        100.0 * quality::MAX_RESIDUAL
    )
}

/// The reason where the gyro turns otherwise than the field; both figures are over the field.
fn of_another_field(across: f64, along: f64) -> String {
    format!(
        "The field is not uniform: over 2 s its direction differs from the gyro by {:.1} % of the field, {:.1} × the error \
         of the magnitude. Fix: keep away from magnets, steel and cables, and rotate the sensor in one spot",
        100.0 * across,
        across / along
    )
}

/// The reason where the held-out error says more than the noise does.
fn of_unseen_time(percent: f64, adds: bool) -> String {
    let remedy =
        if adds { "drop an added effect, or record longer" } else { "record longer, in more orientations" };
    format!(
        "The held-out error (10-fold) exceeds the noise by {percent:.1} % of the field (limit {:.0} %), so the fit does not \
         generalise. Fix: {remedy}, and run ironout diagnose to find the cause",
        MAX_PREDICTED_ERROR * 100.0
    )
}

/// The reason where the board was turned all round: more directions are not a remedy.
fn of_a_short_log(percent: f64) -> String {
    format!(
        "The predicted error of the corrected vector is {percent:.2} % of the field (limit {:.0} %), although the \
         log covers nearly all directions: the remaining error is too large for a log of this length. Fix: run ironout \
         diagnose to find the cause, or record longer",
        100.0 * MAX_PREDICTED_ERROR
    )
}

/// Median angle of the corrected field below the horizon that the accelerometer shows, degrees; `None` without one. The
/// rotation that magnitudes leave open makes it wrong by a few degrees until the axes are aligned.
fn median_dip_deg(samples: &Samples, calibration: &Calibration<f64>) -> Option<f64> {
    let mut dips: Vec<f64> = samples
        .readings
        .iter()
        .filter_map(|reading| {
            let [x, y, z] = reading.down?;
            let h = calibration.apply(reading.measured_ut);
            let sine = (x * h[0] + y * h[1] + z * h[2]) / norm(h);
            sine.is_finite().then(|| sine.clamp(-1.0, 1.0).asin().to_degrees())
        })
        .collect();
    (dips.len() >= 20).then(|| median(&mut dips))
}

/// Mean of magnitudes, and their rms about it.
pub fn spread_of_magnitude(magnitudes: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = magnitudes.clone().count().max(1) as f64;
    let mean = magnitudes.clone().sum::<f64>() / n;
    (mean, (magnitudes.map(|m| (m - mean) * (m - mean)).sum::<f64>() / n).sqrt())
}
