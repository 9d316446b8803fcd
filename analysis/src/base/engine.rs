//! Passes over the samples, and the full (nonlinear) fit of a model with effects.

use crate::base::prior::Prior;
use crate::base::term::{BadShape, COLUMNS, Matrix, TERMS, Term};
use crate::samples::samples::Samples;
use crate::threads::{ALONE, halves};
use ironout::study::{Model, NoRow, NotFinite, Residual};

/// When a fit ends.
#[derive(Debug, Clone, Copy)]
pub struct End {
    /// A step that would take less than this share of the squared residuals is the last.
    step_left: f64,
    /// So is a step that would take less than this many variances of one sample.
    variances_left: f64,
    /// After more steps than this that are small against their errors, the last of them is.
    steps_near: u32,
    /// What has not ended after so many steps does not end.
    steps: u32,
}

/// Good enough to go on from: what is left of the way is a thirtieth of a standard error.
const USUAL: End = End { step_left: 1e-9, variances_left: 1e-3, steps_near: 1, steps: 24 };

/// Where the steps themselves end, wherever they began: the shape of a coupling depends on the model, which its derivatives
/// leave out, so that the least sum is not quite where no step is left.
pub const SETTLED: End = End { step_left: 1e-15, variances_left: 0.0, steps_near: 20, steps: 40 };

/// Where a full step promises to take less than this share off the squared residuals it may raise them by as much: it goes to where
/// the columns at the closest point ask for no further one, which noise has moved from where the sum is least.
const RISE: f64 = 1e-3;

/// A fit has ended where no step lowers the error and the step is at most so many of its own variances ...
const STALLED: f64 = 1.0;
/// ... or this share of what the columns' own noise asks for: they are taken at the closest point, which noise moves, so that
/// their sum with the residual is not quite the error's slope. The more samples, and the more noise a sample, the more it is
/// against the step's own error.
const STALLED_BY_NOISE: f64 = 0.25;

/// After more steps than this near the end that do not become smaller there is nothing to wait for.
const MOST_ALIKE: u32 = 4;

/// Steps so damped that do not lower the error either end a fit.
const TOO_DAMPED: f64 = 1e2;

/// So many effects are most of the passes; the room for more costs each sample its clearing.
const FEW_TERMS: usize = 5;

/// What a pass runs over and how.
#[derive(Clone, Copy)]
pub struct Design<'a> {
    /// The samples.
    pub samples: &'a Samples,
    /// The residual.
    pub residual: Residual,
}

impl<'a> Design<'a> {
    /// Over these samples.
    pub fn new(samples: &'a Samples, residual: Residual) -> Self {
        Design { samples, residual }
    }
}

impl Design<'_> {
    /// Rows of samples `range`, each as `use_row(sample, row, residual)`.
    pub fn rows(
        &self,
        range: std::ops::Range<usize>,
        model: &Model<f64>,
        terms: &[&Term],
        mut use_row: impl FnMut(usize, &[f64; COLUMNS], f64),
    ) -> Result<(), BadShape> {
        let mut at_sample = Vec::with_capacity(terms.len());
        for sample in range {
            at_sample.clear();
            at_sample.extend(terms.iter().map(|term| term.at_sample(sample)));
            let mut axis = 0;
            let axes = self.samples.axes;
            let vector = self.residual == Residual::Vector;
            let there;
            let model = match self.samples.places.get(sample) {
                Some(place) => {
                    there = place.of(model, self.residual);
                    &there
                }
                None => model,
            };
            let reading = &self.samples.readings[sample];
            let push = |row: &[f64; COLUMNS], r: f64| {
                if !vector || axes[axis % 3] {
                    use_row(sample, row, r);
                }
                axis += 1;
            };
            let done = match at_sample.len() <= FEW_TERMS {
                true => model.rows::<FEW_TERMS, COLUMNS>(self.residual, reading, &at_sample, push),
                false => model.rows::<TERMS, COLUMNS>(self.residual, reading, &at_sample, push),
            };
            match done {
                Ok(()) | Err(NoRow::NotFinite(NotFinite::Sample)) => {}
                Err(NoRow::NotFinite(NotFinite::Effect(index))) => {
                    return Err(BadShape::NotFinite(
                        terms.get(index).map_or_else(String::new, |term| term.id.clone()),
                    ));
                }
                Err(NoRow::TooManyTerms { .. } | NoRow::TooWide { .. }) => {
                    return Err(BadShape::NoRoom(
                        terms.last().map_or_else(String::new, |term| term.id.clone()),
                    ));
                }
            }
        }
        Ok(())
    }

    /// Normal matrices of the blocks between `bounds`, on two threads.
    pub fn blocks(
        &self,
        bounds: &[usize],
        model: &Model<f64>,
        terms: &[&Term],
    ) -> Result<Vec<Matrix>, BadShape> {
        let columns = self.residual.base_columns() + terms.iter().map(|term| term.k()).sum::<usize>();
        self.samples.work.add(self.samples.len() * (2 + terms.len() + columns / 8));
        let ranges: Vec<_> = bounds.windows(2).map(|pair| pair[0]..pair[1]).collect();
        let work = |ranges: &[std::ops::Range<usize>]| -> Result<Vec<Matrix>, BadShape> {
            ranges
                .iter()
                .map(|range| {
                    let mut matrix = Matrix::new(columns);
                    self.rows(range.clone(), model, terms, |_, row, r| matrix.push(row, r))?;
                    Ok(matrix)
                })
                .collect()
        };
        if self.samples.len() < ALONE || ranges.len() < 2 {
            return work(&ranges);
        }
        let (first, second) = halves(ranges.split_at(ranges.len() / 2), |half| work(half));
        let mut blocks = first?;
        blocks.extend(second?);
        Ok(blocks)
    }
}

/// A fitted model.
#[derive(Clone)]
pub struct Fitted<'a> {
    /// The base model.
    pub model: Model<f64>,
    /// The effects with their coefficients.
    pub terms: Vec<Term<'a>>,
    /// The pass at the solution, by block of time.
    pub blocks: Vec<Matrix>,
    /// The prior at the solution.
    pub prior: Matrix,
    /// Sum of squared residuals.
    pub squares: f64,
    /// Rows.
    pub rows: f64,
    /// Whether the fit came to where a further step is small against its own error.
    pub converged: bool,
}

impl Fitted<'_> {
    /// Columns of base and effects.
    pub fn columns(&self) -> usize {
        self.blocks.first().map_or(0, Matrix::columns)
    }

    /// Rms residual.
    pub fn rms(&self) -> f64 {
        (self.squares / self.rows.max(1.0)).sqrt()
    }

    /// Spread of the residual, parameters counted.
    pub fn sigma(&self) -> f64 {
        (self.squares / (self.rows - self.columns() as f64).max(1.0)).sqrt()
    }

    /// Sum of the blocks with the prior.
    pub fn total(&self) -> Matrix {
        Matrix::total(&self.blocks, Some(&self.prior))
    }
}

fn stepped<'a>(
    residual: Residual,
    model: &Model<f64>,
    terms: &[Term<'a>],
    delta: &[f64; COLUMNS],
) -> Option<(Model<f64>, Vec<Term<'a>>)> {
    let model = match residual {
        Residual::Magnitude => model.stepped(delta)?,
        Residual::Dip => model.aligned(delta)?,
        Residual::Vector => {
            let [x, y, z] = model.offset_ut;
            let offset = [x + delta[0], y + delta[1], z + delta[2]];
            Model::new(offset, model.matrix, model.field_ut, model.rotation, model.sin_dip)?
        }
    };
    let mut terms = terms.to_vec();
    let mut column = residual.base_columns();
    for term in &mut terms {
        let k = term.k();
        for coefficient in &mut term.coefficients[..k] {
            *coefficient += delta[column];
            column += 1;
        }
    }
    Some((model, terms))
}

impl Design<'_> {
    /// A model as it is, without a fit.
    pub fn hold<'a>(
        &self,
        model: Model<f64>,
        terms: Vec<Term<'a>>,
        known: &Prior,
    ) -> Result<Fitted<'a>, BadShape> {
        let list: Vec<&Term> = terms.iter().collect();
        let blocks = self.blocks(&self.folds(&list), &model, &list)?;
        let data = Matrix::total(&blocks, None);
        let (squares, rows) = (data.squares(), f64::from(data.rows()));
        let sigma = (squares / (rows - data.columns() as f64).max(1.0)).sqrt();
        let prior = known.matrix(self.residual, &model, sigma, &list, &data);
        Ok(Fitted { model, terms, blocks, prior, squares, rows, converged: true })
    }

    /// Levenberg–Marquardt from `model` and the terms' coefficients.
    pub fn fit<'a>(
        &self,
        model: Model<f64>,
        terms: Vec<Term<'a>>,
        known: &Prior,
    ) -> Result<Option<Fitted<'a>>, BadShape> {
        self.fit_to(USUAL, model, terms, known)
    }

    /// The same to another end.
    pub fn fit_to<'a>(
        &self,
        end: End,
        model: Model<f64>,
        terms: Vec<Term<'a>>,
        known: &Prior,
    ) -> Result<Option<Fitted<'a>>, BadShape> {
        let bounds = self.folds(&terms.iter().collect::<Vec<_>>());
        let evaluate = |model: &Model<f64>, terms: &[Term<'a>], sigma: Option<f64>| {
            let list: Vec<&Term> = terms.iter().collect();
            let blocks = self.blocks(&bounds, model, &list)?;
            let data = Matrix::total(&blocks, None);
            let rows = f64::from(data.rows());
            let sigma = sigma.unwrap_or((data.squares() / (rows - data.columns() as f64).max(1.0)).sqrt());
            let prior = known.matrix(self.residual, model, sigma, &list, &data);
            Ok((blocks, prior, data.squares(), rows, sigma))
        };
        let (mut model, mut terms) = (model, terms);
        let started = match evaluate(&model, &terms, None) {
            // Coefficients from another model ran away here: no fit, and no fault of the shape.
            Err(BadShape::NotFinite(_)) if terms.iter().any(Term::stands) => return Ok(None),
            started => started?,
        };
        let (mut blocks, mut prior, mut squares, mut rows, mut sigma) = started;
        let mut damping = 0.0;
        let mut converged = false;
        let mut steps_near = 0;
        // Steps near the end that promise hardly less than the one before: they go on for ever.
        let (mut steps_alike, mut last_near) = (0, f64::INFINITY);
        // What the last step that was not damped much promised, in variances of one sample.
        let mut promised = f64::INFINITY;
        // What the last step promised that raised the sum: such steps become smaller, or there are no more.
        let mut rose_for = f64::INFINITY;
        for _ in 0..end.steps {
            let total = Matrix::total(&blocks, Some(&prior));
            let Some(factor) = total.damped_factor(damping) else {
                if damping > 1e3 {
                    return Ok(None);
                }
                damping = if damping == 0.0 { 1e-6 } else { damping * 10.0 };
                continue;
            };
            let delta = total.step(&factor);
            let predicted: f64 = (0..total.columns()).map(|i| -delta[i] * total.right(i)).sum();
            let left = end.step_left * total.squares().max(1e-300);
            let settled = damping < 1.0 && predicted <= end.variances_left * sigma * sigma;
            if settled || predicted <= left {
                converged = true;
                break;
            }
            // A step of a tenth of its standard error; where rounding or the columns' own error lets no further one pass,
            // that is near enough.
            let near = damping < 1.0 && predicted <= 0.01 * sigma * sigma;
            steps_near = if near { steps_near + 1 } else { 0 };
            if damping < 1.0 {
                promised = predicted / (sigma * sigma).max(f64::MIN_POSITIVE);
            }
            steps_alike = if near && predicted > 0.5 * last_near { steps_alike + 1 } else { 0 };
            last_near = if near { predicted } else { f64::INFINITY };
            if steps_near > end.steps_near || steps_alike > MOST_ALIKE {
                converged = true;
                break;
            }
            let moved = stepped(self.residual, &model, &terms, &delta);
            let better = match moved {
                Some((model, terms)) => match evaluate(&model, &terms, Some(sigma)) {
                    Ok(next) => {
                        let cost = next.2 + next.1.squares();
                        let full = damping == 0.0 && predicted < RISE * total.squares();
                        let rise = if full && predicted < 0.5 * rose_for { RISE } else { 0.0 };
                        if cost > total.squares() {
                            rose_for = predicted;
                        }
                        (cost < total.squares() * (1.0 + rise)).then_some((model, terms, next))
                    }
                    // A step so far that a shape ran away: a shorter one is tried.
                    Err(BadShape::NotFinite(_)) => None,
                    Err(bad) => return Err(bad),
                },
                None => None,
            };
            match better {
                Some((next_model, next_pieces, next)) => {
                    (model, terms) = (next_model, next_pieces);
                    (blocks, _, squares, rows, _) = next;
                    let list: Vec<&Term> = terms.iter().collect();
                    let data = Matrix::total(&blocks, None);
                    sigma = (squares / (rows - data.columns() as f64).max(1.0)).sqrt();
                    prior = known.matrix(self.residual, &model, sigma, &list, &data);
                    damping = if damping < 1e-7 { 0.0 } else { damping * 0.1 };
                }
                None if near || damping > TOO_DAMPED => {
                    // No step lowers the error, and the columns' own error is all that asks for one.
                    let noise = match self.residual {
                        Residual::Magnitude => sigma / model.field_ut,
                        Residual::Dip => sigma,
                        Residual::Vector => 0.0,
                    };
                    converged = near || promised <= STALLED.max(STALLED_BY_NOISE * rows * noise * noise);
                    break;
                }
                None => damping = if damping == 0.0 { 1e-4 } else { damping * 30.0 },
            }
        }
        Ok(Some(Fitted { model, terms, blocks, prior, squares, rows, converged }))
    }
}
