//! The model of a log and its linearisation: residual over the gradient, and the columns of every parameter.
//!
//! A reading is `m = x + Σ Φ(x)θ + w`, where x = A·h + b lies on the ellipsoid `‖C(x − b)‖ = F`. The residual is the distance of the
//! undisturbed reading from the ellipsoid, over the gradient g by m: then it is the noise w along the unit vector q = g/‖g‖, in µT
//! of the sensor, whatever the model. Columns are taken at the closest point of the ellipsoid, which noise along q does not move.

use crate::base::term::Term;
use crate::bounds::LEAST_SLOPE;
use crate::evidence::closest::{Surface, quantities};
use crate::evidence::log::Log;
use crate::noise::model::Track;
use core::ops::SubAssign;
use ironout::effect::{Bends, Quantities, no_shape};
use ironout::study::Observation;
use nalgebra::{Matrix3, Vector3};

/// Steps to the closest point of an ellipsoid: the error falls by the residual over the field in each.
const FOOT_STEPS: usize = 3;
/// What the closest point of a bent surface costs, in looks at a sample: a step to it looks at it once along each axis.
const LOOKS_OF_CLOSEST: usize = 8;
/// The base columns: three of the offset, six of the upper triangular matrix.
pub const BASE: usize = 9;
/// Entries of the triangle in the order of the columns.
pub const TRIANGLE: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// Offset, matrix and field, with the terms.
#[derive(Clone)]
pub struct Model<'a> {
    /// b, µT.
    pub offset: Vector3<f64>,
    /// C, upper triangular.
    pub matrix: Matrix3<f64>,
    /// F, µT.
    pub field: f64,
    /// The terms.
    pub terms: Vec<Term<'a>>,
    /// What those terms bend that read the field.
    pub bends: Bends,
}

/// One sample at a model.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Closest point of the ellipsoid, µT.
    pub closest: Vector3<f64>,
    /// Unit gradient of the residual by the reading.
    pub direction: Vector3<f64>,
    /// Gradient by an undisturbed reading, over the length of that by the reading.
    pub pull: Vector3<f64>,
    /// What a unit of the corrected vector is in µT of the residual.
    pub stretch: f64,
    /// Corrected direction.
    pub unit: Vector3<f64>,
    /// The residual, µT of the sensor.
    pub residual: f64,
    /// Where shapes are taken: the closest point, or the reading that belongs to it.
    pub shaped_at: Vector3<f64>,
    /// What a unit of disturbance takes off the residual.
    pub lever: Vector3<f64>,
    /// Rate of the field there, A(ω × h), µT/s.
    pub turning: Vector3<f64>,
}

impl Point {
    /// What an effect reads of it.
    pub fn quantities(&self, offset: &Vector3<f64>) -> Quantities<f64> {
        let mut at = Quantities::of_vector(self.shaped_at.into());
        at.centred_ut = (self.shaped_at - offset).into();
        at.turning_ut_per_s = self.turning.into();
        at
    }
}

impl Model<'_> {
    /// The same model on other samples of the log.
    pub fn rebound<'b>(&self, log: &Log<'b>) -> Option<Model<'b>> {
        let terms = self.terms.iter().map(|term| log.again(term)).collect::<Option<Vec<_>>>()?;
        Some(Model { offset: self.offset, matrix: self.matrix, field: self.field, terms, bends: self.bends })
    }

    /// Columns of base and terms.
    pub fn columns(&self) -> usize {
        BASE + self.terms.iter().map(Term::k).sum::<usize>()
    }

    /// Every sample at this model; `None` where one has no undisturbed reading, or lies at the centre. Far from the solution shapes
    /// are taken at the readings themselves: the closest point moves with what is fitted. Near it they are taken at the closest
    /// point, where noise does not correlate with them. `before` is every sample at a model nearby, if there is one: closest points
    /// are looked for from there.
    pub fn points(&self, log: &Log, is_near: bool, before: &[Point]) -> Option<Vec<Point>> {
        if log.is_at_rest {
            return Some(self.points_at_rest(log));
        }
        let inverse = self.matrix.try_inverse()?;
        let reads = self.terms.iter().any(Term::reads);
        let step = 1e-3 * self.field;
        let mut points = Vec::with_capacity(log.len());
        let fixed: Vec<&Term> = self.terms.iter().filter(|term| !term.reads()).collect();
        let reading: Vec<&Term> = self.terms.iter().filter(|term| term.reads()).collect();
        let read_turn = reading.iter().any(|term| term.effect.needs_gyro());
        let nowhere = Quantities::of_vector([0.0; 3]);
        let mut last = Vector3::zeros();
        log.look(log.len() * if reads && self.bends == Bends::Field { LOOKS_OF_CLOSEST } else { 1 });
        for (sample, observation) in log.samples.readings.iter().enumerate() {
            let added: Vector3<f64> = fixed.iter().map(|term| term.disturbance(sample, &nowhere)).sum();
            let measured = Vector3::from(observation.measured_ut) - added;
            let turn = observation.turn_radps.map(Vector3::from);
            let rate = turn.filter(|_| read_turn);
            let field = self.field * log.share.get(sample).copied().unwrap_or(1.0);
            let disturbed = |x: &Vector3<f64>| -> Vector3<f64> {
                let at = quantities(x, rate, &self.offset, &self.matrix, &inverse);
                reading.iter().map(|term| term.disturbance(sample, &at)).sum()
            };
            let point = if reads && self.bends == Bends::Field {
                let surface = Surface {
                    offset: self.offset,
                    matrix: &self.matrix,
                    reading: &reading,
                    inverse: &inverse,
                    sample,
                    rate,
                    field,
                };
                let closest_point = match before.get(sample) {
                    Some(point) => surface.closest(&measured, point.unit, &[])?,
                    None => {
                        let near = self.matrix * (measured - disturbed(&measured) - self.offset);
                        let straight = self.matrix * (measured - self.offset);
                        let starts = [near, straight].map(|h| h.try_normalize(1e-3 * self.field));
                        let others = [starts[1].unwrap_or(last), last];
                        let others = if last == Vector3::zeros() { &others[..1] } else { &others[..] };
                        surface.closest(&measured, starts[0].or(starts[1])?, others)?
                    }
                };
                last = closest_point.unit;
                let pull = closest_point.slope.transpose() * closest_point.normal;
                Point {
                    closest: closest_point.x,
                    direction: closest_point.normal,
                    pull,
                    stretch: closest_point.unit.dot(&(inverse.transpose() * pull)),
                    unit: closest_point.unit,
                    residual: closest_point.residual,
                    shaped_at: if is_near { closest_point.x } else { measured },
                    lever: closest_point.normal,
                    turning: Vector3::zeros(),
                }
            } else {
                // What is added to a reading is no part of what bends it: the shape is of the whole.
                let whole = measured + added;
                let (x, answer) = if reads {
                    let here = disturbed(&whole);
                    let mut answer = Matrix3::identity();
                    for axis in 0..3 {
                        let mut moved = whole;
                        moved[axis] += step;
                        let by_axis = (disturbed(&moved) - here) / step;
                        answer.column_mut(axis).sub_assign(&by_axis);
                    }
                    (measured - here, answer)
                } else {
                    (measured, Matrix3::identity())
                };
                if !(answer.determinant() > LEAST_SLOPE && answer.determinant() < 1.0 / LEAST_SLOPE) {
                    return None;
                }
                // Towards the closest point: where the ellipsoid is stretched, the gradient at a noisy reading is another, and its error
                // correlates with the noise.
                let mut closest_point = x;
                let mut seen = None;
                for _ in 0..if reads { 1 } else { FOOT_STEPS } {
                    let h = self.matrix * (closest_point - self.offset);
                    let length = h.norm();
                    if !(length > 1e-3 * self.field) {
                        return None;
                    }
                    let unit = h / length;
                    let pull = self.matrix.transpose() * unit;
                    let gradient = answer.transpose() * pull;
                    let size = gradient.norm();
                    let direction = gradient / size;
                    let residual = direction.dot(&(x - closest_point)) + (length - field) / size;
                    closest_point = x - direction * residual;
                    seen = Some((unit, pull, size, direction, residual));
                }
                let (unit, pull, size, direction, residual) = seen?;
                let noise = if is_near || !reads { direction * residual } else { Vector3::zeros() };
                let closest = x - answer * noise;
                let (shaped_at, lever) = match self.bends {
                    Bends::Field => (closest, direction),
                    Bends::Reading => (whole - noise, pull / size),
                };
                Point {
                    closest,
                    direction,
                    pull: pull / size,
                    stretch: 1.0 / size,
                    unit,
                    residual,
                    shaped_at,
                    lever,
                    turning: Vector3::zeros(),
                }
            };
            let turning = match turn {
                Some(rate) => inverse * rate.cross(&(self.matrix * (point.shaped_at - self.offset))),
                None => Vector3::zeros(),
            };
            if !point.residual.is_finite() {
                return None;
            }
            points.push(Point { turning, ..point });
        }
        Some(points)
    }

    /// Every reading of a board at rest: one axis after the other, each its own residual. The offset is all that the base has.
    fn points_at_rest(&self, log: &Log) -> Vec<Point> {
        let nowhere = Quantities::of_vector([0.0; 3]);
        log.look(log.len());
        let point = |(sample, observation): (usize, &Observation<f64>)| {
            let added: Vector3<f64> = self.terms.iter().map(|term| term.disturbance(sample, &nowhere)).sum();
            let measured = Vector3::from(observation.measured_ut);
            let axis = Vector3::ith(sample % 3, 1.0);
            Point {
                closest: measured,
                direction: axis,
                pull: axis,
                stretch: 0.0,
                unit: axis,
                residual: axis.dot(&(measured - added - self.offset)),
                shaped_at: measured,
                lever: axis,
                turning: Vector3::zeros(),
            }
        };
        log.samples.readings.iter().enumerate().map(point).collect()
    }
}

/// How samples are gathered into blocks.
#[derive(Debug, Clone, Copy)]
pub struct Blocks {
    /// Samples per block.
    pub size: usize,
    /// Samples.
    pub samples: usize,
}

impl Blocks {
    /// At most `most` blocks.
    pub fn at_most(samples: usize, most: usize) -> Blocks {
        Blocks { size: samples.div_ceil(most).max(1), samples }
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.samples.div_ceil(self.size)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.samples == 0
    }

    fn weight(&self, block: usize) -> f64 {
        (self.samples - block * self.size).min(self.size) as f64
    }

    /// Where the blocks of a linearisation are seen.
    pub fn track(&self, log: &Log, points: &[Point]) -> Track {
        let mut track = Track::default();
        for (block, chunk) in points.chunks(self.size).enumerate() {
            let weight = chunk.len() as f64;
            let times = &log.time_s[block * self.size..][..chunk.len()];
            track.time_s.push(times.iter().sum::<f64>() / weight);
            track.direction.push((chunk.iter().map(|p| p.direction).sum::<Vector3<f64>>() / weight).into());
            track.weight.push(weight);
        }
        track
    }

    /// Block means of `width` columns that `fill` writes for a sample.
    pub fn means(&self, width: usize, mut fill: impl FnMut(usize, &mut [f64])) -> Vec<f64> {
        let mut out = vec![0.0; self.len() * width];
        if self.size == 1 {
            for (sample, row) in out.chunks_exact_mut(width).enumerate() {
                fill(sample, row);
            }
            return out;
        }
        let mut one = vec![0.0; width];
        for sample in 0..self.samples {
            one.fill(0.0);
            fill(sample, &mut one);
            let block = sample / self.size;
            let row = &mut out[block * width..][..width];
            row.iter_mut().zip(&one).for_each(|(sum, value)| *sum += value);
        }
        for (block, row) in out.chunks_exact_mut(width).enumerate() {
            let weight = self.weight(block);
            row.iter_mut().for_each(|value| *value /= weight);
        }
        out
    }
}

/// Derivatives of one sample's residual by the base parameters.
pub fn base_row(point: &Point, offset: &Vector3<f64>, row: &mut [f64]) {
    for axis in 0..3 {
        row[axis] = -point.pull[axis];
    }
    let centred = point.closest - offset;
    for (index, (i, j)) in TRIANGLE.into_iter().enumerate() {
        row[3 + index] = point.unit[i] * centred[j] * point.stretch;
    }
}

/// Derivatives of one sample's residual by the coefficients of terms.
fn term_rows<'t, 'a: 't>(
    terms: impl Iterator<Item = &'t Term<'a>>,
    sample: usize,
    point: &Point,
    offset: &Vector3<f64>,
    row: &mut [f64],
) {
    let mut at = point.quantities(offset);
    let mut shape = no_shape();
    let mut rest = row;
    for term in terms {
        term.write_shape(sample, &mut at, &mut shape);
        let (own, others) = rest.split_at_mut(term.k());
        for (entry, [x, y, z]) in own.iter_mut().zip(&shape) {
            *entry = -(point.lever.x * x + point.lever.y * y + point.lever.z * z);
        }
        rest = others;
    }
}

/// Columns of base and terms with the residual behind them, as block means.
pub fn rows(blocks: &Blocks, model: &Model, points: &[Point]) -> Vec<f64> {
    let width = model.columns() + 1;
    blocks.means(width, |sample, row| {
        let point = &points[sample];
        base_row(point, &model.offset, row);
        term_rows(model.terms.iter(), sample, point, &model.offset, &mut row[BASE..width - 1]);
        row[width - 1] = point.residual;
    })
}

/// Columns of candidates alone, as block means.
pub fn candidate_rows(blocks: &Blocks, model: &Model, points: &[Point], terms: &[&Term]) -> Vec<f64> {
    let width: usize = terms.iter().map(|term| term.k()).sum();
    blocks.means(width, |sample, row| {
        term_rows(terms.iter().copied(), sample, &points[sample], &model.offset, row);
    })
}
