//! The offset from magnitudes and gyro.
//!
//! Along a chain of looks that the gyro links, `u = W (v − d)` is one vector, with `W` the rotation from the board at a look to the
//! board at the first one. Its scatter is minimised (Gauss and Newton) over `d` and over what is wrong with the gyro, each known beforehand
//! to within its tolerance: gains and axes `φ → (1 + G) φ`, the zero error `β`, which turns `W` by `−∫β dt`, and the delay `τ` of the
//! magnetometer, `v − d = h + τ ω × h`. So their uncertainty is part of that of `d`.

use super::looks::{MIN_LOOKS, Rezero};
use super::magnitudes::{GyroUse, NoOffset, OffsetChange, Sphere, Spread, extremes, memory};
use crate::math::sqrtf;
use crate::vector::{cross, dot, inverse_3x3, minus, plus, product, scaled, times, turned};

/// Gains and axes (1σ): MEMS gyros have ±1 to ±3 % of sensitivity and ±2 % across (ICM-20948, DS-000189: ±1.5 %, ±2 %); the axes of a
/// calibration without an accelerometer are turned by 1 to 3° against those of the gyro.
const GAIN_ERROR: f32 = 0.04;
/// Zero error (1σ), rad/s: ±5 °/s (ICM-20948).
const ZERO_ERROR_RADPS: f32 = 0.09;
/// Delay of the magnetometer (1σ), s: a sample at 50 Hz.
const DELAY_S: f32 = 0.02;
/// The components of a look count as one measurement: what the matrix or another place does to a look is in all three. Counted as
/// three, they make the errors of real recordings too small (`host-tests/tests/suite/gyro_offset.rs`).
const COMPONENTS: f32 = 3.0;
/// Beyond so many standard errors something else is wrong.
const MAX_ERRORS: f32 = 4.0;
/// The scatter over the residual of the magnitudes, at most.
const MAX_RATIO: f32 = 3.0;
/// Share of the field that is no sign of anything, however small the residual is.
const LEAST_SHARE: f32 = 0.004;
/// A chain is at most so long, s: the zero error of the gyro has not turned it far by then.
const MAX_CHAIN_S: f32 = 15.0;
/// Steps of the least squares.
const STEPS: usize = 4;

/// Errors of the gyro: G column by column (9), β (3), and τ.
const GYRO: usize = 13;
/// Unknowns: those, and then the offset.
const UNKNOWNS: usize = GYRO + 3;
/// And the residual.
const COLUMNS: usize = UNKNOWNS + 1;
/// Standard errors beforehand of those of the gyro.
const PRIOR: [f32; GYRO] = {
    let mut prior = [GAIN_ERROR; GYRO];
    (prior[9], prior[10], prior[11]) = (ZERO_ERROR_RADPS, ZERO_ERROR_RADPS, ZERO_ERROR_RADPS);
    prior[12] = DELAY_S;
    prior
};

type Row = [f32; COLUMNS];

/// The scatter of `u` and its derivatives.
struct Scatter {
    /// Upper triangle of the squares and products of the columns.
    squares: [Row; COLUMNS],
    /// Of `u` from one look to the next.
    steps: f32,
    links: f32,
}

/// One chain's means so far.
struct Chain {
    looks: f32,
    took_s: f32,
    means: [Row; 3],
    last: [f32; 3],
    /// From the board now to the board at the first look, rows first.
    to_first: [[f32; 3]; 3],
    /// What the errors of the gyro turn it by, column by column.
    turns: [[f32; 3]; GYRO - 1],
}

impl Chain {
    const fn new() -> Self {
        Self {
            looks: 0.0,
            took_s: 0.0,
            means: [[0.0; COLUMNS]; 3],
            last: [0.0; 3],
            to_first: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            turns: [[0.0; 3]; GYRO - 1],
        }
    }

    /// Turns on by what the gyro said, with its errors taken off.
    fn turn(&mut self, said_rad: [f32; 3], took_s: f32, errors: &[f32; UNKNOWNS]) {
        self.took_s += took_s;
        let [x, y, z] = said_rad;
        let shares = [x, y, z, -took_s];
        let mut half = scaled(said_rad, 0.5);
        for (column, share) in errors.chunks_exact(3).zip(shares) {
            half.iter_mut().zip(column).for_each(|(sum, error)| *sum += 0.5 * share * error);
        }
        // The columns of the rotation back by this.
        let [p, q, r] =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis: [f32; 3]| turned(axis, half));
        let back = [[p[0], q[0], r[0]], [p[1], q[1], r[1]], [p[2], q[2], r[2]]];
        let middle = product(&self.to_first, &back);
        for (columns, share) in self.turns.chunks_exact_mut(3).zip(shares) {
            for (axis, column) in columns.iter_mut().enumerate() {
                for (sum, row) in column.iter_mut().zip(&middle) {
                    *sum += share * row.get(axis).copied().unwrap_or(0.0);
                }
            }
        }
        self.to_first = product(&middle, &back);
    }

    /// Adds a look at the end of the chain.
    fn add(&mut self, look: [f32; 3], rate: [f32; 3], errors: &[f32; UNKNOWNS], scatter: &mut Scatter) {
        let [.., delay_s, x, y, z] = *errors;
        let field = minus(look, [x, y, z]);
        let late = cross(rate, field);
        let u = times(&self.to_first, minus(field, scaled(late, delay_s)));
        let mut rows = [[0.0; COLUMNS]; 3];
        let mut column = |place: usize, values: [f32; 3]| {
            for (row, value) in rows.iter_mut().zip(values) {
                if let Some(entry) = row.get_mut(place) {
                    *entry = value;
                }
            }
        };
        for (place, turn) in self.turns.iter().enumerate() {
            column(place, cross(*turn, u));
        }
        column(GYRO - 1, scaled(times(&self.to_first, late), -1.0));
        let [a, b, c] = self.to_first;
        for axis in 0..3 {
            let entry = |row: [f32; 3]| -row.get(axis).copied().unwrap_or(0.0);
            column(GYRO + axis, [entry(a), entry(b), entry(c)]);
        }
        column(UNKNOWNS, u);
        // Squares about the mean as it moves (Welford).
        let weight = self.looks / (self.looks + 1.0);
        self.looks += 1.0;
        for (row, means) in rows.iter_mut().zip(&mut self.means) {
            for (value, mean) in row.iter_mut().zip(means) {
                *value -= *mean;
                *mean += *value / self.looks;
            }
            for (place, (sums, one)) in scatter.squares.iter_mut().zip(*row).enumerate() {
                let one = weight * one;
                for (sum, other) in sums.iter_mut().zip(&*row).skip(place) {
                    *sum += one * other;
                }
            }
        }
        if self.looks > 1.0 {
            let step = minus(u, self.last);
            scatter.steps += dot(step, step);
            scatter.links += 1.0;
        }
        self.last = u;
    }
}

impl Rezero {
    /// The scatter with these errors.
    #[inline(never)]
    fn scatter(&self, errors: &[f32; UNKNOWNS]) -> Scatter {
        let mut scatter = Scatter { squares: [[0.0; COLUMNS]; COLUMNS], steps: 0.0, links: 0.0 };
        let mut chain = Chain::new();
        let mut next = self.linked().map(|(_, link)| link.turn()).skip(1);
        for (look, link) in self.linked() {
            let (before, after) = (link.turn(), next.next().flatten());
            match before {
                Some((said_rad, took_s)) if chain.took_s < MAX_CHAIN_S => {
                    chain.turn(said_rad, took_s, errors)
                }
                _ => chain = Chain::new(),
            }
            let (mut turn, mut time) = ([0.0; 3], 0.0);
            for (said_rad, took_s) in before.into_iter().chain(after) {
                (turn, time) = (plus(turn, said_rad), time + took_s);
            }
            let rate = if time > 0.0 { scaled(turn, 1.0 / time) } else { turn };
            chain.add(look, rate, errors, &mut scatter);
        }
        scatter
    }

    /// The offset from magnitudes and gyro; without a gyro, or where it disagrees, what magnitudes `alone` say.
    #[inline(never)]
    pub(super) fn by_gyro(
        &self,
        spread: &Spread,
        matrix_error_ut: f32,
        alone: Option<OffsetChange>,
    ) -> Result<OffsetChange, NoOffset> {
        let links = self.linked().skip(1).filter(|(_, link)| link.turn().is_some()).count();
        let otherwise = |gyro| match alone {
            Some(change) => Ok(OffsetChange { gyro, ..change }),
            None => Err(NoOffset::Planar(gyro)),
        };
        if links < MIN_LOOKS {
            return otherwise(GyroUse::None);
        }
        let mut errors = [0.0; UNKNOWNS];
        if let Some(change) = alone.filter(|alone| alone.error_ut < alone.field_ut)
            && let [.., x, y, z] = &mut errors
        {
            [*x, *y, *z] = change.change_ut;
        }
        let mut found = None;
        for _ in 0..STEPS {
            found = self.step(spread, matrix_error_ut, &mut errors);
        }
        let Some((error_ut, least_error_ut, scatter_ut)) = found else {
            return otherwise(GyroUse::Disagrees);
        };
        let [.., x, y, z] = errors;
        let change_ut = [x, y, z];
        let Sphere { radius, rms_ut, .. } = self.sphere(change_ut);
        let least_ut = LEAST_SHARE * radius;
        let expected_ut = sqrtf(rms_ut * rms_ut + matrix_error_ut * matrix_error_ut + least_ut * least_ut);
        let unlikely: f32 =
            errors.iter().zip(PRIOR).map(|(error, prior)| error * error / (prior * prior)).sum();
        // How far from what the magnitudes say, in squares of its standard error.
        let decided = alone.filter(|alone| alone.error_ut < alone.field_ut);
        let apart = decided.map_or(0.0, |alone| {
            let off = minus(change_ut, alone.change_ut);
            let own = spread.without(alone.rms_ut * alone.rms_ut);
            let (least, _) = extremes(&own);
            dot(off, times(&own, off)) / (alone.error_ut * alone.error_ut * least)
        });
        let limit = MAX_ERRORS * MAX_ERRORS;
        if !(scatter_ut < MAX_RATIO * expected_ut && unlikely < limit && apart < limit) {
            return otherwise(GyroUse::Disagrees);
        }
        let (field_ut, looks) = (radius, self.count());
        Ok(OffsetChange { change_ut, error_ut, least_error_ut, rms_ut, field_ut, looks, gyro: GyroUse::Used })
    }

    /// One step of the least squares; the errors of the offset in the worst and the best direction, and the rms of the scatter, µT.
    #[inline(never)]
    fn step(
        &self,
        spread: &Spread,
        matrix_error_ut: f32,
        errors: &mut [f32; UNKNOWNS],
    ) -> Option<(f32, f32, f32)> {
        let [.., x, y, z] = *errors;
        let offset_ut = [x, y, z];
        let sphere = self.sphere(offset_ut);
        let Scatter { mut squares, steps, links } = self.scatter(errors);
        let sum = squares.last()?.last().copied()?;
        let variance = sum / (3.0 * links - UNKNOWNS as f32);
        // Independent residuals step by twice their variance.
        let correlation = 1.0 - 0.5 * steps / sum.max(f32::MIN_POSITIVE);
        let alike = variance * memory(correlation) + spread.n * matrix_error_ut * matrix_error_ut;
        let own_variance = COMPONENTS * alike;
        for (place, (row, (error, prior))) in squares.iter_mut().zip(errors.iter().zip(PRIOR)).enumerate() {
            let weight = own_variance / (prior * prior);
            if let Some(diagonal) = row.get_mut(place) {
                *diagonal += weight;
            }
            if let Some(right) = row.last_mut() {
                *right += weight * error;
            }
        }
        // The magnitudes, and that a change is hardly larger than the field.
        let by_magnitude = own_variance
            / (sphere.radius * sphere.radius * sphere.variance_of_mean(spread.n, matrix_error_ut));
        // A first offset that is wrong makes more of the noise than there is.
        let own = spread.without(sphere.variance.min(extremes(&spread.square).0));
        let from_mean = minus(times(&own, minus(offset_ut, spread.mean)), spread.right);
        let whole = own_variance / (sphere.radius * sphere.radius);
        for axis in 0..3 {
            let row = squares.get_mut(GYRO + axis)?;
            for other in axis..3 {
                *row.get_mut(GYRO + other)? += by_magnitude * own.get(axis)?.get(other)?;
            }
            *row.get_mut(GYRO + axis)? += whole;
            *row.last_mut()? += by_magnitude * from_mean.get(axis)? + whole * offset_ut.get(axis)?;
        }
        let info = eliminate(&mut squares)?;
        let (least, most) = extremes(&info);
        let inverse = inverse_3x3(&info).filter(|_| least > 0.0)?;
        let mut right = [0.0; 3];
        right.iter_mut().zip(squares.get(GYRO..)?).for_each(|(right, row)| {
            *right = row.last().copied().unwrap_or(0.0);
        });
        let change = times(&inverse, right);
        // Backwards for the others.
        let mut steps = [0.0; UNKNOWNS];
        let [.., dx, dy, dz] = &mut steps;
        [*dx, *dy, *dz] = change;
        for place in (0..GYRO).rev() {
            let row = squares.get(place)?;
            let known: f32 = row.iter().zip(&steps).skip(place + 1).map(|(entry, step)| entry * step).sum();
            *steps.get_mut(place)? = (row.last()? - known) / row.get(place)?;
        }
        errors.iter_mut().zip(steps).for_each(|(error, step)| *error -= step);
        let error = |info: f32| sqrtf(own_variance / info);
        Some((error(least), error(most), sqrtf(sum / (3.0 * links))))
    }
}

/// Eliminates the errors of the gyro from the upper triangle; what is left for the offset.
fn eliminate(squares: &mut [Row; COLUMNS]) -> Option<[[f32; 3]; 3]> {
    for place in 0..GYRO {
        let (upper, lower) = squares.split_at_mut_checked(place + 1)?;
        let pivot = upper.last()?;
        let diagonal = *pivot.get(place)?;
        for (row, at) in lower.iter_mut().zip(place + 1..UNKNOWNS) {
            let factor = pivot.get(at)? / diagonal;
            row.iter_mut().zip(pivot).skip(at).for_each(|(own, other)| *own -= factor * other);
        }
    }
    let mut info = [[0.0; 3]; 3];
    for row in 0..3 {
        for column in 0..3 {
            let (one, other) = (row.min(column), row.max(column));
            *info.get_mut(row)?.get_mut(column)? = *squares.get(GYRO + one)?.get(GYRO + other)?;
        }
    }
    Some(info)
}
