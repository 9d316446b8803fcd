//! From a scatter to a report: the method, the order that the data carry, and how sure it is.

use super::constant;
use super::options::{FIELD_RANGE_UT, FitOptions, MIN_SAMPLES, MIN_THICKNESS, Method};
use super::precision::Spread;
use super::report::{FitReport, StdErrors};
use super::root::Root;
use crate::calibration::Calibration;
use crate::quadric::{Ellipsoid, Lower, NoiseTerms, Order, condition_number, mean_square};
use crate::refusal::FitError;
use crate::scatter::Scatter;
use crate::vector::upper_triangular;
use crate::{dense, math};

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
type Solve = fn(&mut Root, &Scatter, f32, Order) -> bool;

fn solve_adjusted(root: &mut Root, scatter: &Scatter, upper: f32, model: Order) -> bool {
    root.adjusted(scatter, upper, model)
}

fn solve_trace(root: &mut Root, scatter: &Scatter, _: f32, model: Order) -> bool {
    root.trace(scatter, model)
}

/// What every method asks of data and options first. Returns an upper bound of the noise variance, in the scatter's
/// units: the least eigenvalue of the samples' covariance.
#[inline(never)]
pub(super) fn check(scatter: &Scatter, options: &FitOptions) -> Result<f32, FitError> {
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
    if !solve(&mut root, scatter, upper, Order::Ellipsoid) {
        return Err(FitError::NotAnEllipsoid);
    }
    let of_model = |root: &Root, full: &Lower, model| {
        let ellipsoid = Ellipsoid::from_coefficients(&root.beta).ok_or(FitError::NotAnEllipsoid)?;
        report(scatter, options, model, &ellipsoid, root, full)
    };
    let mut chosen = of_model(&root, &root.factor, Order::Ellipsoid);
    if !options.lower_orders || chosen.as_ref().is_ok_and(|r| r.predicted_error_ut <= r.limit_ut()) {
        return chosen;
    }
    // The data do not determine nine parameters well: the model with the best evidence among those that solve. What the data
    // say about all nine is in the full model's factor.
    let full = root.factor;
    let samples = samples(scatter);
    let n = options.effective_samples.map_or(samples, |n| n as f32);
    let (mut noise, mut parameters) = (root.variance(Order::Ellipsoid, samples), 9.0);
    for model in [Order::AxisAligned, Order::Sphere] {
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

/// The number of samples; no accumulator holds more than 32 bits say.
fn samples(scatter: &Scatter) -> f32 {
    u32::try_from(scatter.samples).unwrap_or(u32::MAX) as f32
}

#[inline(never)]
fn fit_constant(scatter: &Scatter, options: &FitOptions) -> Result<FitReport, FitError> {
    check(scatter, options)?;
    let about_zero = scatter.about_zero()?;
    // How near the ellipsoid comes to the sensor's zero is asked of the reading that has no trouble there. Its normal
    // matrix, centred and scaled, also gives the standard errors.
    let mut root = Root::new();
    if !root.trace(scatter, Order::Ellipsoid) {
        return Err(FitError::NotAnEllipsoid);
    }
    if let Some(around) = Ellipsoid::from_coefficients(&root.beta) {
        let distance = constant::distance_from_origin(&convert(&around, scatter, &about_zero));
        if distance < constant::NEAREST_ORIGIN {
            return Err(FitError::ThroughOrigin { distance });
        }
    }
    let (ellipsoid, condition_number) = constant::solve(&about_zero).ok_or(FitError::NotAnEllipsoid)?;
    let ellipsoid = convert(&ellipsoid, &about_zero, scatter);
    root.beta = ellipsoid.quadric();
    root.mean_square = (mean_square(&scatter.moments, &root.beta) as f32).max(0.0);
    root.noise = NoiseTerms::of(scatter, &root.beta);
    let mut report = report(scatter, options, Order::Ellipsoid, &ellipsoid, &root, &root.factor)?;
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
    model: Order,
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
    if model != Order::Ellipsoid {
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
    let [x, y, z, of_matrix @ ..] = sigma.map(f64::from);
    let std_errors = StdErrors { offset_ut: [x, y, z], matrix: upper_triangular(of_matrix, 0.0) };
    let matrix = upper_triangular(ellipsoid.factor.map(|entry| entry * unit), 0.0);
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
        condition_number: condition_number(&root.factor, model),
        termination: root.termination,
    })
}
