//! The predicted error of a corrected vector, from the covariance of a fit.

use crate::evidence::bounds::LEAST_SLOPE;
use crate::evidence::design::{BASE, Model, Point, TRIANGLE};
use crate::evidence::fit::Fit;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Directions of the sphere that are looked at.
const DIRECTIONS: usize = 60;

fn directions() -> impl Iterator<Item = Vector3<f64>> {
    // A spiral of equal areas.
    (0..DIRECTIONS).map(|place| {
        let z = 1.0 - (2 * place + 1) as f64 / DIRECTIONS as f64;
        let across = (1.0 - z * z).sqrt();
        let (sine, cosine) = (place as f64 * 2.399_963_229_728_653).sin_cos();
        Vector3::new(across * cosine, across * sine, z)
    })
}

/// 1σ of the corrected vector in the worst direction, µT, its rotation and its scale apart: a log tells those by other means.
pub fn predicted_error_ut(model: &Model, covariance: &DMatrix<f64>) -> Option<f64> {
    let inverse = model.matrix.try_inverse()?;
    let rows = 3 * DIRECTIONS;
    let mut errors = DMatrix::zeros(rows, BASE);
    let mut apart = DMatrix::zeros(rows, 4);
    for (place, unit) in directions().enumerate() {
        let h = unit * model.field;
        let centred = inverse * h;
        for axis in 0..3 {
            let by_offset = -model.matrix.column(axis);
            errors.view_mut((3 * place, axis), (3, 1)).copy_from(&by_offset);
            let turned = Vector3::ith(axis, 1.0).cross(&h);
            apart.view_mut((3 * place, axis), (3, 1)).copy_from(&turned);
        }
        for (index, (i, j)) in TRIANGLE.into_iter().enumerate() {
            errors[(3 * place + i, 3 + index)] = centred[j];
        }
        apart.view_mut((3 * place, 3), (3, 1)).copy_from(&h);
    }
    let normal = (apart.transpose() * &apart).cholesky()?;
    let errors = &errors - &apart * normal.solve(&(apart.transpose() * &errors));
    let base = covariance.view((0, 0), (BASE, BASE));
    let worst = (0..DIRECTIONS).map(|place| {
        let own = errors.rows(3 * place, 3);
        let spread: DMatrix<f64> = own * base * own.transpose();
        Matrix3::from_fn(|i, j| spread[(i, j)]).trace()
    });
    Some(worst.fold(0.0, f64::max).max(0.0).sqrt())
}

/// Corrected vectors of a fit: every term taken out, noise left in.
pub fn corrected(fit: &Fit) -> Vec<[f64; 3]> {
    let model = &fit.model;
    let one = |point: &Point| -> [f64; 3] {
        let h = model.matrix * (point.closest - model.offset);
        // The closest point has the residual taken out; along the field it goes back in, not amplified where readings fold.
        (h + point.unit * point.residual / point.stretch.abs().max(LEAST_SLOPE) * point.stretch.signum())
            .into()
    };
    fit.points.iter().map(one).collect()
}
