//! Precision of a fitted model, the noise floor, and whether structure remains.

use crate::base::engine::{Design, Fitted};
use crate::base::prior::Prior;
use crate::base::term::{COLUMNS, Matrix, Term};
use crate::bounds::MIN_SHARE;
use crate::noise::own::{Colour, OwnNoise};
use crate::samples::scores::Scores;
use crate::samples::series::{Autocorrelation, rms, second_difference_sigma};
use ironout::calibration::{Calibration, norm};
use ironout::effect::{Quantities, no_shape};
use ironout::study::{Model, PhysicalPrior, Residual};
use ironout::whiteness::independent_share;
use nalgebra::{DMatrix, Matrix3, SMatrix, Vector3};
use serde::Serialize;

/// The error of an effect is averaged over its columns' values at so many samples of the log.
const CONDITIONS: usize = 8;

/// The integrated autocorrelation time is that of so many samples.
const TIME_BY: usize = 1 << 15;

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
    /// The root of twice the log of the odds that it is something else: standard deviations, if it were one number.
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
    let noise = match design.residual {
        Residual::Magnitude => {
            let Model { offset_ut, matrix, field_ut, .. } = *model;
            let calibration = Calibration { offset_ut, matrix, field_ut };
            let readings = samples.readings.iter().map(|reading| reading.measured_ut);
            let directions = gradients(readings, &calibration);
            OwnNoise::of(residuals, &directions, 1, samples.step_s())
        }
        // Of a board at rest there is one axis after the other: here those of each sample stand together.
        Residual::Vector | Residual::Dip => {
            let used = || samples.axes.iter().filter(|used| **used).count().max(1);
            let axes = if design.residual == Residual::Vector { used() } else { 1 };
            let long = residuals.len() / axes;
            let rows =
                (0..long).flat_map(|sample| (0..axes).map(move |axis| residuals[axis * long + sample]));
            let unit = |row: usize| [0, 1, 2].map(|i| f64::from(u8::from(row % axes == i)));
            let directions: Vec<[f64; 3]> = (0..axes * long).map(unit).collect();
            OwnNoise::of(&rows.collect::<Vec<f64>>(), &directions, axes, samples.step_s())
        }
    };
    residue_of(residuals, noise, parameters)
}

/// How each axis of the sensor shows in the corrected magnitude of these readings: `Cᵀu`, along the corrected direction u.
pub fn gradients(
    readings_ut: impl Iterator<Item = [f64; 3]>,
    calibration: &Calibration<f64>,
) -> Vec<[f64; 3]> {
    let gradient = |reading: [f64; 3]| {
        let v = calibration.apply(reading);
        let length = norm(v).max(f64::MIN_POSITIVE);
        [0, 1, 2].map(|j| (0..3).map(|i| calibration.matrix[i][j] * v[i]).sum::<f64>() / length)
    };
    readings_ut.map(gradient).collect()
}

/// The same of a residual whose noise is known.
pub fn residue_of(residuals: &[f64], noise: OwnNoise, parameters: usize) -> NoiseEstimate {
    let sizes = Sizes::of(residuals);
    let freedom = sizes.n.saturating_sub(parameters).max(1) as f64;
    let whole = sizes.rms * (sizes.n as f64 / freedom).sqrt();
    // What is new from sample to sample is noise; of what is faster than that, what no neighbour predicts.
    let smooth = if sizes.quick < whole { sizes.quick } else { whole * noise.fresh.sqrt() };
    let share = 1.0 - (smooth / whole.max(1e-300)).powi(2);
    let structured = !noise.is_noise() && share > MIN_SHARE;
    let floor = if structured { smooth } else { whole };
    NoiseEstimate {
        rms: sizes.rms,
        floor_least: if noise.colour == Colour::White { floor } else { floor.min(sizes.quick) },
        floor,
        structure: if structured { share } else { 0.0 },
        time: Autocorrelation::of(&residuals[..residuals.len().min(TIME_BY)]).time,
        memory: sizes.memory(),
        colour: noise.colour,
        misfit: noise.odds.max(0.0).sqrt(),
        is_noise: noise.is_noise(),
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
