//! The base model a study begins with.

use crate::samples::samples::Samples;
use ironout::calibration::Calibration;
use ironout::fit::{FitOptions, FitReport, fit};
use ironout::scatter::ScatterBuilder;
use ironout::study::Model;

/// The identity rotation.
pub const NO_ROTATION: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Least over greatest standard deviation of the cloud of samples: near zero for a turn in one plane.
pub fn thickness(samples: &Samples) -> f64 {
    let mean = samples.mean_vector();
    let mut spread = nalgebra::Matrix3::<f64>::zeros();
    for reading in &samples.readings {
        let off = nalgebra::Vector3::from_fn(|axis, _| reading.measured_ut[axis] - mean[axis]);
        spread += off * off.transpose();
    }
    let eigenvalues = spread.symmetric_eigenvalues();
    (eigenvalues.min().max(0.0) / eigenvalues.max().max(1e-300)).sqrt()
}

/// Readings as they would be in the mean field, near enough to start from: where the field changes along the way, its magnitude at each
/// reading is known.
fn readings_ut(samples: &Samples) -> impl Iterator<Item = [f64; 3]> {
    let share = |place: usize| samples.places.get(place).map_or(1.0, |place| place.share);
    let each = samples.readings.iter().enumerate();
    each.map(move |(place, reading)| reading.measured_ut.map(|axis| axis / share(place)))
}

/// The adjusted quadric fit, if the log carries one by itself.
pub fn quadric(samples: &Samples, field_ut: Option<f64>) -> Option<FitReport> {
    let mut builder = ScatterBuilder::new(samples.mean_vector());
    for reading_ut in readings_ut(samples) {
        builder.push(reading_ut);
    }
    let options = FitOptions { field_ut, lower_orders: false, ..FitOptions::default() };
    fit(&builder.finish(0.0).ok()?, &options).ok()
}

/// The sphere that fits best, by linear least squares: centre and radius.
pub fn sphere(samples: &Samples) -> Option<([f64; 3], f64)> {
    let mean = samples.mean_vector();
    let mut normal = nalgebra::Matrix4::<f64>::zeros();
    let mut right = nalgebra::Vector4::<f64>::zeros();
    let mut spread = 0.0;
    for reading_ut in readings_ut(samples) {
        let [x, y, z] = [0, 1, 2].map(|axis| reading_ut[axis] - mean[axis]);
        let row = nalgebra::Vector4::new(2.0 * x, 2.0 * y, 2.0 * z, 1.0);
        normal += row * row.transpose();
        right += row * (x * x + y * y + z * z);
        spread += x * x + y * y + z * z;
    }
    // A little of the offset at the mean: flat data leave the sphere's centre open across the plane.
    for i in 0..3 {
        normal[(i, i)] += 1e-6 * spread;
    }
    let solution = normal.cholesky()?.solve(&right);
    let centre = [solution[0], solution[1], solution[2]];
    let radius2 = solution[3] + centre.iter().map(|value| value * value).sum::<f64>();
    (radius2 > 0.0).then(|| ([0, 1, 2].map(|axis| mean[axis] + centre[axis]), radius2.sqrt()))
}

/// The model to start from, and the field it is scaled to.
pub fn start(samples: &Samples, field_ut: Option<f64>) -> Option<(Model<f64>, Option<FitReport>)> {
    if let Some(report) = quadric(samples, field_ut) {
        let Calibration { offset_ut, matrix, field_ut } = report.calibration;
        return Some((Model::new(offset_ut, matrix, field_ut, NO_ROTATION, 0.0)?, Some(report)));
    }
    let (centre, radius) = sphere(samples)?;
    let field = field_ut.unwrap_or(radius);
    let matrix = NO_ROTATION.map(|row| row.map(|value| value * field / radius));
    Some((Model::new(centre, matrix, field, NO_ROTATION, 0.0)?, None))
}
