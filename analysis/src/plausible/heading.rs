//! A heading that was computed from the field of this sensor: it repeats the field's errors, so it is not a reference for them.
//!
//! A heading of another sensor differs from it by hard iron, noise and tilt; a computed one only by the rounding of what was written.

use crate::samples::series::median;
use crate::table::Table;
use nalgebra::Vector3;

/// Rows that are looked at.
const MOST: usize = 3000;
/// Fewer rows say nothing.
const LEAST: usize = 20;
/// The heading turns by at least this, degrees (1σ of its direction on the circle).
const TURNED_DEG: f64 = 15.0;
/// What is left of a computed heading, next to its own rounding and that of the field, degrees.
const MOST_LEFT_DEG: f64 = 0.05;

/// Whether these angles, in degrees, are computed from the field, raw, smoothed (`copies`: the columns of a smoothed field), or levelled
/// with the accelerometer.
pub fn is_computed(table: &Table, heading_deg: &[f64], copies: &[&[f64]]) -> bool {
    let rows = table.rows().min(heading_deg.len());
    let chosen: Vec<usize> =
        (0..rows).step_by(rows.div_ceil(MOST).max(1)).filter(|row| heading_deg[*row].is_finite()).collect();
    if chosen.len() < LEAST || spread_deg(chosen.iter().map(|row| heading_deg[*row])) < TURNED_DEG {
        return false;
    }
    let axes: Vec<&[f64]> = table.field_ut.iter().copied().chain(copies.iter().copied()).collect();
    let step =
        |values: &[f64]| least_step(chosen.iter().filter_map(|row| values.get(*row).copied()).collect());
    let own_step = step(heading_deg);
    let judge = |pairs: Vec<[f64; 2]>, step: f64| {
        let mut lengths: Vec<f64> = pairs.iter().map(|[x, y]| x.hypot(*y)).collect();
        let length = median(&mut lengths);
        let of_field = (step / length).to_degrees();
        let allowed = MOST_LEFT_DEG + 2.0 * ((own_step * own_step + of_field * of_field) / 12.0).sqrt();
        [1.0, -1.0].into_iter().any(|sign| {
            let left = pairs
                .iter()
                .zip(&chosen)
                .map(|([x, y], row)| heading_deg[*row] - sign * y.atan2(*x).to_degrees());
            spread_deg(left) <= allowed
        })
    };
    let level = (0..axes.len()).any(|x| {
        (0..x).any(|y| {
            let pair =
                |row: &usize| [axes[x].get(*row), axes[y].get(*row)].map(|v| v.copied().unwrap_or(f64::NAN));
            judge(chosen.iter().map(pair).collect(), step(axes[x]).max(step(axes[y])))
        })
    });
    let Some(accel) = table.accel_mps2.filter(|_| !level) else { return level };
    let step = table.field_ut.iter().map(|axis| step(axis)).fold(0.0, f64::max);
    (0..3).any(|forward| {
        let pair = |row: &usize| {
            let down =
                Vector3::from_fn(|axis, _| accel[axis].get(*row).copied().unwrap_or(f64::NAN)).normalize();
            let field = Vector3::from(table.field(*row));
            let east = down.cross(&field);
            [east.cross(&down)[forward], east[forward]]
        };
        judge(chosen.iter().map(pair).collect(), step)
    })
}

/// Spread of directions around the circle, degrees (1σ); large where one is not a number.
fn spread_deg(angles_deg: impl Iterator<Item = f64>) -> f64 {
    let (mut sin, mut cos, mut count) = (0.0, 0.0, 0.0);
    for angle in angles_deg {
        let (s, c) = angle.to_radians().sin_cos();
        (sin, cos, count) = (sin + s, cos + c, count + 1.0);
    }
    let length = (sin / count).hypot(cos / count);
    if length.is_nan() {
        return f64::INFINITY;
    };
    (2.0 * (1.0 - length).max(0.0)).sqrt().to_degrees()
}

/// The least distance between two different values.
fn least_step(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 1e-9);
    let least = steps.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}
