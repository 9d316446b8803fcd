//! A model fitted to a log under the likeliest noise, with its score.

use crate::base::prior::Prior as Known;
use crate::base::start;
use crate::base::term::Matrix as Information;
use crate::bounds::{
    MATRIX_PRIOR, MAX_WANDER_FIELDS, MOST_ABOVE_LEAST, OFFSET_PRIOR_FIELDS, TERM_PRIOR_FIELDS,
};
use crate::evidence::design::{BASE, Blocks, Model, Point, TRIANGLE, rows};
use crate::evidence::log::Log;
use crate::evidence::solve::{Factor, Sums};
use crate::noise::model::{Noise, Track, Wander};
use ironout::effect::Bends;
use ironout::study::{Model as CoreModel, Residual};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// A Gauss–Newton step that promises less than this of −2 log likelihood is the last.
const SETTLED: f64 = 0.02;
/// Less than this is near enough for shapes at the closest points.
const NEAR: f64 = 1.0;
/// Steps of one fit, at most.
const MOST_STEPS: usize = 20;
/// Shares of the diagonal that damp a step which leads away otherwise.
const DAMPINGS: [f64; 9] = [0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0];
/// Samples that the size of a shape is taken from.
const SIZED_BY: usize = 200;

/// A fitted model.
#[derive(Clone)]
pub struct Fit<'a> {
    /// The model.
    pub model: Model<'a>,
    /// Every sample at it.
    pub points: Vec<Point>,
    /// Where the blocks are seen.
    pub track: Track,
    /// The noise.
    pub noise: Noise,
    /// Block means of columns and residual.
    pub rows: Vec<f64>,
    /// Their normal matrix, whitened, with the priors.
    pub sums: Sums,
    /// −2 log posterior, without constants.
    pub score: f64,
    /// Sum of squared residuals of the samples, µT².
    pub squares: f64,
}

/// What the columns are known by besides the log: 1σ of each, and where each is expected.
struct Prior<'k> {
    sigma: Vec<f64>,
    expected: Vec<f64>,
    /// What else is known of offset and matrix, instead of the first nine.
    known: Option<&'k Known>,
}

impl<'k> Prior<'k> {
    fn of(log: &Log<'k>, model: &Model, points: &[Point], scale: f64) -> Prior<'k> {
        let (mut sigma, mut expected) = (Vec::new(), Vec::new());
        let mean = log.samples.mean_vector();
        for axis in 0..3 {
            sigma.push(OFFSET_PRIOR_FIELDS * model.field / scale);
            expected.push(mean[axis]);
        }
        for (i, j) in TRIANGLE {
            sigma.push(MATRIX_PRIOR * scale);
            expected.push(if i == j { scale } else { 0.0 });
        }
        let every = points.len().div_ceil(SIZED_BY).max(1);
        for term in &model.terms {
            let mut squares = vec![0.0; term.k()];
            let mut count = 0.0;
            for (sample, point) in points.iter().enumerate().step_by(every) {
                let shape = term.shape(sample, &point.quantities(&model.offset));
                squares.iter_mut().zip(shape).for_each(|(sum, v)| *sum += Vector3::from(v).norm_squared());
                count += 1.0;
            }
            for sum in squares {
                sigma.push(TERM_PRIOR_FIELDS * model.field / scale / (sum / count).sqrt().max(1e-12));
                expected.push(0.0);
            }
        }
        if log.known.is_some() {
            sigma[..BASE].fill(f64::INFINITY);
        }
        Prior { sigma, expected, known: log.known }
    }

    /// What is known of offset and matrix as information, in units of this σ, µT.
    fn information(&self, model: &Model, sigma: f64) -> Option<Information> {
        let rows = core::array::from_fn(|i| core::array::from_fn(|j| model.matrix[(i, j)]));
        let model = CoreModel::new(model.offset.into(), rows, model.field, start::NO_ROTATION, 0.0)?;
        Some(self.known?.matrix(Residual::Magnitude, &model, sigma, &[], &Information::new(BASE)))
    }

    /// Adds it to sums whose rows have this variance.
    fn inform(&self, sums: &mut Sums, model: &Model, variance: f64) {
        let values = parameters(model);
        let weight: Vec<f64> = self.sigma.iter().map(|sigma| variance / (sigma * sigma)).collect();
        let off: Vec<f64> =
            values.iter().zip(&self.expected).map(|(value, expected)| value - expected).collect();
        sums.inform(&weight, &off);
        if let Some(known) = self.information(model, variance.sqrt()) {
            for i in 0..BASE {
                sums.right[i] += known.right(i);
                for j in 0..BASE {
                    sums.matrix[(i, j)] += known.entry(i, j);
                }
            }
            sums.squares += known.squares();
        }
    }

    /// Its part of −2 log posterior.
    fn cost(&self, model: &Model) -> f64 {
        let values = parameters(model);
        let known = self.information(model, 1.0).map_or(0.0, |known| known.squares());
        let off = values.iter().zip(&self.expected).zip(&self.sigma).map(|((v, e), s)| ((v - e) / s).powi(2));
        known + off.sum::<f64>()
    }
}

/// All parameters in the order of the columns.
pub fn parameters(model: &Model) -> Vec<f64> {
    let mut out: Vec<f64> = model.offset.iter().copied().collect();
    out.extend(TRIANGLE.iter().map(|&(i, j)| model.matrix[(i, j)]));
    for term in &model.terms {
        out.extend(&term.coefficients[..term.k()]);
    }
    out
}

fn moved<'a>(model: &Model<'a>, delta: &DVector<f64>) -> Model<'a> {
    let mut model = model.clone();
    for axis in 0..3 {
        model.offset[axis] += delta[axis];
    }
    for (index, (i, j)) in TRIANGLE.into_iter().enumerate() {
        model.matrix[(i, j)] += delta[3 + index];
    }
    let mut at = BASE;
    for term in &mut model.terms {
        for c in 0..term.k() {
            term.coefficients[c] += delta[at];
            at += 1;
        }
    }
    model
}

/// What a fit goes on from: how samples are gathered, the scale of the matrix, and how many candidates compete.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// The blocks.
    pub blocks: Blocks,
    /// Field over the radius that the readings turn on: what an ideal sensor's matrix would be.
    pub scale: f64,
    /// Candidates of the log.
    pub candidates: f64,
    /// Whether the noise is held white.
    pub is_white: bool,
}

/// The models that a log may begin with: the one given, and where nothing else is known the sphere in the middle of the readings. Each
/// with its scale.
pub fn starts<'a>(begin: &CoreModel<f64>, log: &Log) -> Vec<(Model<'a>, f64)> {
    let model = |offset: [f64; 3], matrix, field| Model {
        offset: offset.into(),
        matrix,
        field,
        terms: Vec::new(),
        bends: Bends::Field,
    };
    // Of a board at rest the reading itself is the size that disturbances are measured by.
    let field = if log.is_at_rest { Vector3::from(log.samples.mean_vector()).norm() } else { begin.field_ut };
    let matrix = Matrix3::from_fn(|i, j| begin.matrix[i][j]);
    let mut list = vec![(model(begin.offset_ut, matrix, field), matrix.determinant().abs().cbrt())];
    if log.known.is_none()
        && !log.is_at_rest
        && let Some((centre, radius)) = start::sphere(log.samples)
    {
        list.push((model(centre, Matrix3::identity() * (field / radius), field), field / radius));
    }
    list
}

fn residual_of(rows: &[f64], width: usize) -> Vec<f64> {
    rows.chunks_exact(width).map(|row| row[width - 1]).collect()
}

impl<'a> Fit<'a> {
    /// Fits a model from where it stands. `near` is a fit of a model nearby on the same samples: the noise begins at its wander.
    pub fn of(log: &Log<'a>, setting: &Setting, model: Model<'a>, near: Option<&Fit<'a>>) -> Option<Fit<'a>> {
        let from = near.map(|fit| fit.noise.wander);
        Fit::from(log, setting, model, from, near.map_or(&[], |fit| &fit.points))
    }

    /// The same from a wander, and every sample at a model nearby.
    pub fn from(
        log: &Log<'a>,
        setting: &Setting,
        model: Model<'a>,
        from: Option<Wander>,
        near: &[Point],
    ) -> Option<Fit<'a>> {
        let blocks = &setting.blocks;
        let mut model = model;
        let mut points = model.points(log, false, near)?;
        let prior = Prior::of(log, &model, &points, setting.scale);
        let width = model.columns() + 1;
        let mut track = blocks.track(log, &points);
        let mut rows_now = rows(blocks, &model, &points);
        // White noise at first: what is far is far whatever the noise.
        let mut noise = Noise::white(&track, &left_after(&rows_now, width, &track, &prior, &model)?);
        let mut most_squares = f64::INFINITY;
        // From far with shapes at the readings, then the likeliest noise, then with shapes at the closest points.
        for (round, is_near) in [false, true, true].into_iter().enumerate() {
            let (mut steps, mut damped) = (0, 0);
            if round > 0 {
                points = model.points(log, true, &points)?;
                rows_now = rows(blocks, &model, &points);
                let residual = residual_of(&rows_now, width);
                let most_ut = MAX_WANDER_FIELDS * model.field / setting.scale;
                noise = match round {
                    _ if setting.is_white => Noise::white(&track, &residual),
                    1 => {
                        most_squares = MOST_ABOVE_LEAST * plain_squares(&track, &residual);
                        Noise::fit(&track, &residual, from, most_ut)
                    }
                    _ => Noise::with(&track, noise.wander, &residual),
                };
            }
            loop {
                let sums = whitened_sums(&rows_now, width, &track, &noise);
                let mut known = sums.clone();
                prior.inform(&mut known, &model, noise.variance);
                let factor = known.factor()?;
                let delta = -factor.solve(&known.right);
                let promised = -known.right.dot(&delta) / noise.variance;
                let enough = if is_near { SETTLED } else { NEAR };
                if !(promised >= enough) || steps >= MOST_STEPS {
                    break;
                }
                steps += 1;
                let now = sums.squares / noise.variance + prior.cost(&model);
                let mut better = None;
                for (index, damping) in DAMPINGS.into_iter().enumerate().skip(damped) {
                    let delta = match damping > 0.0 {
                        true => -Factor::damped(&known.matrix, damping)?.solve(&known.right),
                        false => delta.clone(),
                    };
                    let next = moved(&model, &delta);
                    let Some(next_points) = next.points(log, is_near, &points) else { continue };
                    let mut residual = blocks.means(1, |sample, row| row[0] = next_points[sample].residual);
                    // A wander can stand for an offset far off: the squares themselves tell that the model went astray.
                    if plain_squares(&track, &residual) > most_squares {
                        continue;
                    }
                    noise.whiten(&track, 1, &mut residual);
                    let squares: f64 = residual.iter().map(|v| v * v).sum();
                    let cost = squares / noise.variance + prior.cost(&next);
                    // Columns at the closest point ask for a little more than the squares show.
                    if cost < now + if is_near { 0.1 * promised.min(10.0) } else { 0.0 } {
                        damped = index.saturating_sub(1);
                        better = Some((next, next_points, now - cost));
                        break;
                    }
                }
                let Some((next, next_points, gained)) = better else { break };
                (model, points) = (next, next_points);
                track = blocks.track(log, &points);
                rows_now = rows(blocks, &model, &points);
                if gained < 0.25 * enough && promised < 1.0 {
                    break;
                }
            }
        }
        let residual = residual_of(&rows_now, width);
        let noise = match setting.is_white {
            true => Noise::white(&track, &residual),
            false => Noise::with(&track, noise.wander, &residual),
        };
        let mut sums = whitened_sums(&rows_now, width, &track, &noise);
        prior.inform(&mut sums, &model, noise.variance);
        let squares = points.iter().map(|point| point.residual * point.residual).sum();
        let n = residual.len() as f64;
        let price: f64 = model
            .terms
            .iter()
            .map(|term| {
                term.visible() as f64 * n.ln() + term.odds + 2.0 * (term.trials * setting.candidates).ln()
            })
            .sum();
        let score = noise.cost + prior.cost(&model) + price;
        score.is_finite().then_some(Fit { model, points, track, noise, rows: rows_now, sums, score, squares })
    }

    /// Rms of the residual, µT.
    pub fn rms(&self) -> f64 {
        (self.squares / self.points.len().max(1) as f64).sqrt()
    }

    /// Residual of the blocks, µT.
    pub fn residual(&self) -> Vec<f64> {
        residual_of(&self.rows, self.model.columns() + 1)
    }

    /// Covariance of all parameters.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        Some(Factor::of(&self.sums.matrix)?.inverse() * self.noise.variance)
    }
}

fn whitened_sums(rows: &[f64], width: usize, track: &Track, noise: &Noise) -> Sums {
    let mut whitened = rows.to_vec();
    noise.whiten(track, width, &mut whitened);
    Sums::of(&whitened, width - 1)
}

fn plain_squares(track: &Track, residual: &[f64]) -> f64 {
    residual.iter().zip(&track.weight).map(|(r, w)| r * r * w).sum()
}

/// The residual with its columns taken out under white noise.
fn left_after(rows: &[f64], width: usize, track: &Track, prior: &Prior, model: &Model) -> Option<Vec<f64>> {
    let noise = Noise::white(track, &residual_of(rows, width));
    let mut sums = whitened_sums(rows, width, track, &noise);
    prior.inform(&mut sums, model, noise.variance);
    let delta = -sums.factor()?.solve(&sums.right);
    let left =
        |row: &[f64]| row[width - 1] + row[..width - 1].iter().zip(&delta).map(|(j, d)| j * d).sum::<f64>();
    Some(rows.chunks_exact(width).map(left).collect())
}
