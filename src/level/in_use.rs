//! The calibration in use against the new one, on the same level turns.

use super::ellipse::Ellipse;
use super::plane::Plane;
use super::prior::LevelPrior;
use super::refusal::DEG;
use crate::dense::root;
use crate::record::HoldsFor;
use crate::vector::dot;

/// Two level calibrations agree up to this square of their difference over their variances: 1 % of chi-square with the four degrees
/// of freedom of an offset and a soft iron in the plane, over four.
const AGREES: f64 = 3.32;
/// An error of a level heading that makes no difference, degrees: as where an ordinary calibration is replaced.
const MATTERS_DEG: f64 = 0.15;

/// The calibration in use, on the samples of the level turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InUse {
    /// Error (1σ) of its level headings, from these samples and its own prediction, degrees.
    pub heading_error_deg: f64,
    /// Whether its level headings are as good as the new ones, and it holds for as much tilt.
    pub is_as_good: bool,
}

/// What the level turns say of the calibration in use. `new` is the heading error of the new calibration and the tilt that it
/// holds for, degrees.
#[inline(never)]
pub(super) fn in_use(
    ellipse: &Ellipse,
    plane: &Plane,
    prior: &LevelPrior,
    towards: [f64; 3],
    (new_deg, new_tilt_deg): (f64, f32),
) -> Option<InUse> {
    let horizontal_ut = root(ellipse.horizontal_ut2);
    let predicted_deg = match &prior.holds_for {
        Some(HoldsFor { heading_errors_deg: [level_deg, ..], .. }) => f64::from(*level_deg),
        None => {
            prior.error? * root(ellipse.horizontal_ut2 + plane.vertical_ut * plane.vertical_ut)
                / horizontal_ut
                * DEG
        }
    };
    let ([e1, e2, normal], [c1, c2]) = (plane.axes, ellipse.centre);
    // A vertical that leans moves the horizontal field as an offset does.
    let along = dot(normal, towards);
    let shift: [f64; 3] = core::array::from_fn(|i| {
        c1 * e1[i] + c2 * e2[i] + plane.vertical_ut * (normal[i] - along * towards[i])
    });
    let [[a, b], [c, d]] = ellipse.matrix;
    let (stretch, shear) = (0.5 * (a - d), 0.5 * (b + c));
    // By how much its level headings differ from the new ones, rms without the mean, squared.
    let differ2 =
        0.5 * (dot(shift, shift) / ellipse.horizontal_ut2 + stretch * stretch + shear * shear) * DEG * DEG;
    let (new2, predicted2) = (new_deg * new_deg, predicted_deg * predicted_deg);
    let error2 = if differ2 <= AGREES * (new2 + predicted2) {
        // Its prediction and the samples agree: the likeliest error between both.
        let share = predicted2 / (new2 + predicted2);
        share * (share * differ2 + new2)
    } else {
        // Something has changed since.
        differ2 - new2
    };
    let heading_error_deg = root(error2);
    let holds_as_far = prior.holds_for.is_none_or(|tilts| tilts.tilt_deg >= new_tilt_deg);
    let is_as_good = holds_as_far && heading_error_deg <= new_deg.max(MATTERS_DEG);
    Some(InUse { heading_error_deg, is_as_good })
}
