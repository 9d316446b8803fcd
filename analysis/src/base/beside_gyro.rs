//! What the gyro says of the field's direction over seconds: whether it is the same field everywhere the board was.
//!
//! With `Q` the turn of a window as the gyro sums it up, a constant vector has `Q v₁ − v₀ = 0`. What a gyro gets wrong by itself is
//! regressed out over all windows: its bias (3), its gains and axes (9), and that the vector is late (1), each by its first order,
//! `∂(Q v₁) = −[Q v₁]ₓ ∫Q δω dt`. The magnitude sees an error along the field only; this sees both directions across it, and where
//! a magnet stands in the room the one may be small while the other is large.

use crate::base::by_gyro;
use crate::base::windows::{Stop, windows};
use crate::bounds::{ACROSS, FEWEST_SAMPLES, GYRO_RAD};
use crate::samples::samples::Samples;
use nalgebra::{DVector, SMatrix, SVector, Vector3};
use serde::{Deserialize, Serialize};

/// Length of a window, s: long enough to carry the board to another place, short beside the wandering of a gyro's bias.
const WINDOW_S: f64 = 2.0;
/// What is regressed out: bias, gains and axes, delay.
const COLUMNS: usize = 13;
/// So many of the windows are asked; the others may hold what passed by ...
const MOST: f64 = 0.7;
/// ... and are left out of what is regressed from so many times theirs.
const BEYOND: f64 = 3.0;

/// What is left beside the gyro, rms of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BesideGyro {
    /// Of the corrected field, as a share of its magnitude.
    pub field: f64,
    /// Windows of two seconds.
    pub windows: usize,
}

/// What a window leaves, and how that follows what is regressed out.
struct Left {
    left: Vector3<f64>,
    follows: SMatrix<f64, 3, COLUMNS>,
}

impl Left {
    /// Of the field and the turn of the board at the window's two ends.
    fn of(window: &Stop, before: [Vector3<f64>; 2], after: [Vector3<f64>; 2]) -> Left {
        let ([v0, rate0], [v1, rate1]) = (before, after);
        let there = window.turn * v1;
        let mut follows = SMatrix::<f64, 3, COLUMNS>::zeros();
        follows.fixed_columns_mut::<12>(0).copy_from(&-(there.cross_matrix() * window.follows));
        follows.set_column(12, &(rate0.cross(&v0) - window.turn * rate1.cross(&v1)));
        Left { left: there - v0, follows }
    }

    fn beside(&self, found: &SVector<f64, COLUMNS>) -> f64 {
        (self.left - self.follows * found).norm()
    }
}

/// What is regressed out, by least squares over these windows.
fn regressed<'l>(list: impl Iterator<Item = &'l Left>) -> Option<SVector<f64, COLUMNS>> {
    let mut normal = SMatrix::<f64, COLUMNS, COLUMNS>::zeros();
    let mut right = SVector::<f64, COLUMNS>::zeros();
    for one in list {
        normal += one.follows.transpose() * one.follows;
        right += one.follows.transpose() * one.left;
    }
    // A board that is not turned about an axis leaves that axis's gains open: they are then no part of what is left either.
    let ridge = 1e-9 * normal.trace() / COLUMNS as f64;
    (0..COLUMNS).for_each(|i| normal[(i, i)] += ridge);
    Some(normal.cholesky()?.solve(&right))
}

/// Rms of one axis across the field, of one end of a window, as most windows have it: a magnet that passes by is none of the place's.
fn of_most(list: &[Left]) -> Option<f64> {
    if list.len() < FEWEST_SAMPLES {
        return None;
    }
    // A length across two axes stays below this many times the rms of one in `MOST` of all windows (Rayleigh).
    let of_rms = (-2.0 * (1.0 - MOST).ln()).sqrt();
    let quantile = |found: &SVector<f64, COLUMNS>| {
        let mut lengths: Vec<f64> = list.iter().map(|one| one.beside(found)).collect();
        lengths.sort_by(f64::total_cmp);
        lengths[(MOST * (lengths.len() - 1) as f64) as usize]
    };
    let found = regressed(list.iter())?;
    let limit = BEYOND * quantile(&found);
    let found = regressed(list.iter().filter(|one| one.beside(&found) < limit))?;
    let freedom = 1.0 - COLUMNS as f64 / (2 * list.len()) as f64;
    Some(quantile(&found) / of_rms / (2.0 * freedom).sqrt()).filter(|left| left.is_finite())
}

/// Holds the corrected field (µT, one vector a sample) against the gyro. `None` where the log has no gyro that turns as the field does.
pub fn beside_gyro(samples: &Samples, corrected_ut: &[[f64; 3]], field_ut: f64) -> Option<BesideGyro> {
    let time = samples.time.as_ref().filter(|time| time.len() == corrected_ut.len() && field_ut > 0.0)?;
    let field: DVector<Vector3<f64>> =
        DVector::from_iterator(time.len(), corrected_ut.iter().map(|v| Vector3::from(*v) / field_ut));
    let unit = |at: usize| field[at].normalize();
    let frame = by_gyro::rotation(samples, &unit)?;
    // `frame` takes the field's axes to the gyro's.
    let rate: Vec<Option<Vector3<f64>>> = (samples.readings.iter())
        .map(|reading| reading.turn_radps.map(|rate| frame.transpose() * Vector3::from(rate)))
        .collect();
    let mut list = Vec::new();
    for window in windows(time, &rate, WINDOW_S, 0) {
        let [start, end] = window.as_slice() else { continue };
        let (first, last) = (start.sample, end.sample);
        let (Some(before), Some(after)) = (rate[first], rate[last]) else { continue };
        list.push(Left::of(end, [field[first], before], [field[last], after]));
    }
    Some(BesideGyro { field: of_most(&list)?, windows: list.len() })
}

impl BesideGyro {
    /// Whether the field is another one from place to place; `along` is the rms of the corrected magnitude, over the field.
    pub fn varies(&self, along: f64) -> bool {
        self.field > (ACROSS * along).hypot(GYRO_RAD)
    }
}
