//! Whether what is left is the field itself, another one from place to place.
//!
//! A disturbed offset shows in the magnitude by its part along the field, which changes its sign as the board turns; an error of the
//! sensor comes again with the attitude. A field that is stronger here than there does neither: whatever side is up, all readings
//! of a place are too long by the same. So one number that changes along the way is held against an offset that does so, with
//! as many parameters, and against the attitude alone.

use nalgebra::{DMatrix, DVector};

/// At most so many samples are looked at.
const MOST_SAMPLES: usize = 4000;
/// Fewer say nothing.
const FEWEST: usize = 200;
/// Knots of the number that changes stand so far apart, rad of turning ...
const KNOT_RAD: f64 = 3.0;
/// ... but are at most so many. Those of the offset, which has three components, are three times as far apart.
const MOST_KNOTS: usize = 400;
/// Shorter turns tell nothing apart, knots.
const FEWEST_KNOTS: usize = 6;
/// The field changes where one number takes this share of the variance ...
const SHARE: f64 = 0.7;
/// ... leaves at most this share of what an offset leaves ...
const AGAINST_OFFSET: f64 = 0.75;
/// ... and the attitude takes no more than this: in a short log chance takes some, and an error of the attitude nearly all.
const ATTITUDE: f64 = 0.4;
/// Highest power of a direction in the error that comes again with the attitude.
const POWER: usize = 4;
/// So many of those powers differ on the sphere: (4 + 1)².
const ATTITUDE_PARAMETERS: usize = (POWER + 1) * (POWER + 1);
/// What keeps a normal matrix regular where a knot has few samples, of its mean diagonal.
const RIDGE: f64 = 1e-9;

/// The share of the residual's variance that a field makes which changes along the way; `None` where something else may be the
/// cause. `directions` are unit vectors of the corrected field.
pub fn field_share(residuals: &[f64], directions: &[[f64; 3]]) -> Option<f64> {
    if residuals.len() != directions.len() || residuals.len() < FEWEST {
        return None;
    }
    let stride = residuals.len().div_ceil(MOST_SAMPLES);
    let picked: Vec<usize> = (0..residuals.len()).step_by(stride).collect();
    let mean = picked.iter().map(|&i| residuals[i]).sum::<f64>() / picked.len() as f64;
    let left: Vec<f64> = picked.iter().map(|&i| residuals[i] - mean).collect();
    let u: Vec<[f64; 3]> = picked.iter().map(|&i| directions[i]).collect();
    let mut way = vec![0.0; u.len()];
    for i in 1..u.len() {
        let cosine: f64 = u[i].iter().zip(u[i - 1]).map(|(a, b)| a * b).sum();
        way[i] = way[i - 1] + cosine.clamp(-1.0, 1.0).acos();
    }
    let turned = *way.last()?;
    let knots = ((turned / KNOT_RAD).ceil() as usize).min(MOST_KNOTS);
    if knots < FEWEST_KNOTS || !turned.is_finite() {
        return None;
    }
    let apart = turned / knots as f64;
    // The knots on both sides and their weights.
    let between = |way: f64, apart: f64, count: usize| {
        let place = way / apart;
        let at = (place as usize).min(count - 1);
        let second = (place - at as f64).clamp(0.0, 1.0);
        [(at, 1.0 - second), (at + 1, second)]
    };
    let field = taken(&left, knots + 1, knots + 1, |sample, row| {
        row.extend(between(way[sample], apart, knots));
    })?;
    let coarse = knots.div_ceil(3);
    let offset = taken(&left, 3 * (coarse + 1), 3 * (coarse + 1), |sample, row| {
        for (knot, weight) in between(way[sample], turned / coarse as f64, coarse) {
            row.extend((0..3).map(|axis| (3 * knot + axis, weight * u[sample][axis])));
        }
    })?;
    let powers: Vec<[usize; 3]> = (0..=POWER)
        .flat_map(|a| (0..=POWER - a).flat_map(move |b| (0..=POWER - a - b).map(move |c| [a, b, c])))
        .collect();
    let attitude = taken(&left, powers.len(), ATTITUDE_PARAMETERS, |sample, row| {
        let one = |[a, b, c]: [usize; 3]| {
            let [x, y, z] = u[sample];
            x.powi(a as i32) * y.powi(b as i32) * z.powi(c as i32)
        };
        row.extend(powers.iter().enumerate().map(|(slot, power)| (slot, one(*power))));
    })?;
    let is_field = field > SHARE && 1.0 - field < AGAINST_OFFSET * (1.0 - offset) && attitude < ATTITUDE;
    is_field.then_some(field)
}

/// The share of the variance that a linear model takes, its parameters counted. `row` gives the places and values of a sample's
/// columns.
fn taken(
    left: &[f64],
    columns: usize,
    parameters: usize,
    row: impl Fn(usize, &mut Vec<(usize, f64)>),
) -> Option<f64> {
    let mut normal = DMatrix::<f64>::zeros(columns, columns);
    let mut right = DVector::<f64>::zeros(columns);
    let mut own = Vec::new();
    for (sample, value) in left.iter().enumerate() {
        own.clear();
        row(sample, &mut own);
        for &(i, a) in &own {
            right[i] += a * value;
            for &(j, b) in &own {
                normal[(i, j)] += a * b;
            }
        }
    }
    let ridge = RIDGE * normal.trace() / columns as f64;
    for i in 0..columns {
        normal[(i, i)] += ridge;
    }
    let solution = normal.cholesky()?.solve(&right);
    let squares: f64 = left.iter().map(|value| value * value).sum();
    let freedom = left.len().checked_sub(parameters).filter(|freedom| *freedom > 0)? as f64;
    let remains = (squares - right.dot(&solution)).max(0.0) / freedom;
    let variance = squares / left.len() as f64;
    (variance > 0.0).then(|| 1.0 - remains / variance)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A board that tumbles, and what `error` leaves of the magnitude.
    fn share(error: impl Fn(f64, [f64; 3]) -> f64) -> Option<f64> {
        let directions: Vec<[f64; 3]> = (0..3000)
            .map(|i| {
                let t = f64::from(i) * 0.02;
                let (height, angle) = ((0.83 * t).sin() * 0.98, 1.7 * t + (0.31 * t).sin());
                let level = (1.0 - height * height).sqrt();
                [level * angle.cos(), level * angle.sin(), height]
            })
            .collect();
        let residuals: Vec<f64> = directions
            .iter()
            .enumerate()
            .map(|(i, u)| {
                let t = i as f64 * 0.02;
                error(t, *u) + 0.2 * (12.9898 * i as f64).sin()
            })
            .collect();
        field_share(&residuals, &directions)
    }

    #[test]
    fn a_stronger_field_in_a_corner_is_told_from_a_moving_offset_and_from_the_attitude() {
        let strays = |t: f64| (0.35 * t).sin() + 0.6 * (0.62 * t + 1.0).sin();
        let found = share(|t, _| 2.0 * strays(t)).expect("the field changes");
        assert!(found > 0.9, "{found}");
        assert_eq!(
            share(|t, u| 2.0 * strays(t) * u[0] + strays(t + 7.0) * u[2]),
            None,
            "an offset that moves"
        );
        assert_eq!(share(|_, u| 2.0 * u[0] * u[1] * u[2] + u[0].powi(3)), None, "an error of the attitude");
        assert_eq!(share(|_, _| 0.0), None, "noise");
    }
}
