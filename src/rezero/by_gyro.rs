//! The offset from magnitudes and gyro.
//!
//! Along a chain of looks that the gyro links, `u = W (v − d)` is one vector, with `W` the rotation from the board at a look to the
//! board at the first one. Its scatter is minimised (Gauss and Newton) over `d` and over what is wrong with the gyro, each known beforehand
//! to within its tolerance: gains and axes `φ → (1 + G) φ`, the zero error `β`, which turns `W` by `−∫β dt`, and the delay `τ` of the
//! magnetometer, `v − d = h + τ ω × h`. So their uncertainty is part of that of `d`.

use super::looks::Rezero;
use super::magnitudes::{GyroUse, NoOffset, OffsetChange, Spread, extremes};
use crate::math::{eigenvalues_3x3_f32, sqrtf};
use crate::vector::{cross, dot, minus, plus, scaled, times, turned};

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
/// Links of the chains that are needed at least.
const MIN_LINKS: f32 = 18.0;
/// The scatter over the residual of the magnitudes, at most.
const MAX_RATIO: f32 = 3.0;
/// Share of the field that is no sign of anything, however small the residual is.
const LEAST_SHARE: f32 = 0.004;
/// A chain is at most so long, s: the zero error of the gyro has not turned it far by then.
const MAX_CHAIN_S: f32 = 8.0;
/// Steps of the least squares at most; another one is worth it as long as the scatter falls by so much.
const STEPS: usize = 6;
const WORTH_A_STEP: f32 = 0.99;

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

/// The scatter of `u` and its derivatives.
struct Scatter {
    /// Upper triangle of the squares and products of the columns.
    squares: [[f32; COLUMNS]; COLUMNS],
    links: f32,
}

/// A chain so far.
struct Chain {
    looks: f32,
    took_s: f32,
    /// The columns on average.
    means: [[f32; 3]; COLUMNS],
    /// From the board now to the board at the first look, rows first.
    to_first: [[f32; 3]; 3],
    /// What the errors of the gyro turn it by.
    turns: [[f32; 3]; GYRO - 1],
}

const fn transposed([a, b, c]: [[f32; 3]; 3]) -> [[f32; 3]; 3] {
    [[a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]]
}

impl Chain {
    const fn new() -> Self {
        Self {
            looks: 0.0,
            took_s: 0.0,
            means: [[0.0; 3]; COLUMNS],
            to_first: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            turns: [[0.0; 3]; GYRO - 1],
        }
    }

    /// Begins another chain: the means are those of its first look, and where it begins to turn from does not matter.
    fn begin(&mut self) {
        (self.looks, self.took_s, self.turns) = (0.0, 0.0, [[0.0; 3]; GYRO - 1]);
    }

    /// Turns on by what the gyro said, with its errors taken off.
    fn turn(&mut self, said_rad: [f32; 3], took_s: f32, errors: &[f32; UNKNOWNS]) {
        self.took_s += took_s;
        let [x, y, z] = said_rad;
        let shares = [x, y, z, -took_s];
        let mut half = scaled(said_rad, -0.5);
        for (column, share) in errors.chunks_exact(3).zip(shares) {
            half.iter_mut().zip(column).for_each(|(sum, error)| *sum -= 0.5 * share * error);
        }
        // An error turns the middle of the way, to the second order.
        self.turn_frame(half);
        for (columns, share) in self.turns.chunks_exact_mut(3).zip(shares) {
            for (column, axis) in columns.iter_mut().zip(transposed(self.to_first)) {
                *column = plus(*column, scaled(axis, share));
            }
        }
        self.turn_frame(half);
    }

    #[inline(never)]
    fn turn_frame(&mut self, by: [f32; 3]) {
        for row in &mut self.to_first {
            *row = turned(*row, by);
        }
    }

    /// Adds the look at the end of the chain, where the board turned at this rate.
    fn add(&mut self, look: [f32; 3], rate: [f32; 3], errors: &[f32; UNKNOWNS], scatter: &mut Scatter) {
        let [.., delay_s, x, y, z] = *errors;
        let field = minus(look, [x, y, z]);
        let late = times(&self.to_first, cross(field, rate));
        let u = plus(times(&self.to_first, field), scaled(late, delay_s));
        let mut columns = [[0.0; 3]; COLUMNS];
        columns.iter_mut().zip(&self.turns).for_each(|(column, turn)| *column = cross(*turn, u));
        let [.., by_delay, dx, dy, dz, last] = &mut columns;
        (*by_delay, *last) = (late, u);
        [*dx, *dy, *dz] = transposed(self.to_first.map(|row| scaled(row, -1.0)));
        // Squares about the mean as it moves (Welford).
        let weight = self.looks / (self.looks + 1.0);
        self.looks += 1.0;
        for (column, mean) in columns.iter_mut().zip(&mut self.means) {
            *column = minus(*column, *mean);
            *mean = plus(*mean, scaled(*column, 1.0 / self.looks));
        }
        for (place, (row, one)) in scatter.squares.iter_mut().zip(&columns).enumerate() {
            let one = scaled(*one, weight);
            for (sum, other) in row.iter_mut().zip(&columns).skip(place) {
                *sum += dot(one, *other);
            }
        }
    }
}

impl Rezero {
    /// The scatter with these errors.
    #[inline(never)]
    fn scatter(&self, errors: &[f32; UNKNOWNS]) -> Scatter {
        let mut scatter = Scatter { squares: [[0.0; COLUMNS]; COLUMNS], links: 0.0 };
        let mut chain = Chain::new();
        let mut place = 0;
        while let Some((look, link)) = self.at(place) {
            place += 1;
            let (mut said_rad, mut took_s) = ([0.0; 3], 0.0);
            match link.known() {
                Some(turn) if chain.took_s < MAX_CHAIN_S && chain.looks > 0.0 => {
                    (said_rad, took_s) = turn;
                    chain.turn(said_rad, took_s, errors);
                    scatter.links += 1.0;
                }
                _ => chain.begin(),
            }
            // How the board turns at a look is known from the way to it and the way from it.
            if let Some((after_rad, after_s)) = self.at(place).and_then(|(_, link)| link.known()) {
                (said_rad, took_s) = (plus(said_rad, after_rad), took_s + after_s);
            }
            if took_s > 0.0 {
                chain.add(*look, scaled(said_rad, 1.0 / took_s), errors, &mut scatter);
            }
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
        let otherwise = |gyro| match alone {
            Some(change) => Ok(OffsetChange { gyro, ..change }),
            None => Err(NoOffset::Planar(gyro)),
        };
        let mut errors = [0.0; UNKNOWNS];
        if let (Some(change), [.., x, y, z]) = (alone, &mut errors) {
            [*x, *y, *z] = change.change_ut;
        }
        let (mut error_ut, mut least_error_ut, mut scatter_ut) = (0.0, 0.0, f32::INFINITY);
        for _ in 0..STEPS {
            let last_ut = scatter_ut;
            let Some(found) = self.step(spread, matrix_error_ut, &mut errors) else {
                return otherwise(GyroUse::None);
            };
            (error_ut, least_error_ut, scatter_ut) = found;
            if !(scatter_ut < WORTH_A_STEP * last_ut) {
                break;
            }
        }
        let [.., x, y, z] = errors;
        let change_ut = [x, y, z];
        let sphere = self.sphere(change_ut);
        let (rms_ut, field_ut) = (sphere.rms_ut, sphere.radius);
        let least_ut = LEAST_SHARE * field_ut;
        let expected_ut = sqrtf(rms_ut * rms_ut + matrix_error_ut * matrix_error_ut + least_ut * least_ut);
        let unlikely: f32 =
            errors.iter().zip(PRIOR).map(|(error, prior)| error * error / (prior * prior)).sum();
        // How much worse the magnitudes are than at their own offset, in squares of standard errors.
        let apart = alone.map_or(0.0, |alone| {
            let variance = self.sphere(alone.change_ut).variance_of_mean(spread.n, matrix_error_ut);
            (rms_ut * rms_ut - alone.rms_ut * alone.rms_ut) / variance
        });
        let limit = MAX_ERRORS * MAX_ERRORS;
        if !(scatter_ut < MAX_RATIO * expected_ut && unlikely < limit && apart < limit) {
            return otherwise(GyroUse::Disagrees);
        }
        let (looks, gyro) = (self.count(), GyroUse::Used);
        Ok(OffsetChange { change_ut, error_ut, least_error_ut, rms_ut, field_ut, looks, gyro })
    }

    /// One step of the least squares; the errors of the offset in the worst and the best direction, and the rms of the scatter, µT.
    /// `None` where the gyro says too little.
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
        let Scatter { mut squares, links } = self.scatter(errors);
        if links < MIN_LINKS {
            return None;
        }
        let [.., [.., sum]] = squares;
        let variance = sum / (3.0 * links - UNKNOWNS as f32);
        let alike = variance * sphere.memory + spread.n * matrix_error_ut * matrix_error_ut;
        let own_variance = COMPONENTS * alike;
        // What is known beforehand: of the offset, that its change is hardly larger than the field.
        for place in 0..UNKNOWNS {
            let prior = if place < GYRO { PRIOR[place] } else { sphere.radius };
            let weight = own_variance / (prior * prior);
            squares[place][place] += weight;
            squares[place][UNKNOWNS] += weight * errors[place];
        }
        // The magnitudes. A first offset that is wrong makes more of the noise than there is.
        let own = spread.without(sphere.variance.min(extremes(&spread.square).0));
        let right = minus(times(&own, minus(offset_ut, spread.mean)), spread.right);
        let share = own_variance
            / (sphere.radius * sphere.radius * sphere.variance_of_mean(spread.n, matrix_error_ut));
        for row in 0..3 {
            for column in 0..3 {
                squares[GYRO + row][GYRO + column] += share * own[row][column];
            }
            squares[GYRO + row][UNKNOWNS] += share * right[row];
        }
        // Elimination in the upper triangle; the rest of the last three rows is the information about the offset.
        let (mut least, mut most) = (0.0, 0.0);
        for place in 0..UNKNOWNS {
            if place == GYRO {
                let [.., [.., xx, xy, xz, _], [.., yy, yz, _], [.., zz, _], _] = squares;
                [least, _, most] = eigenvalues_3x3_f32(&[xx, xy, xz, yy, yz, zz]);
            }
            for row in place + 1..UNKNOWNS {
                let factor = squares[place][row] / squares[place][place];
                for column in row..COLUMNS {
                    squares[row][column] -= factor * squares[place][column];
                }
            }
        }
        // Backwards.
        let mut steps = [0.0; UNKNOWNS];
        for place in (0..UNKNOWNS).rev() {
            let mut step = squares[place][UNKNOWNS];
            for known in place + 1..UNKNOWNS {
                step -= squares[place][known] * steps[known];
            }
            steps[place] = step / squares[place][place];
        }
        errors.iter_mut().zip(steps).for_each(|(error, step)| *error -= step);
        Some((sqrtf(own_variance / least), sqrtf(own_variance / most), sqrtf(sum / (3.0 * links))))
    }
}
