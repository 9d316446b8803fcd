//! The fits: one file per method, one report, one error type.
//!
//! | method | file | source |
//! |---|---|---|
//! | constant | `constant.rs` | Dong, Chou, Fang 2014, eqs. (9)–(15), errata corrected |
//! | trace | `trace.rs` | the same least squares, normalised by the trace: no singular position |
//! | adjusted | `adjusted.rs` | Markovsky, Kukush, Van Huffel 2004: no bias from noise, estimates the noise |
//!
//! All start from a [`Scatter`]; none sees a sample.

mod adjusted;
mod constant;
mod error;
pub mod precision;
mod psi;
mod trace;

pub use error::{FitError, axis_letter};
pub use trace::Model;

use crate::calibration::Calibration;
use crate::math;
use crate::quadric::Ellipsoid;
use crate::scatter::Scatter;
use nalgebra::{Matrix3, Vector3};
use precision::{Matrix9, Noise, TRIANGLE};

/// Fewest samples in motion that a calibration is fitted to.
pub const MIN_SAMPLES: u64 = 20;
/// Thinner than this (least over greatest standard deviation of the cloud of samples), the attitude is planar.
pub const MIN_THICKNESS: f64 = 0.1;
/// Predicted 1σ error of the corrected vector, over the field, above which lower orders are tried and no calibration
/// is accepted.
pub const MAX_PREDICTED_ERROR: f64 = 0.01;

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
    /// The number of independent samples, where noise is correlated; `None` takes every sample as independent.
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
    /// Covariance of `(b, C)` in the order of [`precision::TRIANGLE`], µT and 1.
    pub covariance: Matrix9,
    /// Square roots of its diagonal.
    pub std_errors: StdErrors,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_ut: f64,
    /// What that noise makes of the corrected magnitude, rms, µT: the floor of `rms_ut`.
    pub residual_floor_ut: f64,
    /// Rms residual of the corrected magnitude, µT.
    pub rms_ut: f64,
    /// Predicted 1σ error of the corrected vector in the worst direction of the sphere, µT.
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
pub fn fit(scatter: &Scatter, options: &FitOptions) -> Result<FitReport, FitError> {
    let sound = |v: f64| v.is_finite() && v > 0.0;
    if !options.field_ut.is_none_or(sound) || !options.effective_samples.is_none_or(sound) {
        return Err(FitError::NotFinite);
    }
    if scatter.samples < MIN_SAMPLES {
        return Err(FitError::TooFewSamples { samples: scatter.samples });
    }
    scatter.check_axes()?;
    let [thin, _, wide] = math::symmetric_eigenvalues_3x3(&scatter.covariance());
    let thickness = math::sqrt((thin / wide).max(0.0));
    if !(thickness >= MIN_THICKNESS) {
        return Err(FitError::Planar { thickness });
    }
    if options.method == Method::Constant {
        return fit_constant(scatter, options);
    }
    let p = psi::hermite(scatter);
    let trace_basis = [0, 1, 2].map(|i| psi::to_trace_basis(&p[i]));
    let solve = |model| solve_model(scatter, options, &p, &trace_basis, thin, model);
    let full = solve(Model::Ellipsoid);
    if !options.lower_orders || full.as_ref().is_ok_and(|r| r.predicted_error_ut <= r.limit_ut()) {
        return full;
    }
    // The data do not carry nine parameters well: the model with the best evidence (least BIC) among those that solve.
    let mut chosen = full;
    for lower in [solve(Model::AxisAligned), solve(Model::Sphere)].into_iter().flatten() {
        let better = match &chosen {
            Ok(best) => lower.bic() < best.bic(),
            Err(_) => true,
        };
        if better {
            chosen = Ok(lower);
        }
    }
    chosen
}

impl FitReport {
    fn limit_ut(&self) -> f64 {
        MAX_PREDICTED_ERROR * self.calibration.field_ut
    }

    /// Bayesian information criterion, up to a constant of the data.
    fn bic(&self) -> f64 {
        let n = self.effective_samples;
        // The noise in the sensor's own units: a lower order must not look better by a smaller matrix.
        n * math::ln(self.noise_ut * self.noise_ut) + self.model.parameters() as f64 * math::ln(n)
    }
}

fn solve_model(
    scatter: &Scatter,
    options: &FitOptions,
    p: &[psi::Matrix10; 3],
    trace_basis: &[psi::Matrix10; 3],
    thin: f64,
    model: Model,
) -> Result<FitReport, FitError> {
    let root = if options.method == Method::Trace {
        let (x, condition_number) =
            trace::minimise(&trace_basis[0], model).ok_or(FitError::NotAnEllipsoid)?;
        adjusted::Root { x, s: f64::NAN, condition_number, termination: Termination::Direct }
    } else {
        adjusted::root(trace_basis, thin, model)?
    };
    let ellipsoid = trace::ellipsoid(&root.x)?;
    let s = (!root.s.is_nan()).then_some(root.s);
    report(
        scatter,
        options,
        p,
        &Fitted {
            ellipsoid,
            s,
            model,
            condition_number: root.condition_number,
            termination: root.termination,
        },
    )
}

fn fit_constant(scatter: &Scatter, options: &FitOptions) -> Result<FitReport, FitError> {
    let about_zero = scatter.about_zero()?;
    // How near the ellipsoid comes to the sensor's zero is asked of the reading that has no trouble there.
    let p = psi::hermite(scatter);
    if let Some((x, _)) = trace::minimise(&psi::to_trace_basis(&p[0]), Model::Ellipsoid)
        && let Ok(around) = trace::ellipsoid(&x)
    {
        let distance = constant::distance_from_origin(&convert(&around, scatter, &about_zero));
        if distance < constant::NEAREST_ORIGIN {
            return Err(FitError::ThroughOrigin { distance });
        }
    }
    let (ellipsoid, condition_number) = constant::solve(&about_zero)?;
    let ellipsoid = convert(&ellipsoid, &about_zero, scatter);
    let fitted = Fitted {
        ellipsoid,
        s: None,
        model: Model::Ellipsoid,
        condition_number,
        termination: Termination::Direct,
    };
    report(scatter, options, &p, &fitted)
}

/// The same ellipsoid in the units of another scatter.
fn convert(ellipsoid: &Ellipsoid, from: &Scatter, to: &Scatter) -> Ellipsoid {
    let unit = from.scale_ut / to.scale_ut;
    let moved = Vector3::from_fn(|a, _| (from.centre_ut[a] - to.centre_ut[a]) / to.scale_ut);
    Ellipsoid { centre: ellipsoid.centre * unit + moved, factor: ellipsoid.factor / unit }
}

struct Fitted {
    ellipsoid: Ellipsoid,
    /// Noise variance, where the method estimates it.
    s: Option<f64>,
    model: Model,
    condition_number: f64,
    termination: Termination,
}

fn report(
    scatter: &Scatter,
    options: &FitOptions,
    p: &[psi::Matrix10; 3],
    fitted: &Fitted,
) -> Result<FitReport, FitError> {
    let Fitted { ellipsoid, model, .. } = fitted;
    let n = scatter.samples as f64;
    let scale = scatter.scale_ut;
    let noise = Noise::of(scatter, ellipsoid);
    // Mean square of ‖C(x−b)‖² − 1 over the samples, exact from the sums.
    let beta = coefficients(ellipsoid);
    let mean_square = psi::quadratic_form(&p[0], &beta).max(0.0);
    let freedom = n / (n - model.parameters() as f64);
    let estimated = fitted.s.unwrap_or(mean_square / (4.0 * noise.m)) * freedom;
    let s = estimated.max(scatter.quantisation_ut2 / (scale * scale)).max(1e-30);

    // Rms distance from the centre: the magnitude the measurements have themselves.
    let covariance = scatter.covariance();
    let mean = Vector3::new(scatter.moment(1, 0, 0), scatter.moment(0, 1, 0), scatter.moment(0, 0, 1));
    let own =
        covariance[0][0] + covariance[1][1] + covariance[2][2] + (mean - ellipsoid.centre).norm_squared()
            - 3.0 * estimated;
    let own = math::sqrt(own.max(0.0));
    let measured_field_ut = own * scale;
    let field_ut = options.field_ut.unwrap_or(measured_field_ut);
    let offset_ut: [f64; 3] = core::array::from_fn(|a| scatter.centre_ut[a] + ellipsoid.centre[a] * scale);
    let offset_fields = math::sqrt(offset_ut.iter().map(|v| v * v).sum()) / measured_field_ut;
    ellipsoid.check_plausible(offset_fields)?;

    let unit = field_ut / scale;
    let matrix = ellipsoid.factor * unit;
    let psi_s = p[0] + p[1] * estimated + p[2] * (estimated * estimated);
    let effective = options.effective_samples.unwrap_or(n);
    let mut information = precision::information(&psi_s, ellipsoid, noise.variance(s), effective);
    if *model != Model::Ellipsoid {
        information += precision::prior(ellipsoid);
    }
    let covariance = precision::invert(&information).ok_or(FitError::NotAnEllipsoid)?;
    let predicted = precision::worst_direction_error(&ellipsoid.factor, &covariance);
    let to_units = |i: usize| if i < 3 { scale } else { unit };
    let covariance = Matrix9::from_fn(|r, c| covariance[(r, c)] * to_units(r) * to_units(c));
    let sigma = |i: usize| math::sqrt(covariance[(i, i)].max(0.0));
    let mut std_errors = StdErrors { offset_ut: [sigma(0), sigma(1), sigma(2)], matrix: [[0.0; 3]; 3] };
    for (i, (j, k)) in TRIANGLE.iter().copied().enumerate() {
        std_errors.matrix[j][k] = sigma(3 + i);
    }
    Ok(FitReport {
        calibration: Calibration { offset_ut, matrix: rows(&matrix), field_ut },
        covariance,
        std_errors,
        noise_ut: math::sqrt(s) * scale,
        residual_floor_ut: math::sqrt(s * noise.m) * field_ut,
        rms_ut: 0.5 * math::sqrt(mean_square) * field_ut,
        predicted_error_ut: predicted * field_ut,
        axis_ratio: ellipsoid.axis_ratio(),
        measured_field_ut,
        samples: scatter.samples,
        effective_samples: effective,
        method: options.method,
        model: *model,
        condition_number: fitted.condition_number,
        termination: fitted.termination,
    })
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    core::array::from_fn(|r| core::array::from_fn(|c| m[(r, c)]))
}

/// Coefficients of `‖C(x−b)‖² − 1` over [`psi::QUADRIC`].
fn coefficients(ellipsoid: &Ellipsoid) -> psi::Vector10 {
    let q = ellipsoid.q();
    let qb = q * ellipsoid.centre;
    psi::Vector10::from_column_slice(&[
        q[(0, 0)],
        q[(1, 1)],
        q[(2, 2)],
        2.0 * q[(0, 1)],
        2.0 * q[(0, 2)],
        2.0 * q[(1, 2)],
        -2.0 * qb[0],
        -2.0 * qb[1],
        -2.0 * qb[2],
        ellipsoid.centre.dot(&qb) - 1.0,
    ])
}
