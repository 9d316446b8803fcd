//! The rotation to the accelerometer, from constant dip, and how the magnetometer is mounted beside it.

use crate::base::by_gyro;
use crate::base::engine::Design;
use crate::base::order::AxisOrder;
use crate::base::start::NO_ROTATION;
use crate::base::term::{BadShape, COLUMNS, Matrix, Term};
use crate::bounds::{AS_WELL, BETTER_PART, MAX_DIP_SPREAD_DEG, MIN_DIP_DEG, SWAPPED_DEG};
use crate::samples::samples::Samples;
use crate::track::Place;
use ironout::study::{Model, Residual};
use nalgebra::{Matrix3, SMatrix, SVector, SymmetricEigen, Vector3};

/// What the dip says about a model.
#[derive(Debug, Clone)]
pub struct Alignment {
    /// The model with its rotation and dip.
    pub model: Model<f64>,
    /// Spread of the dip with the triangular matrix, degrees.
    pub before_deg: f64,
    /// Spread of the dip after alignment, degrees.
    pub after_deg: f64,
    /// Angle of the rotation beside the symmetric matrix (after any swapped axes were undone), degrees. The triangular
    /// matrix has a rotation of its own, which is a convention and no error of mounting.
    pub angle_deg: f64,
    /// How the axes stand in the log, as a mounting. The dip says the same of its opposite, a mirror image.
    pub order: AxisOrder,
    /// Whether the rotation is that to the gyro: the accelerometer has measured more than gravity.
    pub by_gyro: bool,
}

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| m[(i, j)]))
}

fn angle_deg(rotation: &Matrix3<f64>) -> f64 {
    ((rotation.trace() - 1.0) / 2.0).clamp(-1.0, 1.0).acos().to_degrees()
}

/// Samples whose measured vectors have had the effects taken out.
pub fn without_effects(samples: &Samples, model: &Model<f64>, terms: &[Term]) -> Samples {
    let mut out = samples.clone();
    if terms.is_empty() {
        return out;
    }
    let inverse = matrix(&model.full_matrix()).try_inverse().unwrap_or_else(Matrix3::identity);
    for (index, reading) in out.readings.iter_mut().enumerate() {
        let at_sample: Vec<_> = terms.iter().map(|term| term.at_sample(index)).collect();
        if let Ok(corrected) = model.correct(reading, &at_sample) {
            let raw = inverse * Vector3::from(corrected) + Vector3::from(model.offset_ut);
            reading.measured_ut = raw.into();
        }
    }
    out
}

/// Spread of the dip about its own mean, with a given rotation, degrees; and the sine of the mean dip.
fn spread(samples: &Samples, full: &Matrix3<f64>, offset: &Vector3<f64>) -> Option<(f64, f64)> {
    let mut angles = Vec::with_capacity(samples.len());
    let mut places: Vec<Place> = Vec::with_capacity(samples.places.len());
    for (sample, reading) in samples.readings.iter().enumerate() {
        let Some(down) = reading.down else { continue };
        let h = full * (Vector3::from(reading.measured_ut) - offset);
        angles.push((h.dot(&Vector3::from(down)) / h.norm()).clamp(-1.0, 1.0).asin());
        places.extend(samples.places.get(sample));
    }
    if angles.len() < 20 {
        return None;
    }
    let n = angles.len() as f64;
    let mean = angles.iter().sum::<f64>() / n;
    // As if all were in one place, whose dip is the mean.
    angles.iter_mut().zip(&places).for_each(|(angle, place)| *angle -= place.bend_rad(mean));
    let mean = angles.iter().sum::<f64>() / n;
    let variance = angles.iter().map(|angle| (angle - mean).powi(2)).sum::<f64>() / n;
    Some((variance.sqrt().to_degrees(), mean.sin()))
}

/// The rotation from all samples at once: `downᵀ R u` is constant, linear in the nine entries of `R`.
fn global(samples: &Samples, model: &Model<f64>) -> Option<Matrix3<f64>> {
    let triangle = matrix(&model.matrix);
    let offset = Vector3::from(model.offset_ut);
    let mut normal = SMatrix::<f64, 10, 10>::zeros();
    for reading in &samples.readings {
        let Some(down) = reading.down else { continue };
        let u = (triangle * (Vector3::from(reading.measured_ut) - offset)).normalize();
        let mut row = SVector::<f64, 10>::zeros();
        for i in 0..3 {
            for j in 0..3 {
                row[3 * i + j] = down[i] * u[j];
            }
        }
        row[9] = -1.0;
        normal += row * row.transpose();
    }
    let eigen = SymmetricEigen::try_new(normal, 1e-14, 500)?;
    let least = eigen.eigenvalues.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?.0;
    let vector = eigen.eigenvectors.column(least);
    let raw = Matrix3::from_fn(|i, j| vector[3 * i + j]);
    let raw = if raw.determinant() < 0.0 { -raw } else { raw };
    let svd = raw.try_svd(true, true, 1e-12, 200)?;
    let rotation = svd.u? * svd.v_t?;
    (rotation.determinant() > 0.0 && rotation.iter().all(|value| value.is_finite())).then_some(rotation)
}

/// Gauss–Newton on rotation and dip from a starting rotation: the model and the spread, degrees.
fn refine(
    samples: &Samples,
    model: &Model<f64>,
    rotation: Matrix3<f64>,
) -> Result<Option<(Model<f64>, f64)>, BadShape> {
    let design = Design::new(samples, Residual::Dip);
    let offset = Vector3::from(model.offset_ut);
    let Some((_, sine)) = spread(samples, &(rotation * matrix(&model.matrix)), &offset) else {
        return Ok(None);
    };
    let make = |model: &Model<f64>, sine| {
        Model::new(model.offset_ut, model.matrix, model.field_ut, rows(&rotation), sine)
    };
    let Some(mut model) = make(model, sine) else { return Ok(None) };
    let mut best: Option<(Model<f64>, f64)> = None;
    for _ in 0..25 {
        let total = Matrix::total(&design.blocks(&samples.bounds(2), &model, &[])?, None);
        let squares = total.squares();
        if best.as_ref().is_some_and(|(_, least)| squares >= *least * (1.0 - 1e-10)) {
            break;
        }
        best = Some((model, squares));
        let Some(factor) = total.damped_factor(1e-9) else { break };
        let step: [f64; COLUMNS] = total.step(&factor);
        let Some(next) = model.aligned(&step) else { break };
        model = next;
    }
    Ok(best.and_then(|(model, _)| {
        let full = matrix(&model.full_matrix());
        spread(samples, &full, &offset).map(|(spread, _)| (model, spread))
    }))
}

/// Direction of the field at a sample, in the model's triangular frame.
fn direction(samples: &Samples, model: &Model<f64>, at: usize) -> Vector3<f64> {
    let centred = Vector3::from(samples.readings[at].measured_ut) - Vector3::from(model.offset_ut);
    (matrix(&model.matrix) * centred).normalize()
}

/// Aligns a model. `samples` have no effects left in them ([`without_effects`]).
pub fn align(samples: &Samples, model: &Model<f64>) -> Result<Option<Alignment>, BadShape> {
    let offset = Vector3::from(model.offset_ut);
    let Some((before_deg, _)) = spread(samples, &matrix(&model.matrix), &offset) else { return Ok(None) };
    // A model that was aligned before needs a small correction; a new one is asked from two sides.
    let mut starts = vec![matrix(&model.rotation)];
    if model.rotation == NO_ROTATION {
        starts.extend(global(samples, model));
    }
    let mut best: Option<(Model<f64>, f64)> = None;
    // What is left where the axes stand in order.
    let mut in_order_deg = before_deg;
    for start in starts {
        let Some((model, spread)) = refine(samples, model, start)? else { continue };
        if angle_deg(&matrix(&model.rotation)) <= SWAPPED_DEG {
            in_order_deg = in_order_deg.min(spread);
        }
        if best.as_ref().is_none_or(|(_, least)| spread < least * 0.98) {
            best = Some((model, spread));
        }
    }
    let Some((mut model, mut after_deg)) = best else { return Ok(None) };
    // Named only where it leaves little of the dip's spread: other errors turn an estimate too.
    let by_dip = angle_deg(&matrix(&model.rotation)) > SWAPPED_DEG
        && in_order_deg > MIN_DIP_DEG
        && after_deg < BETTER_PART * in_order_deg
        && after_deg < MAX_DIP_SPREAD_DEG;
    let undecided = angle_deg(&matrix(&model.rotation)) > SWAPPED_DEG && !by_dip;
    let mut by_gyro = false;
    if (after_deg > MAX_DIP_SPREAD_DEG || undecided)
        && let Some(rotation) = by_gyro::rotation(samples, &|at| direction(samples, &model, at))
        && let Some((spread, sine)) = spread(samples, &(rotation * matrix(&model.matrix)), &offset)
        && let Some(turned) = Model::new(model.offset_ut, model.matrix, model.field_ut, rows(&rotation), sine)
    {
        (model, after_deg, by_gyro) = (turned, spread, true);
    }
    let rotation = matrix(&model.rotation);
    // By a gyro, unless gravity says that it is the gyro that stands otherwise.
    let swapped =
        by_dip || by_gyro && angle_deg(&rotation) > SWAPPED_DEG && after_deg < AS_WELL * in_order_deg;
    let (order, angle_deg) =
        if swapped { AxisOrder::nearest(&rotation) } else { (AxisOrder::IN_ORDER, beside_symmetric(&model)) };
    Ok(Some(Alignment { model, before_deg, after_deg, angle_deg, order, by_gyro }))
}

/// Angle of the rotation `U` in `R C = U S` with `S` symmetric, degrees.
fn beside_symmetric(model: &Model<f64>) -> f64 {
    let full = matrix(&model.full_matrix());
    match full.try_svd(true, true, 1e-12, 200).and_then(|svd| Some(svd.u? * svd.v_t?)) {
        Some(rotation) => angle_deg(&rotation),
        None => angle_deg(&matrix(&model.rotation)),
    }
}
