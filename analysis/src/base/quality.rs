//! Precision of a fitted model, the noise floor, and whether structure remains.

use crate::base::engine::{Design, Fitted};
use crate::base::prior::Prior;
use crate::base::term::{COLUMNS, Matrix, Term};
use crate::noise::colour::{Colour, Seen};
use crate::noise::shared::together;
use crate::noise::still::Still;
use crate::noise::stretches::{stretches, within};
use crate::noise::turning::Turning;
use crate::samples::scores::Scores;
use crate::samples::series::{Autocorrelation, rms, second_difference_sigma};
use ironout::calibration::Calibration;
use ironout::effect::{Quantities, no_shape};
use ironout::study::{Model, PhysicalPrior, Residual};
use ironout::whiteness::independent_share;
use nalgebra::{DMatrix, Matrix3, SMatrix, Vector3};
use serde::Serialize;

/// The error of an effect is averaged over its columns' values at so many samples of the log.
const CONDITIONS: usize = 8;
/// Structure is certain where the correlation beyond the noise's memory exceeds chance this much (mean squares).
const STRUCTURE_RATIO: f64 = 6.0;
/// Or a slow part stands beside independent noise by this many standard errors ...
const STRUCTURE_SIGMAS: f64 = 6.0;
/// ... with at least this share of the variance.
const SLOW_SHARE: f64 = 0.1;
/// ... that takes longer than this to fade, samples ...
const SLOW_MEMORY: usize = 13;
/// ... or longer than this, s: a sensor's own slow noise (its 1/f noise, a filter before the part that is white) is
/// forgotten sooner than anything that turns with the board.
const SLOW_MEMORY_S: f64 = 0.42;
/// Or the spectrum is another one than any noise's by this many standard deviations.
const STRUCTURE_MISFIT: f64 = 10.0;
/// Structure makes at least this share of the residual's variance.
const STRUCTURE_SHARE: f64 = 0.04;

/// Where the board rests noise is the same: less than this share of its squares ...
const LESS_AT_REST: f64 = 0.8;
/// ... of noise that is alike to more than this from sample to sample ...
const LEAST_MEMORY: f64 = 0.2;
/// ... (no sensor is so much quieter than this share of the squares) ...
const LEAST_AT_REST: f64 = 0.01;
/// ... and less by so many standard errors, comes with the turning. Of 160 simulated logs with nothing hidden the least was -2.7.
const LESS_BY_SIGMAS: f64 = 5.0;

/// What the residual of a model is made of.
#[derive(Debug, Clone, Serialize)]
pub struct NoiseEstimate {
    /// Rms, µT.
    pub rms: f64,
    /// The part of it that is noise, µT.
    pub floor: f64,
    /// The least that the noise may be, µT: what is new from sample to sample. What is slower than that may be noise with a
    /// memory or an error that moves, and a residual alone does not tell.
    pub floor_least: f64,
    /// Share of the variance that is structure; zero where none is certain.
    pub structure: f64,
    /// Integrated autocorrelation time, samples.
    pub time: f64,
    /// How many samples say as much about the calibration as one independent sample: what every predicted error rests on,
    /// whichever way the fit went. Noise with a memory and structure count alike: averaging removes neither.
    pub memory: f64,
    /// What noise it is most like.
    pub colour: Colour,
    /// By how many standard deviations its spectrum is another one than that.
    pub misfit: f64,
    /// Whether it is that noise and nothing more.
    pub is_noise: bool,
}

/// What of a residual is computed of all its samples, however many.
#[derive(Debug, Clone, Copy)]
pub struct Sizes {
    /// Samples.
    n: usize,
    /// Rms, µT.
    rms: f64,
    /// σ of what is new from sample to sample, µT.
    quick: f64,
}

impl Sizes {
    /// Of a whole residual.
    pub fn of(residuals: &[f64]) -> Self {
        Sizes { n: residuals.len(), rms: rms(residuals), quick: second_difference_sigma(residuals) }
    }

    /// [`NoiseEstimate::memory`], from the second differences: those hold what is new from sample to sample.
    pub fn memory(&self) -> f64 {
        let share = independent_share(self.quick * self.quick, self.rms.powi(2));
        1.0 / share.max(1.0 / self.n.max(1) as f64)
    }
}

/// Splits the residual of a model into noise and structure. Noise with a short memory is noise.
pub fn residue(design: &Design, model: &Model<f64>, residuals: &[f64], parameters: usize) -> NoiseEstimate {
    let samples = design.samples;
    let sizes = Sizes::of(residuals);
    let (quantum_ut, step_s) = (samples.quantum_ut, samples.step_s());
    if design.residual != Residual::Magnitude {
        let turning = Turning::none(residuals.len());
        return residue_by_part(&sizes, residuals, parameters, quantum_ut, step_s, &turning);
    }
    let stretches = stretches(residuals.len());
    let Model { offset_ut, matrix, field_ut, .. } = *model;
    let calibration = Calibration { offset_ut, matrix, field_ut };
    let readings = within(&samples.readings, &stretches).into_iter();
    let directions = readings.map(|reading| calibration.apply(reading.measured_ut));
    let turning = Turning::of(directions, &matrix).beside(&samples.rest, samples.stride, &calibration);
    let part = within(residuals, &stretches);
    residue_by_part(&sizes, &part, parameters, quantum_ut, step_s, &turning)
}

/// The same of a residual of these sizes, its colour and structure by a `part` of it ([`crate::noise::stretches`]) that `turning`, how
/// the board turned meanwhile, is of. `quantum_ut` is the step of the readings, `step_s` that of their times (0 where unknown).
pub fn residue_by_part(
    sizes: &Sizes,
    part: &[f64],
    parameters: usize,
    quantum_ut: f64,
    step_s: f64,
    turning: &Turning,
) -> NoiseEstimate {
    let n = part.len();
    let correlation = Autocorrelation::of(part);
    let freedom = sizes.n.saturating_sub(parameters).max(1) as f64;
    let whole = sizes.rms * (sizes.n as f64 / freedom).sqrt();
    let quick = sizes.quick;
    let smooth = quick.min(whole);
    let share = 1.0 - (smooth / whole.max(1e-300)).powi(2);
    // Independent noise that is more than the column's rounding, with something slow beside it: two causes, of which the
    // slow one is structure. Noise with a memory alone has no independent part, and noise of both kinds a short memory.
    let rounding = quantum_ut * quantum_ut / 12.0 / whole.max(1e-300).powi(2);
    let fades = correlation.fades_after();
    let slow_to_fade = fades > SLOW_MEMORY || fades as f64 * step_s > SLOW_MEMORY_S;
    let beside = correlation.two_parts(n).is_some_and(|(independent, slow, sigmas)| {
        sigmas > STRUCTURE_SIGMAS && independent > 3.0 * rounding && slow > SLOW_SHARE && slow_to_fade
    });
    let noise = Seen::of(part, turning, &turning.absorbed, rounding).describe();
    let odd = correlation.structure(n) > STRUCTURE_RATIO || beside;
    let lines = noise.misfit() > STRUCTURE_MISFIT && noise.excess > STRUCTURE_SHARE;
    // A resting board's own drifts, and what a logger rounds, look like slow noise: there only a short memory is noise.
    // What has a memory and moves the axes together is no sensor's own.
    let together = noise.colour != Colour::White && together(part, turning, noise.colour, rounding);
    // What is less at rest comes with the turning.
    let remembers = match noise.colour {
        Colour::White => false,
        Colour::Ar1(rho) => rho > LEAST_MEMORY,
        Colour::RollingMean { .. } | Colour::Flicker { .. } => true,
    };
    let rests = remembers.then(|| Still::of(part, turning, noise.colour, rounding)).flatten();
    let rests = rests.filter(|still| still.sigmas < -LESS_BY_SIGMAS && still.share < LESS_AT_REST);
    let is_noise = turning.of_magnitude && noise.is_noise(step_s) && !together && rests.is_none();
    // A memory that no filter has, or a spectrum that no noise with a memory has: an error that moves. A rolling mean's has zeros,
    // which rounding and the board's turns fill.
    let forgets = matches!(noise.colour, Colour::Ar1(_) | Colour::Flicker { .. });
    let own = noise.colour.is_of_a_sensor(step_s) && (is_noise || !forgets) && !together && rests.is_none();
    let moves = turning.of_magnitude && !own;
    let (share, smooth) = match rests.map(|still| still.share.max(LEAST_AT_REST)) {
        Some(still) if 1.0 - still > share => (1.0 - still, whole * still.sqrt()),
        _ => (share, smooth),
    };
    let structured = ((odd || moves) && share > STRUCTURE_SHARE || lines) && !is_noise;
    // Fast structure is in the second differences too.
    let (share, smooth) = match lines && noise.excess > share {
        true => (noise.excess, whole * (1.0 - noise.excess).sqrt()),
        false => (share, smooth),
    };
    let floor = if structured { smooth } else { whole };
    NoiseEstimate {
        rms: sizes.rms,
        floor_least: if noise.colour == Colour::White { floor } else { floor.min(quick) },
        floor,
        structure: if structured { share } else { 0.0 },
        time: correlation.time,
        memory: sizes.memory(),
        colour: noise.colour,
        misfit: noise.misfit(),
        is_noise,
    }
}

/// Covariance of all columns: `σ² τ N⁻¹`.
pub fn covariance(fitted: &Fitted, time: f64) -> Option<Vec<[f64; COLUMNS]>> {
    covariance_of(&fitted.total(), fitted, time)
}

/// What the magnitude leaves open and the fit holds, it holds tightly: it adds no error of its own.
fn held(total: &Matrix, fitted: &Fitted) -> Matrix {
    let mut total = total.clone();
    let mut column = Residual::Magnitude.base_columns();
    for term in &fitted.terms {
        let hidden = term.hidden_delay();
        if !hidden.is_empty() {
            let k = term.k();
            let weight = 1e6 * (0..k).map(|i| total.entry(column + i, column + i)).sum::<f64>() / k as f64;
            for &i in hidden {
                for &j in hidden.iter().filter(|j| **j >= i) {
                    total.inform(column + i, column + j, weight);
                }
            }
        }
        column += term.k();
    }
    total
}

/// The same of a normal matrix with further columns, whose share in the errors of the others counts.
pub fn covariance_of(total: &Matrix, fitted: &Fitted, time: f64) -> Option<Vec<[f64; COLUMNS]>> {
    let factor = held(total, fitted).factor()?;
    let freedom = (fitted.rows - fitted.columns() as f64).max(1.0);
    let variance = fitted.squares / freedom * time;
    Some(
        (0..fitted.columns())
            .map(|column| factor.inverse_column(column).map(|value| value * variance))
            .collect(),
    )
}

/// Predicted 1σ error (rms length) of the corrected vector in the worst direction, in units of the field:
/// `δh = δC y − C δb − C Φ δθ` with `y = A h`, in the mean over what the effects' columns were: offset and matrix trade against them, and
/// only together do their errors mean anything.
pub fn predicted_error(design: &Design, fitted: &Fitted, known: &Prior, left: &NoiseEstimate) -> Option<f64> {
    // What is known besides stands against the data as they count: as of so many fewer samples.
    let data = Matrix::total(&fitted.blocks, None);
    let list: Vec<&Term> = fitted.terms.iter().collect();
    let sigma = fitted.sigma() * left.memory.sqrt();
    let prior = known.matrix(design.residual, &fitted.model, sigma, &list, &data);
    let total = Matrix::total(&fitted.blocks, Some(&prior));
    error_of_vector(
        fitted,
        &covariance_of(&total, fitted, left.memory.max(memory_of_scores(design, fitted)))?,
    )
}

/// Number of samples that say as much about the parameters as one independent sample, by batch means of the score ([`Scores`]): the spread
/// of the sums of `Jᵀr` over that of independent samples, mean over the parameters.
pub fn memory_of_scores(design: &Design, fitted: &Fitted) -> f64 {
    let columns = fitted.columns();
    let list: Vec<&Term> = fitted.terms.iter().collect();
    let n = design.samples.len();
    let mut scores = Scores::new(columns, n);
    let done =
        design.rows(0..n, &fitted.model, &list, |sample, row, residual| scores.add(sample, row, residual));
    let Some(factor) = held(&fitted.total(), fitted).factor().filter(|_| done.is_ok()) else { return 1.0 };
    let inverse = DMatrix::from_fn(columns, columns, |i, j| factor.inverse_column(j)[i]);
    // tr(N⁻¹ M), with M the spread of the scores.
    let spread = inverse.component_mul(&scores.spread()).sum();
    let memory = spread / (columns as f64 * fitted.sigma().powi(2));
    // Independent samples make it 1 within this standard error; as much of it as is certain by two of them counts.
    let error = (2.0 / (Scores::FREEDOM * columns as f64)).sqrt();
    let memory = memory / (1.0 + 2.0 * error);
    if memory.is_finite() { memory.max(1.0) } else { 1.0 }
}

/// The same as the attitude alone decides it: were the effects known, and every sample's noise its own. A log that is
/// only too short for its noise or for its effects can still be diagnosed.
pub fn attitude_error(fitted: &Fitted, left: &NoiseEstimate) -> Option<f64> {
    let base = Residual::Magnitude.base_columns();
    let keep: [usize; 9] = core::array::from_fn(|column| column);
    let factor = fitted.total().select(&keep).factor()?;
    let variance = left.floor * left.floor;
    let mut covariance = vec![[0.0; COLUMNS]; fitted.columns()];
    for (column, row) in covariance.iter_mut().enumerate().take(base) {
        *row = factor.inverse_column(column).map(|value| value * variance);
    }
    error_of_vector(fitted, &covariance)
}

fn error_of_vector(fitted: &Fitted, covariance: &[[f64; COLUMNS]]) -> Option<f64> {
    let matrix = Matrix3::from_fn(|i, j| fitted.model.matrix[i][j]);
    let inverse = matrix.try_inverse()?;
    let columns = fitted.columns();
    // At the columns' values of some samples: what a column does has its error where the column is.
    let samples = fitted.terms.iter().map(|term| term.inputs.len()).max().unwrap_or_default();
    let conditions: Vec<usize> = match samples {
        0 => vec![0],
        _ => (0..CONDITIONS).map(|place| (2 * place + 1) * samples / (2 * CONDITIONS)).collect(),
    };
    let triangle = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
    let directions = 200;
    let mut worst = 0.0_f64;
    for index in 0..directions {
        // A spiral of equal areas.
        let z = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(directions);
        let (r, angle) = ((1.0 - z * z).sqrt(), f64::from(index) * 2.399_963_229_728_653);
        let y = inverse * Vector3::new(r * angle.cos(), r * angle.sin(), z) * fitted.model.field_ut;
        let mut square = 0.0;
        for &condition in &conditions {
            let shapes = shapes_of_effects(fitted, y, condition);
            for row in 0..3 {
                let mut weights = [0.0; COLUMNS];
                for axis in 0..3 {
                    weights[axis] = -matrix[(row, axis)];
                }
                for (slot, (_, j)) in triangle.into_iter().enumerate().filter(|(_, (i, _))| *i == row) {
                    weights[3 + slot] = y[j];
                }
                for (column, shape) in &shapes {
                    weights[*column] = -(matrix * shape)[row];
                }
                let used: Vec<usize> = (0..columns).filter(|column| weights[*column] != 0.0).collect();
                for &i in &used {
                    square += used.iter().map(|&j| weights[i] * covariance[i][j] * weights[j]).sum::<f64>();
                }
            }
        }
        worst = worst.max(square / conditions.len() as f64);
    }
    Some(worst.sqrt() / fitted.model.field_ut).filter(|error| error.is_finite())
}

/// The columns of the effects but those of a turning board, each with its shape where the undisturbed sensor reads `centred_ut` beside its
/// offset and the columns are as at this sample.
fn shapes_of_effects(fitted: &Fitted, centred_ut: Vector3<f64>, sample: usize) -> Vec<(usize, Vector3<f64>)> {
    let mut out = Vec::new();
    let mut column = Residual::Magnitude.base_columns();
    let measured_ut = (Vector3::from(fitted.model.offset_ut) + centred_ut).into();
    for term in &fitted.terms {
        if !term.effect.needs_gyro() {
            let inputs = term.inputs.get(sample).copied().unwrap_or_default();
            let at =
                Quantities { centred_ut: centred_ut.into(), inputs, ..Quantities::of_vector(measured_ut) };
            let mut shape = no_shape();
            term.effect.shape(&at, &mut shape);
            out.extend(
                shape.into_iter().take(term.k()).enumerate().map(|(i, v)| (column + i, Vector3::from(v))),
            );
        }
        column += term.k();
    }
    out
}

/// Information about offset and triangle with the effects projected out, over variance: of the data and of an earlier
/// calibration, never of the physical prior, which the next study brings itself.
pub fn information(design: &Design, fitted: &Fitted, known: &Prior, time: f64) -> Option<[[f64; 9]; 9]> {
    let free = PhysicalPrior { gain: 1e6, skew: 1e6, offset_fields: 1e9 };
    let data_only = Prior { physical: free, earlier: known.earlier.clone(), ..Prior::default() };
    let data = Matrix::total(&fitted.blocks, None);
    let sigma = (fitted.squares / (fitted.rows - fitted.columns() as f64).max(1.0)).sqrt();
    let list: Vec<&Term> = fitted.terms.iter().collect();
    let prior = data_only.matrix(design.residual, &fitted.model, sigma, &list, &data);
    let covariance = covariance_of(&Matrix::total(&fitted.blocks, Some(&prior)), fitted, time)?;
    let nine = SMatrix::<f64, 9, 9>::from_fn(|i, j| covariance[i][j]);
    let inverse = nine.cholesky()?.inverse();
    Some(core::array::from_fn(|i| core::array::from_fn(|j| inverse[(i, j)])))
}

/// The error of a calibration that the held-out error shows beside that of the samples it was fitted to (all rms, of one
/// unit): noise is in both alike, and the fit's own error raises the one by as much as fitting lowers the other.
pub fn error_beyond(held_out: f64, seen: f64) -> f64 {
    (0.5 * (held_out * held_out - seen * seen).max(0.0)).sqrt()
}

/// How the noise of one axis shows in the residual: rms of `‖Cᵀu‖`, from the offset columns of the normal matrix.
pub fn noise_gain(fitted: &Fitted, residual: Residual) -> f64 {
    if residual != Residual::Magnitude {
        return 1.0;
    }
    let data = Matrix::total(&fitted.blocks, None);
    ((0..3).map(|i| data.entry(i, i)).sum::<f64>() / fitted.rows.max(1.0)).sqrt()
}
