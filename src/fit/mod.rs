//! The fits: one file per method, one report, one error type.
//!
//! | method | file | source |
//! |---|---|---|
//! | constant | `constant.rs` | Dong, Chou, Fang 2014, eqs. (9)–(15), errata corrected |
//! | trace | `adjusted.rs`, its first step | the same least squares, normalised by the trace: no singular position |
//! | adjusted | `adjusted.rs` | Markovsky, Kukush, Van Huffel 2004: no bias from noise, estimates the noise |
//!
//! All start from a [`Scatter`]; none sees a sample.

mod adjusted;
mod bias;
mod constant;
pub(crate) mod dense;
mod error;
pub(crate) mod gram;
mod model;
mod noise;
pub mod precision;

pub use error::{FitError, axis_letter};
pub use model::Model;

use crate::calibration::Calibration;
use crate::math;
use crate::quadric::Ellipsoid;
use crate::scatter::Scatter;
use adjusted::Root;
use gram::Lower;
use precision::{Spread, TRIANGLE};

/// Fewest samples in motion that a calibration is fitted to.
pub const MIN_SAMPLES: u64 = 20;
/// Thinner than this (least over greatest standard deviation of the cloud of samples), the attitude is planar.
pub const MIN_THICKNESS: f32 = 0.1;
/// Predicted 1σ error of the corrected vector, over the field, above which lower orders are tried and no calibration
/// is accepted.
pub const MAX_PREDICTED_ERROR: f64 = 0.01;

/// A field outside of this is a slip of the unit, µT.
pub const FIELD_RANGE_UT: core::ops::RangeInclusive<f32> = 1e-3..=1e6;

/// How the quadric is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// Adjusted least squares: the default.
    #[default]
    Adjusted,
    /// Least squares, trace normalisation.
    Trace,
    /// The paper's least squares, constant normalisation.
    Constant,
}

impl Method {
    /// The word of the command line and the console.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Adjusted => "adjusted",
            Self::Trace => "trace",
            Self::Constant => "constant",
        }
    }

    /// The method of a word; `None` for any other.
    pub fn parse(word: &str) -> Option<Self> {
        [Self::Adjusted, Self::Trace, Self::Constant].into_iter().find(|m| m.name() == word)
    }
}

/// What to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// The method.
    pub method: Method,
    /// The true magnitude of the field, µT; `None` keeps the mean magnitude of the measurements about the offset.
    pub field_ut: Option<f64>,
    /// The number of independent samples, where noise is correlated, from 1 to all of them; `None` takes every sample as
    /// independent.
    pub effective_samples: Option<f64>,
    /// Whether lower orders may be chosen when the data do not carry nine parameters.
    pub lower_orders: bool,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { method: Method::Adjusted, field_ut: None, effective_samples: None, lower_orders: true }
    }
}

/// Why a fit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Termination {
    /// One linear solve, nothing to iterate.
    Direct,
    /// The root of the adjusted least squares was found.
    Converged {
        /// Factorisations it took.
        steps: u8,
    },
    /// The data have no noise above rounding.
    NoiseFree,
    /// The step limit came first; the estimate is the best so far.
    StepLimit,
}

/// Standard errors of a calibration, one σ, from noise only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StdErrors {
    /// Of the offset, µT.
    pub offset_ut: [f64; 3],
    /// Of the matrix; zero below the diagonal.
    pub matrix: [[f64; 3]; 3],
}

/// A calibration and what is known about it.
#[derive(Clone, Debug, PartialEq)]
pub struct FitReport {
    /// The calibration: upper triangular matrix, positive diagonal.
    pub calibration: Calibration<f64>,
    /// The errors of `(b, C)` and how they hang together: a square root of their covariance, µT and 1.
    pub spread: Spread,
    /// The standard errors.
    pub std_errors: StdErrors,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_ut: f64,
    /// What that noise makes of the corrected magnitude, rms, µT: the floor of `rms_ut`.
    pub residual_floor_ut: f64,
    /// Rms residual of the corrected magnitude, µT.
    pub rms_ut: f64,
    /// Predicted 1σ error of the corrected vector in the worst direction of the sphere, µT. From noise alone; where noise
    /// also biases the method, see [`Self::add_noise_bias`].
    pub predicted_error_ut: f64,
    /// Longest over shortest semi-axis of the ellipsoid.
    pub axis_ratio: f64,
    /// The magnitude the measurements have themselves, rms distance from the offset, µT.
    pub measured_field_ut: f64,
    /// Samples used.
    pub samples: u64,
    /// Of those, how many count as independent: what the standard errors rest on.
    pub effective_samples: f64,
    /// The method.
    pub method: Method,
    /// Which parameters the data carried.
    pub model: Model,
    /// Condition number of the normal matrix, estimated from its Cholesky factor.
    pub condition_number: f64,
    /// Why it ended.
    pub termination: Termination,
}

/// Fits a calibration to a scatter.
///
/// # Errors
/// A [`FitError`]: too few samples, a stuck or copied axis, planar attitude, no ellipsoid, an implausible one, or for
/// [`Method::Constant`] an ellipsoid through the sensor's zero.
///
/// ```
/// use ironout::{fit::{fit, FitOptions}, moments::Moments, scatter::Scatter};
/// let mut moments = Moments::new();
/// for i in 0..200 {
///     // Directions all over the sphere, 500 counts, about an offset of (300, -200, 100).
///     let z = -1.0 + (i as f64 + 0.5) / 100.0;
///     let (r, angle) = ((1.0 - z * z).sqrt(), i as f64 * 2.4);
///     let field = [r * angle.cos(), r * angle.sin(), z];
///     moments.push([300, -200, 100].map({ let mut a = 0; move |b: i16| { a += 1; b + (500.0 * field[a - 1]).round() as i16 } }));
/// }
/// let report = fit(&Scatter::from_moments(&moments, [0.1; 3])?, &FitOptions::default())?;
/// assert!((report.calibration.offset_ut[0] - 30.0).abs() < 0.02);
/// assert!((report.calibration.field_ut - 50.0).abs() < 0.02);
/// # Ok::<(), ironout::fit::FitError>(())
/// ```
#[inline]
pub fn fit(scatter: &Scatter, options: &FitOptions) -> Result<FitReport, FitError> {
    // Short, and inlined: where the method is known at compile time, the others are not linked.
    match options.method {
        Method::Adjusted => fit_quadric(scatter, options, solve_adjusted),
        Method::Trace => fit_quadric(scatter, options, solve_trace),
        Method::Constant => fit_constant(scatter, options),
    }
}

/// Solves into a [`Root`]; the number is the least eigenvalue of the samples' covariance. `false` where the normal matrix is
/// singular.
type Solve = fn(&mut Root, &Scatter, f32, Model) -> bool;

fn solve_adjusted(root: &mut Root, scatter: &Scatter, upper: f32, model: Model) -> bool {
    root.adjusted(scatter, upper, model)
}

fn solve_trace(root: &mut Root, scatter: &Scatter, _: f32, model: Model) -> bool {
    root.trace(scatter, model)
}

/// What every method asks of data and options first. Returns an upper bound of the noise variance, in the scatter's
/// units: the least eigenvalue of the samples' covariance.
#[inline(never)]
fn check(scatter: &Scatter, options: &FitOptions) -> Result<f32, FitError> {
    // Negated, so that a NaN is refused too.
    let field = options.field_ut.unwrap_or(1.0) as f32;
    let effective = options.effective_samples.unwrap_or(1.0) as f32;
    if !(FIELD_RANGE_UT.contains(&field) && effective >= 1.0) {
        return Err(FitError::NotFinite);
    }
    if scatter.samples < MIN_SAMPLES {
        return Err(FitError::TooFewSamples { samples: scatter.samples });
    }
    scatter.check_axes()?;
    let [thin, _, wide] = math::eigenvalues_3x3_f32(&scatter.covariance.map(|v| v as f32));
    let thickness = math::sqrtf((thin / wide).max(0.0));
    if !(thickness >= MIN_THICKNESS) {
        return Err(FitError::Planar { thickness: thickness.into() });
    }
    // It is known to single precision of the greatest.
    Ok(thin + 1e-5 * wide)
}

#[inline(never)]
fn fit_quadric(scatter: &Scatter, options: &FitOptions, solve: Solve) -> Result<FitReport, FitError> {
    let upper = check(scatter, options)?;
    let mut root = Root::new();
    if !solve(&mut root, scatter, upper, Model::Ellipsoid) {
        return Err(FitError::NotAnEllipsoid);
    }
    let of_model = |root: &Root, full: &Lower, model| {
        let ellipsoid = of_coefficients(&root.beta).ok_or(FitError::NotAnEllipsoid)?;
        report(scatter, options, model, &ellipsoid, root, full)
    };
    let mut chosen = of_model(&root, &root.factor, Model::Ellipsoid);
    if !options.lower_orders || chosen.as_ref().is_ok_and(|r| r.predicted_error_ut <= r.limit_ut()) {
        return chosen;
    }
    // The data do not carry nine parameters well: the model with the best evidence among those that solve. What the data
    // say about all nine is in the full model's factor.
    let full = root.factor;
    let samples = samples(scatter);
    let n = options.effective_samples.map_or(samples, |n| n as f32);
    let (mut noise, mut parameters) = (root.variance(Model::Ellipsoid, samples), 9.0);
    for model in [Model::AxisAligned, Model::Sphere] {
        if !solve(&mut root, scatter, upper, model) {
            continue;
        }
        // The Bayesian information criterion, n ln σ² + k ln n, must not grow. `ln r ≤ r − 1`, and the two are the same where
        // it matters, near r = 1.
        let (lower_noise, lower_parameters) = (root.variance(model, samples), model.parameters() as f32);
        let evidence = n * (lower_noise / noise - 1.0) < (parameters - lower_parameters) * dense::ln_f32(n);
        if evidence && let Ok(lower) = of_model(&root, &full, model) {
            (noise, parameters) = (lower_noise, lower_parameters);
            chosen = Ok(lower);
        }
    }
    chosen
}

impl FitReport {
    fn limit_ut(&self) -> f64 {
        MAX_PREDICTED_ERROR * self.calibration.field_ut
    }
}

/// The number of samples; no accumulator holds more than 32 bits say.
fn samples(scatter: &Scatter) -> f32 {
    u32::try_from(scatter.samples).unwrap_or(u32::MAX) as f32
}

/// The ellipsoid of coefficients over [`gram::QUADRIC`].
fn of_coefficients(beta: &[f64; 10]) -> Option<Ellipsoid> {
    let [xx, yy, zz, xy, xz, yz, x, y, z, k] = *beta;
    Ellipsoid::from_quadric(&[xx, 0.5 * xy, 0.5 * xz, yy, 0.5 * yz, zz], [x, y, z], k)
}

/// Coefficients of `‖C(x−b)‖² − 1` over [`gram::QUADRIC`].
fn coefficients(ellipsoid: &Ellipsoid) -> [f64; 10] {
    let [xx, xy, xz, yy, yz, zz] = ellipsoid.q();
    let [x, y, z] = ellipsoid.centre;
    let qb = [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z];
    let k = qb[0] * x + qb[1] * y + qb[2] * z - 1.0;
    [xx, yy, zz, 2.0 * xy, 2.0 * xz, 2.0 * yz, -2.0 * qb[0], -2.0 * qb[1], -2.0 * qb[2], k]
}

#[inline(never)]
fn fit_constant(scatter: &Scatter, options: &FitOptions) -> Result<FitReport, FitError> {
    check(scatter, options)?;
    let about_zero = scatter.about_zero()?;
    // How near the ellipsoid comes to the sensor's zero is asked of the reading that has no trouble there. Its normal
    // matrix, centred and scaled, also gives the standard errors.
    let mut root = Root::new();
    if !root.trace(scatter, Model::Ellipsoid) {
        return Err(FitError::NotAnEllipsoid);
    }
    if let Some(around) = of_coefficients(&root.beta) {
        let distance = constant::distance_from_origin(&convert(&around, scatter, &about_zero));
        if distance < constant::NEAREST_ORIGIN {
            return Err(FitError::ThroughOrigin { distance });
        }
    }
    let (ellipsoid, condition_number) = constant::solve(&about_zero).ok_or(FitError::NotAnEllipsoid)?;
    let ellipsoid = convert(&ellipsoid, &about_zero, scatter);
    root.beta = coefficients(&ellipsoid);
    root.mean_square = (gram::mean_square(&scatter.moments, &root.beta) as f32).max(0.0);
    root.noise = noise::NoiseTerms::of(scatter, &root.beta);
    let mut report = report(scatter, options, Model::Ellipsoid, &ellipsoid, &root, &root.factor)?;
    report.condition_number = condition_number;
    Ok(report)
}

/// The same ellipsoid in the units of another scatter.
fn convert(ellipsoid: &Ellipsoid, from: &Scatter, to: &Scatter) -> Ellipsoid {
    let unit = from.scale_ut / to.scale_ut;
    Ellipsoid {
        centre: core::array::from_fn(|a| {
            ellipsoid.centre[a] * unit + (from.centre_ut[a] - to.centre_ut[a]) / to.scale_ut
        }),
        factor: ellipsoid.factor.map(|v| v / unit),
        s: 1.0,
    }
}

/// `full` is the factor of all nine columns, whatever the model.
#[inline(never)]
fn report(
    scatter: &Scatter,
    options: &FitOptions,
    model: Model,
    ellipsoid: &Ellipsoid,
    root: &Root,
    full: &Lower,
) -> Result<FitReport, FitError> {
    let n = samples(scatter);
    let scale = scatter.scale_ut;
    let gradient2 = root.noise.gradient2;
    let estimated = root.variance(model, n);
    let quantisation = (scatter.quantisation_ut2 / (scale * scale)) as f32;
    let s = estimated.max(quantisation).max(1e-30);

    // Rms distance from the centre: the magnitude the measurements have themselves.
    let mut offset_ut = [0.0; 3];
    let mut off = [0.0; 3];
    for axis in 0..3 {
        off[axis] = scatter.moments[1 + axis] - ellipsoid.centre[axis];
        offset_ut[axis] = scatter.centre_ut[axis] + ellipsoid.centre[axis] * scale;
    }
    let [xx, _, _, yy, _, zz] = scatter.covariance;
    let own =
        dense::dot(&[xx, yy, zz, f64::from(estimated)], &[1.0, 1.0, 1.0, -3.0]) + dense::dot(&off, &off);
    let measured_field_ut = dense::root(if own > 0.0 { own } else { 0.0 }) * scale;
    let field_ut = options.field_ut.unwrap_or(measured_field_ut);
    let offset = dense::root(dense::dot(&offset_ut, &offset_ut));
    let axis_ratio = ellipsoid.check_plausible((offset / measured_field_ut) as f32)?;

    let unit = field_ut / scale;
    let effective = options.effective_samples.map_or(n, |effective| (effective as f32).min(n));
    let variance = root.noise.variance(s) / effective;
    let mut spread = Spread::ZERO;
    spread.set_from_factor(full, ellipsoid, variance);
    if model != Model::Ellipsoid {
        spread.add_prior(ellipsoid);
    }
    let field = field_ut as f32;
    let predicted = spread.worst_direction_error(ellipsoid);
    // All that is uncertain is in it, also what is not a number.
    if !(predicted < 1e3) {
        return Err(FitError::NotAnEllipsoid);
    }
    let predicted_error_ut = f64::from(predicted * field);
    spread.scale(scale as f32, unit as f32);
    let sigma = spread.std_errors();
    let mut std_errors = StdErrors { offset_ut: [0.0; 3], matrix: [[0.0; 3]; 3] };
    let mut matrix = [[0.0; 3]; 3];
    let (of_offset, of_matrix) = sigma.split_at(3);
    for (to, from) in std_errors.offset_ut.iter_mut().zip(of_offset) {
        *to = (*from).into();
    }
    for ((j, k), (entry, sigma)) in TRIANGLE.into_iter().zip(ellipsoid.factor.iter().zip(of_matrix)) {
        std_errors.matrix[j][k] = (*sigma).into();
        matrix[j][k] = entry * unit;
    }
    // The quadric is s(‖C(x−b)‖² − 1), twice the relative residual times that s.
    let per_quadric = 0.5 * field / (ellipsoid.s as f32).abs();
    Ok(FitReport {
        calibration: Calibration { offset_ut, matrix, field_ut },
        spread,
        std_errors,
        noise_ut: f64::from(math::sqrtf(s)) * scale,
        residual_floor_ut: f64::from(math::sqrtf(s * gradient2) * per_quadric),
        rms_ut: f64::from(math::sqrtf(root.mean_square) * per_quadric),
        predicted_error_ut,
        axis_ratio: axis_ratio.into(),
        measured_field_ut,
        samples: scatter.samples,
        effective_samples: effective.into(),
        method: options.method,
        model,
        condition_number: gram::condition_number(&root.factor, model),
        termination: root.termination,
    })
}
