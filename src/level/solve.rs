//! The ellipse of level readings, by least squares from the exact sums.
//!
//! With the reading `u` that the prior corrects, the normal `n` of the plane and `w = M (u·e₁, u·e₂) − c`, the magnitude is one number:
//! `‖w‖² + s² + 2Vs = const`, with `s` the deviation of `n·u` from its mean and `V` the vertical field. Changes of `M`, `c` and `V` are
//! linear in it; each round applies them, so that the last one finds none.

use super::ellipse::{COLUMNS, Ellipse, VERTICAL};
use super::forces::{Down, Forces};
use super::in_use::{InUse, in_use};
use super::plane::{Plane, nearest_axis};
use super::prior::LevelPrior;
use super::refusal::{Cause, DEG, MAX_HEADING_ERROR_DEG, MAX_RESIDUAL, MAX_TILT_DEG, NotLevel};
use crate::calibration::Calibration;
use crate::dense::root;
use crate::fit::{FitError, MIN_SAMPLES};
use crate::record::{HoldsFor, TILTS_DEG};
use crate::scatter::Scatter;
use crate::vector::{cross, dot, inverse_3x3, norm, product, scaled, times};
use crate::whiteness::{Residual, Whiteness};

/// How the sensor is mounted against the vertical where no accelerometer shows it, 1σ, rad.
const MOUNTING_RAD: f64 = 0.06;
/// Gravity is within so many standard errors of the normal of the readings' plane.
const MAX_LEAN_SIGMAS: f64 = 3.0;
/// Largest tilt that is stated, degrees.
const MAX_HOLDS_DEG: u8 = 45;
/// Sines of the tilts that the error of a heading is kept for.
const SINES: [f64; TILTS_DEG.len()] = [0.0, 0.173_648, 0.342_020, core::f64::consts::FRAC_1_SQRT_2];
/// Without a calibration: gains, 1σ ...
const GAIN_ERROR: f64 = 0.1;
/// ... and the least error of the vertical offset, µT.
const LEAST_OFFSET_ERROR_UT: f64 = 10.0;
/// Rounds of the solve; each removes all but some percent of what is left.
const ROUNDS: usize = 8;
/// Information on the vertical field that no sample outweighs.
const HELD_FAST: f64 = 1e12;
/// The readings' variance along the vertical over their noise: below it the tilts do not show the vertical field.
const MIN_TILT_SNR: f64 = 9.0;
/// The noise's variance is known within this share, 1σ.
const NOISE_ERROR: f64 = 0.3;
/// Sine and cosine of one degree.
const ONE_DEGREE: (f64, f64) = (0.017_452_406, 0.999_847_695);

/// A calibration for level headings.
#[derive(Clone, Copy, Debug)]
pub struct LevelFit {
    /// The calibration, in the vehicle's level axes as the accelerometer shows them.
    pub calibration: Calibration<f64>,
    /// The tilts that it holds for.
    pub holds_for: HoldsFor,
    /// Error (1σ) of the corrected vector in the worst direction, over the field: that of the vertical.
    pub error: f64,
    /// Rms residual of the magnitude, µT.
    pub rms_ut: f64,
    /// Horizontal field, µT.
    pub horizontal_ut: f64,
    /// Samples.
    pub samples: u64,
    /// The calibration in use, if there is one.
    pub in_use: Option<InUse>,
}

/// Fits a calibration for level headings to the sums of a vehicle that turned level. `forces` show the direction down; without
/// an accelerometer it is the nearest of the board's axes.
///
/// # Errors
/// [`NotLevel`], with what to do.
#[inline(never)]
pub fn fit_level(
    scatter: &Scatter,
    whiteness: &Whiteness,
    ut_per_count: [f64; 3],
    prior: &LevelPrior,
    forces: &Forces,
) -> Result<LevelFit, NotLevel> {
    if scatter.samples < MIN_SAMPLES {
        return Err(NotLevel::Fit(FitError::TooFewSamples { samples: scatter.samples }));
    }
    let too_little = NotLevel::Uncertain(180.0, Cause::Circle);
    let down = forces.down();
    if forces.are_heard() && down.is_none() {
        return Err(too_little);
    }
    let plane = Plane::of(scatter, &prior.calibration, down).ok_or(too_little)?;
    let [_, _, normal] = plane.axes;
    let [a, b, _] = plane.readings;
    let mut ellipse = Ellipse {
        w: [a, b],
        matrix: [[1.0, 0.0], [0.0, 1.0]],
        centre: [0.0; 2],
        vertical_ut: plane.vertical_ut,
        horizontal_ut2: 0.0,
        variance: 0.0,
        inverse: [[0.0; COLUMNS]; COLUMNS],
    };
    let n = scatter.samples as f64;
    let (mut effective, mut vertical_error_ut, mut noise_ut2) = (n, 0.0, 0.0);
    let mut shows_vertical = false;
    let gain_error = prior.error.unwrap_or(GAIN_ERROR);
    for round in 0..ROUNDS {
        let held = if shows_vertical {
            ellipse.variance / (effective * vertical_error_ut * vertical_error_ut)
        } else {
            HELD_FAST
        };
        let noise = noise_ut2 / (scatter.scale_ut * scatter.scale_ut);
        ellipse.vertical_ut = plane.vertical_ut;
        ellipse.improved(&plane, &scatter.moments, noise as f32, held).ok_or(too_little)?;
        let [c1, c2] = ellipse.centre;
        // The vertical offset has changed as the horizontal one has, as far as anybody knows.
        let changed_ut2 = c1 * c1 + c2 * c2;
        let field_ut = root(ellipse.horizontal_ut2 + ellipse.vertical_ut * ellipse.vertical_ut);
        let least_ut = prior.error.map_or(LEAST_OFFSET_ERROR_UT, |error| error * field_ut);
        vertical_error_ut = root(changed_ut2 + least_ut * least_ut);
        if !(ellipse.horizontal_ut2 > 0.0) {
            continue;
        }
        // After the first rounds the residual is noise.
        if round >= 3 {
            noise_ut2 = (0.25 * ellipse.variance / (field_ut * field_ut)).min(plane.thickness_ut2);
            shows_vertical = plane.thickness_ut2 > MIN_TILT_SNR * noise_ut2;
        }
        if round == ROUNDS - 2 {
            let calibration = calibrated(&ellipse, &plane, prior, normal).ok_or(too_little)?;
            let rms_ut = 0.5 * root(ellipse.variance) / field_ut;
            let share = whiteness.share_of(
                &Residual {
                    calibration: &calibration,
                    rms_ut,
                    noise_ut: rms_ut,
                    samples: n,
                    parameters: COLUMNS as f64,
                },
                ut_per_count,
                scatter.quantisation_ut2,
            );
            effective = (n * share.unwrap_or(1.0)).max(1.0);
        }
    }
    if !(ellipse.horizontal_ut2 > 0.0) {
        return Err(too_little);
    }
    let horizontal_ut = root(ellipse.horizontal_ut2);
    let tilt_deg = root(plane.thickness_ut2) / horizontal_ut * DEG;
    if !(tilt_deg <= MAX_TILT_DEG) {
        return Err(NotLevel::Tilted(tilt_deg));
    }
    let residual = 0.5 * root(ellipse.variance) / ellipse.horizontal_ut2;
    if !(residual <= MAX_RESIDUAL) {
        return Err(NotLevel::FieldVaries(100.0 * residual));
    }
    // Tilts that go with the heading turn the plane; from one knot to the next they are others.
    let tilts_ut2 = (plane.thickness_ut2 - noise_ut2).max(0.0);
    let tilts_rad2 = 2.0 * tilts_ut2 / (ellipse.horizontal_ut2 * f64::from(forces.count().max(1)));
    let lean = Lean::of(normal, down, tilts_rad2, prior)?;
    let calibration = calibrated(&ellipse, &plane, prior, lean.towards).ok_or(too_little)?;
    let per_variance = ellipse.variance * n / ((n - COLUMNS as f64).max(1.0) * effective);
    let variance =
        |i: usize| ellipse.inverse.get(i).and_then(|row| row.get(i)).unwrap_or(&0.0) * per_variance;
    let circle2 = 0.5 * ((variance(2) + variance(3)) / ellipse.horizontal_ut2 + variance(0) + variance(1));
    let steepness = ellipse.vertical_ut / horizontal_ut;
    let lean2 = 0.5 * steepness * steepness * lean.error_rad * lean.error_rad;
    let level_deg = root(circle2 + lean2) * DEG;
    if !(level_deg <= MAX_HEADING_ERROR_DEG) {
        let as_noise_deg = root(circle2 * effective / n) * DEG;
        let cause = match () {
            () if lean2 > circle2 && lean.is_of_forces => Cause::Down,
            () if as_noise_deg < 0.5 * MAX_HEADING_ERROR_DEG => Cause::Field,
            () => Cause::Circle,
        };
        return Err(NotLevel::Uncertain(level_deg, cause));
    }
    let gain_ut = gain_error * ellipse.vertical_ut;
    let offset_ut2 = if shows_vertical {
        // Noise that is taken for tilt moves the vertical field towards zero.
        let taken = NOISE_ERROR * noise_ut2 / (plane.thickness_ut2 - noise_ut2) * ellipse.vertical_ut;
        variance(VERTICAL) + taken * taken
    } else {
        vertical_error_ut * vertical_error_ut
    };
    let vertical_ut2 = offset_ut2 + gain_ut * gain_ut;
    let vertical2 = vertical_ut2 / ellipse.horizontal_ut2;
    let at = |sine: f64| root(circle2 + lean2 + 0.5 * sine * sine * vertical2) * DEG;
    // Degree by degree: a rotation by one degree at a time costs less than trigonometry.
    let (mut holds_deg, (mut sine, mut cosine)) = (0_u8, ONE_DEGREE);
    while holds_deg < MAX_HOLDS_DEG && at(sine) <= MAX_HEADING_ERROR_DEG {
        holds_deg += 1;
        (sine, cosine) =
            (sine * ONE_DEGREE.1 + cosine * ONE_DEGREE.0, cosine * ONE_DEGREE.1 - sine * ONE_DEGREE.0);
    }
    if holds_deg == 0 {
        return Err(NotLevel::Uncertain(at(ONE_DEGREE.0), Cause::Vertical));
    }
    let holds_for = HoldsFor {
        tilt_deg: f32::from(holds_deg),
        down: lean.down.map(|axis| axis as f32),
        heading_errors_deg: SINES.map(|sine| at(sine) as f32),
    };
    let field_ut = calibration.field_ut;
    let in_use = in_use(&ellipse, &plane, prior, lean.towards, (level_deg, holds_for.tilt_deg));
    Ok(LevelFit {
        calibration,
        holds_for,
        error: root(vertical_ut2) / field_ut,
        rms_ut: 0.5 * root(ellipse.variance) / field_ut,
        horizontal_ut,
        samples: scatter.samples,
        in_use,
    })
}

/// How the plane of the readings leans against gravity.
struct Lean {
    /// What the normal is turned to, by the least turn.
    towards: [f64; 3],
    /// The direction down.
    down: [f64; 3],
    /// What stays uncertain of it, rad.
    error_rad: f64,
    /// Whether most of that comes from the accelerometer.
    is_of_forces: bool,
}

impl Lean {
    fn of(
        normal: [f64; 3],
        down: Option<Down>,
        tilts_rad2: f64,
        prior: &LevelPrior,
    ) -> Result<Self, NotLevel> {
        let (down, of_force, axis_error) = match down {
            Some(Down { direction, error_rad }) => (
                direction.map(f64::from),
                f64::from(error_rad) * f64::from(error_rad),
                prior.axis_error_rad(),
            ),
            // The vehicle's own tilts have a mean.
            None => (nearest_axis(normal), tilts_rad2, MOUNTING_RAD),
        };
        let (of_plane, of_axes) = (of_force + tilts_rad2, axis_error * axis_error);
        let most_rad = MAX_LEAN_SIGMAS * root(of_plane + of_axes);
        // Its sine is as good: it is refused where it is large.
        let angle = norm(cross(normal, down));
        if !(angle <= most_rad) {
            return Err(NotLevel::Leaning(angle * DEG));
        }
        // The likeliest direction between both.
        let share = of_axes / (of_axes + of_plane);
        let between: [f64; 3] = core::array::from_fn(|i| (1.0 - share) * normal[i] + share * down[i]);
        let towards = scaled(between, 1.0 / norm(between));
        let is_of_forces = of_force > tilts_rad2;
        Ok(Self { towards, down, error_rad: root(share * of_plane), is_of_forces })
    }
}

/// The calibration of an ellipse, turned so that the normal of the plane is `towards`.
#[inline(never)]
fn calibrated(
    ellipse: &Ellipse,
    plane: &Plane,
    prior: &LevelPrior,
    towards: [f64; 3],
) -> Option<Calibration<f64>> {
    let [e1, e2, normal] = plane.axes;
    let [[a, b], [c, d]] = ellipse.matrix;
    // Σ eᵢ Mᵢⱼ eⱼᵀ + n nᵀ
    let columns = [(e1, e1, a), (e1, e2, b), (e2, e1, c), (e2, e2, d), (normal, normal, 1.0)];
    let mut soft = [[0.0; 3]; 3];
    for (left, right, factor) in columns {
        for (row, value) in soft.iter_mut().zip(left) {
            row.iter_mut().zip(right).for_each(|(slot, other)| *slot += factor * value * other);
        }
    }
    // The least rotation from the normal: I + [a] + [a]²/(1 + cos), with [a] of `a = n × t`.
    let (axis, along) = (cross(normal, towards), 1.0 / (1.0 + dot(normal, towards)));
    let rotated = |unit: [f64; 3]| {
        let once = cross(axis, unit);
        let twice = cross(axis, once);
        core::array::from_fn(|i| unit[i] + once[i] + along * twice[i])
    };
    let [x, y, z]: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(rotated);
    let rotation: [[f64; 3]; 3] = core::array::from_fn(|i| [x[i], y[i], z[i]]);
    // The corrected reading is `soft u − k`: the offset moves by what the matrix makes `k` of.
    let [c1, c2] = ellipse.centre;
    let up_ut = plane.vertical_ut - ellipse.vertical_ut;
    let moved: [f64; 3] = core::array::from_fn(|i| c1 * e1[i] + c2 * e2[i] + up_ut * normal[i]);
    let own = product(&soft, &prior.calibration.matrix);
    let offset = times(&inverse_3x3(&own)?, moved);
    let prior_ut = prior.calibration.offset_ut;
    let calibration = Calibration {
        offset_ut: core::array::from_fn(|i| prior_ut[i] + offset[i]),
        matrix: product(&rotation, &own),
        field_ut: root(ellipse.horizontal_ut2 + ellipse.vertical_ut * ellipse.vertical_ut),
    };
    calibration.is_sound().then_some(calibration)
}
