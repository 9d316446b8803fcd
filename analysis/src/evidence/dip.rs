//! The dip: the angle of the corrected vector against gravity is constant, and a late sensor shows in nothing else.
//!
//! The residual is that angle less its mean, times the field, µT. The magnitude's fit is prior knowledge here: its parameters move
//! within their covariance. Rotation, mean dip and the zero error of the accelerometer are free; the noise is one series of its own.

use crate::base::alignment::align;
use crate::base::start::NO_ROTATION;
use crate::evidence::bounds::{MAX_P_HELD_OUT, MIN_ODDS, MIN_SHARE, MOST_SINE};
use crate::evidence::design::{BASE, TRIANGLE};
use crate::evidence::fit::{Fit, Setting};
use crate::evidence::held_out::{changes, p_value};
use crate::evidence::log::Log;
use crate::evidence::noise::{Noise, Track};
use crate::evidence::solve::{Factor, Sums};
use ironout::study::Model as CoreModel;
use nalgebra::{DVector, Matrix3, Vector3};

/// Columns besides those of the magnitude: rotation, mean dip, zero error of the accelerometer.
const OWN: usize = 7;
/// Rounds of fit and noise in turn.
const ROUNDS: usize = 5;
const LAST: usize = ROUNDS - 1;

/// What the dip says of a late sensor.
#[derive(Debug, Clone, Copy)]
pub struct Lateness {
    /// Delay, s.
    pub delay_s: f64,
    /// Its standard error, s.
    pub error_s: f64,
    /// Gain of −2 log posterior by it, all prices paid.
    pub gain: f64,
    /// Share of the squared residual that it explains.
    pub share: f64,
    /// p-value of no delay, by its spread over parts of the log.
    pub p_held_out: f64,
}

impl Lateness {
    /// Whether a delay is to be named.
    pub fn is_shown(&self) -> bool {
        self.gain > MIN_ODDS
            && self.share > MIN_SHARE
            && self.delay_s > 0.0
            && self.p_held_out < MAX_P_HELD_OUT
    }
}

/// What some of the columns explain.
#[derive(Debug, Clone)]
struct Explained {
    /// −2 log posterior.
    cost: f64,
    /// Squares that are left.
    squares: f64,
    /// Value of the last column's parameter.
    last: f64,
    /// Its standard error.
    error: f64,
    noise: Noise,
}

fn likelier(one: Explained, other: Option<Explained>) -> Explained {
    match other {
        Some(other) if other.cost < one.cost => other,
        _ => one,
    }
}

/// The dip of a log at a fit of the magnitude.
pub struct Dip {
    track: Track,
    /// Block means of columns, delay, and residual.
    rows: Vec<f64>,
    width: usize,
    /// Normal matrix and right side of what is known before, per column.
    known: Sums,
    candidates: f64,
}

impl Dip {
    /// `None` where the log has no directions down and rates of turn for most samples, or no rotation is found.
    pub fn of(log: &Log, setting: &Setting, fit: &Fit) -> Option<Dip> {
        if !log.has_down() || !log.has(ironout::effect::Need::Gyro) {
            return None;
        }
        let rows_of = |m: &Matrix3<f64>| core::array::from_fn(|i| core::array::from_fn(|j| m[(i, j)]));
        let model = &fit.model;
        let core =
            CoreModel::new(model.offset.into(), rows_of(&model.matrix), model.field, NO_ROTATION, 0.0)?;
        let mut undisturbed = log.samples.clone();
        for (reading, point) in undisturbed.readings.iter_mut().zip(&fit.points) {
            reading.measured_ut = point.closest.into();
        }
        let aligned = align(&undisturbed, &core).ok()??;
        let rotation = Matrix3::from_fn(|i, j| aligned.model.rotation[i][j]);
        let full = rotation * model.matrix;
        let dip = aligned.model.sin_dip.clamp(-MOST_SINE, MOST_SINE).asin();
        let columns = fit.model.columns();
        let width = columns + OWN + 2;
        let blocks = &setting.blocks;
        let mut counts = vec![0.0; blocks.len()];
        let mut rows = vec![0.0; blocks.len() * width];
        for (sample, (reading, point)) in log.samples.readings.iter().zip(&fit.points).enumerate() {
            let (Some(down), Some(rate)) = (reading.down, reading.turn_radps) else { continue };
            let (down, rate) = (Vector3::from(down), Vector3::from(rate));
            let centred = point.closest - model.offset;
            let h = full * centred;
            let length = h.norm();
            let unit = h / length;
            let sine = down.dot(&unit);
            if sine.abs() > MOST_SINE {
                continue;
            }
            let cosine = (1.0 - sine * sine).sqrt();
            let steep = dip + log.samples.place(sample).bend_rad(aligned.model.sin_dip);
            let scale = model.field / cosine;
            let row = &mut rows[sample / blocks.size * width..][..width];
            counts[sample / blocks.size] += 1.0;
            let across = (down - unit * sine) / length * scale;
            let pull = full.transpose() * across;
            for axis in 0..3 {
                row[axis] -= pull[axis];
            }
            let turned = rotation.transpose() * across;
            for (index, (i, j)) in TRIANGLE.into_iter().enumerate() {
                row[3 + index] += turned[i] * centred[j];
            }
            let at = point.quantities(&model.offset);
            let mut from = BASE;
            for term in &model.terms {
                let shape = term.shape(sample, &at);
                for vector in &shape[..term.k()] {
                    row[from] -= pull.dot(&Vector3::from(*vector));
                    from += 1;
                }
            }
            let by_rotation = unit.cross(&down) * scale;
            let by_zero = log.samples.down_follows(sample, &down).0.transpose() * unit * scale;
            for axis in 0..3 {
                row[from + axis] += by_rotation[axis];
                row[from + 4 + axis] += by_zero[axis];
            }
            row[from + 3] -= model.field;
            row[width - 2] -= down.dot(&rate.cross(&unit)) * scale;
            row[width - 1] += (sine.asin() - steep) * model.field;
        }
        let mut track = Track::default();
        let mut kept = Vec::with_capacity(rows.len());
        for (block, row) in rows.chunks_exact_mut(width).enumerate() {
            if counts[block] < 1.0 {
                continue;
            }
            row.iter_mut().for_each(|value| *value /= counts[block]);
            kept.extend_from_slice(row);
            track.time_s.push(fit.track.time_s[block]);
            track.direction.push([1.0, 0.0, 0.0]);
            track.weight.push(counts[block]);
        }
        if track.weight.len() < 2 * width {
            return None;
        }
        let zero = log.samples.zero_error_square;
        let zero = (zero + Matrix3::identity() * 1e-8).try_inverse()?;
        let all = columns + OWN;
        let mut known = Sums {
            matrix: nalgebra::DMatrix::zeros(all + 1, all + 1),
            right: DVector::zeros(all + 1),
            squares: 0.0,
            rows: 0,
        };
        let magnitude = &fit.sums.matrix / fit.noise.variance;
        known.matrix.view_mut((0, 0), (columns, columns)).copy_from(&magnitude);
        known.matrix.view_mut((columns + 4, columns + 4), (3, 3)).copy_from(&zero);
        Some(Dip { track, rows: kept, width, known, candidates: setting.candidates })
    }

    /// What the first `columns` columns explain.
    fn cost(&self, columns: usize, from: Option<&Noise>) -> Option<Explained> {
        let pick: Vec<f64> = self
            .rows
            .chunks_exact(self.width)
            .flat_map(|row| row[..columns].iter().chain(&row[self.width - 1..]).copied())
            .collect();
        let width = columns + 1;
        let residual: Vec<f64> = pick.chunks_exact(width).map(|row| row[columns]).collect();
        let mut noise = match from {
            Some(noise) => noise.clone(),
            None => Noise::white(&self.track, &residual),
        };
        let mut answer = None;
        for round in 0..ROUNDS {
            let mut whitened = pick.clone();
            noise.whiten(&self.track, width, &mut whitened);
            let mut sums = Sums::of(&whitened, columns);
            for i in 0..columns {
                for j in 0..columns {
                    sums.matrix[(i, j)] += self.known.matrix[(i, j)] * noise.variance;
                }
            }
            let factor = Factor::of(&sums.matrix)?;
            let delta = -factor.solve(&sums.right);
            let left: Vec<f64> = pick
                .chunks_exact(width)
                .map(|row| row[columns] + row[..columns].iter().zip(&delta).map(|(j, d)| j * d).sum::<f64>())
                .collect();
            let from = (round > 0 || from.is_some()).then_some(noise.wander);
            noise = match round {
                LAST => Noise::with(&self.track, noise.wander, &left),
                _ => Noise::fit(&self.track, &left, from, f64::INFINITY),
            };
            let known = self.known.matrix.view((0, 0), (columns, columns));
            let cost = noise.cost + (delta.transpose() * known * &delta)[(0, 0)];
            let squares = left.iter().zip(&self.track.weight).map(|(r, w)| r * r * w).sum();
            let last = columns - 1;
            let mut unit = DVector::zeros(columns);
            unit[last] = 1.0;
            let error = (factor.solve(&unit)[last] * noise.variance).max(0.0).sqrt();
            answer = Some(Explained { cost, squares, last: delta[last], error, noise: noise.clone() });
        }
        answer
    }

    /// Squares of the delay's own part over all: other parameters may have moved next to it.
    fn own_share(&self, with: &Explained) -> f64 {
        let column = self.rows.chunks_exact(self.width).map(|row| row[self.width - 2]);
        let own: f64 = column.zip(&self.track.weight).map(|(value, w)| (value * with.last).powi(2) * w).sum();
        own / (own + with.squares)
    }

    /// p-value of the last column by its spread over parts of the log.
    fn p_held_out(&self, with: &Explained) -> Option<f64> {
        let columns = self.width - 1;
        let mut whitened = self.rows.clone();
        with.noise.whiten(&self.track, self.width, &mut whitened);
        let matrix = Sums::of(&whitened, columns).matrix
            + self.known.matrix.view((0, 0), (columns, columns)) * with.noise.variance;
        let changes = changes(&whitened, columns, &matrix)?;
        Some(p_value(&changes, columns - 1, &DVector::from_element(1, with.last)))
    }

    /// Whether the sensor is late.
    pub fn lateness(&self) -> Option<Lateness> {
        let columns = self.width - 1;
        // Each from the noise of the other too: the likelihood of a noise has several tops.
        let without = self.cost(columns - 1, None)?;
        let with = self.cost(columns, None)?;
        let with = likelier(with, self.cost(columns, Some(&without.noise)));
        let without = likelier(without.clone(), self.cost(columns - 1, Some(&with.noise)));
        let price = (self.track.weight.len() as f64).ln() + 2.0 * self.candidates.ln();
        Some(Lateness {
            delay_s: with.last,
            error_s: with.error,
            gain: without.cost - with.cost - price,
            share: (1.0 - with.squares / without.squares).min(self.own_share(&with)),
            p_held_out: self.p_held_out(&with).unwrap_or(1.0),
        })
    }
}
