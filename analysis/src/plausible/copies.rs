//! Columns that are made of this sensor's field: copies of an axis, filtered or late, and magnitudes of them. They follow the error
//! because they contain it, so they are not a cause of it.
//!
//! A copy is a column that the field and its past explain almost wholly on parts of the log that the regression has not seen, in a log
//! that was turned in all directions. A cause is correlated with the field too, but there the turning is left over.

use crate::plausible::field::{self, Evidence};
use crate::table::Table;
use nalgebra::{DMatrix, DVector, Dyn, SymmetricEigen, Vector3};
use std::cell::OnceCell;

/// Share of a copy's variance that the field explains on held-out parts of the log.
const MIN_EXPLAINED: f64 = 0.99;
/// One column that explains more than this share of the variance of all three axes is their cause, not a copy of one.
const MAX_FIELD_EXPLAINED: f64 = 0.85;
/// Rows that are looked at; of a longer log every so many.
const MOST: usize = 4000;
/// Fewer rows say nothing.
const LEAST: usize = 40;
/// Parts of the log, each foretold from the others.
const PARTS: usize = 5;
/// Rows for each coefficient, at least.
const ROWS_PER_TERM: f64 = 2.0;
/// A magnitude that is copied repeats the noise of the field: what is left is below this share of that noise.
const MAX_NOISE_LEFT: f64 = 0.5;
/// Directions of the regressors that are less than this of the largest are not information.
const RANK: f64 = 1e-11;

/// How much of the past a regressor takes, in rows.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Past {
    /// So many rows before; negative: after.
    Shift(i32),
    /// Exponential mean with this time constant.
    Mean(f64),
}

/// In the order in which they are used: short logs carry few.
const PASTS: [Past; 16] = [
    Past::Shift(0),
    Past::Mean(4.0),
    Past::Mean(2.0),
    Past::Mean(8.0),
    Past::Mean(16.0),
    Past::Shift(1),
    Past::Mean(1.0),
    Past::Mean(32.0),
    Past::Shift(2),
    Past::Shift(-1),
    Past::Mean(64.0),
    Past::Shift(3),
    Past::Shift(5),
    Past::Shift(8),
    Past::Shift(-4),
    Past::Shift(16),
];

/// What a column is a copy of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CopyOf {
    /// An axis or a fixed mixture of axes.
    Field,
    /// The magnitude.
    Magnitude,
}

/// A column that is made of the field.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldCopy {
    /// Index into the covariates.
    pub covariate: usize,
    /// What it is a copy of.
    pub of: CopyOf,
    /// Whether the past of the field is needed to explain it.
    pub filtered: bool,
    /// Share of its variance that is explained on held-out parts of the log.
    pub explained: f64,
}

/// The covariates that are copies of the field.
pub fn field_copies(table: &Table) -> Vec<FieldCopy> {
    let rows = table.rows();
    let is_turned = || {
        field::evidence(table)
            .is_some_and(|found| matches!(found.evidence, Evidence::Sphere | Evidence::PartOfSphere))
    };
    if table.covariates.is_empty() || rows < LEAST || !is_turned() {
        return Vec::new();
    }
    let field = |row: usize| Vector3::from(table.field(row));
    let stride = rows.div_ceil(MOST).max(1);
    let chosen: Vec<usize> = (0..rows).step_by(stride).collect();
    let terms = (chosen.len() as f64 * (PARTS - 1) as f64 / PARTS as f64 / ROWS_PER_TERM) as usize;
    let pasts = PASTS.get(..(terms.saturating_sub(1) / 3).clamp(1, PASTS.len())).unwrap_or_default();
    let smoothed: Vec<Vec<Vector3<f64>>> =
        pasts.iter().map(|past| seen_through(field, rows, stride, *past)).collect();
    let now = axes_of(&smoothed, 1);
    let with_past = axes_of(&smoothed, pasts.len());
    let magnitudes = magnitudes_of(&smoothed);
    let own_noise = magnitude_noise(field, rows);
    let designs = [
        (CopyOf::Field, false, Design::new(now)),
        (CopyOf::Field, true, Design::new(with_past)),
        (CopyOf::Magnitude, false, Design::new(magnitudes.columns(0, 2).into_owned())),
        (CopyOf::Magnitude, true, Design::new(magnitudes)),
    ];
    let mut found = Vec::new();
    for (covariate, named) in table.covariates.iter().enumerate() {
        let values: Vec<f64> =
            chosen.iter().map(|&row| named.values.get(row).copied().unwrap_or(f64::NAN)).collect();
        if !varies(&values) {
            continue;
        }
        let copy = designs.iter().find_map(|(of, filtered, design)| {
            let predicted = design.foretell(&values)?;
            let repeats = *of == CopyOf::Field
                || predicted.left <= MAX_NOISE_LEFT * own_noise * noise_gain(pasts, &predicted.slopes);
            (predicted.explained >= MIN_EXPLAINED && repeats).then_some((*of, *filtered, predicted.explained))
        });
        let Some((of, filtered, explained)) = copy else { continue };
        if of == CopyOf::Field && explains_all_axes(field, &chosen, &values) {
            continue;
        }
        found.push(FieldCopy { covariate, of, filtered, explained });
    }
    found
}

/// Whether a column changes at all, and is known nearly everywhere.
fn varies(values: &[f64]) -> bool {
    let known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    let first = known.first().copied().unwrap_or(0.0);
    known.len() * 10 >= values.len() * 9 && known.iter().any(|value| *value != first)
}

/// The field as this past of it, at every `stride`th row.
fn seen_through(
    field: impl Fn(usize) -> Vector3<f64>,
    rows: usize,
    stride: usize,
    past: Past,
) -> Vec<Vector3<f64>> {
    match past {
        Past::Shift(by) => (0..rows)
            .step_by(stride)
            .map(|row| {
                let at = (row as i64 - i64::from(by)).clamp(0, rows as i64 - 1);
                field(usize::try_from(at).unwrap_or(0))
            })
            .collect(),
        Past::Mean(time_constant) => {
            let weight = 1.0 / (1.0 + time_constant);
            let mut mean = field(0);
            let means = (0..rows).map(|row| {
                mean += weight * (field(row) - mean);
                mean
            });
            means.step_by(stride).collect()
        }
    }
}

fn axes_of(smoothed: &[Vec<Vector3<f64>>], pasts: usize) -> DMatrix<f64> {
    let rows = smoothed.first().map_or(0, Vec::len);
    DMatrix::from_fn(rows, 1 + 3 * pasts, |row, term| match term.checked_sub(1) {
        None => 1.0,
        Some(term) => smoothed[term / 3][row][term % 3],
    })
}

fn magnitudes_of(smoothed: &[Vec<Vector3<f64>>]) -> DMatrix<f64> {
    let rows = smoothed.first().map_or(0, Vec::len);
    DMatrix::from_fn(rows, 1 + smoothed.len(), |row, term| match term.checked_sub(1) {
        None => 1.0,
        Some(term) => smoothed[term][row].norm(),
    })
}

/// Noise of the magnitude from one row to the next (1σ), from its second differences.
fn magnitude_noise(field: impl Fn(usize) -> Vector3<f64>, rows: usize) -> f64 {
    let square = |[a, b, c]: [f64; 3]| (a - 2.0 * b + c).powi(2) / 6.0;
    let mut squares: Vec<f64> = (2..rows)
        .map(|row| [field(row - 2), field(row - 1), field(row)])
        .filter(|rows| rows[0] != rows[1] && rows[1] != rows[2])
        .map(|rows| square([rows[0].norm(), rows[1].norm(), rows[2].norm()]))
        .collect();
    // The median of a square of one degree of freedom is 0.455 of its mean.
    (crate::samples::series::median(&mut squares) / 0.455).sqrt()
}

/// What a combination of pasts makes of white noise of one.
fn noise_gain(pasts: &[Past], slopes: &[f64]) -> f64 {
    const LENGTH: usize = 256;
    /// Rows after the present that the response holds.
    const AHEAD: i32 = 8;
    let mut response = vec![0.0; LENGTH];
    for (past, slope) in pasts.iter().zip(slopes) {
        match past {
            Past::Shift(rows) => {
                let at = usize::try_from(AHEAD + rows).ok().and_then(|at| response.get_mut(at));
                at.into_iter().for_each(|value| *value += slope);
            }
            Past::Mean(time_constant) => {
                let weight = 1.0 / (1.0 + time_constant);
                let tail = response.iter_mut().skip(AHEAD as usize).zip(0_i32..);
                tail.for_each(|(value, row)| *value += slope * weight * (1.0 - weight).powi(row));
            }
        }
    }
    response.iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// Whether the column explains nearly all that the field does: it is the field that follows the column.
fn explains_all_axes(field: impl Fn(usize) -> Vector3<f64>, chosen: &[usize], values: &[f64]) -> bool {
    let known: Vec<(Vector3<f64>, f64)> = chosen
        .iter()
        .zip(values)
        .filter(|(_, value)| value.is_finite())
        .map(|(row, value)| (field(*row), *value))
        .collect();
    let count = known.len().max(1) as f64;
    let mean = known.iter().map(|(field, _)| field).sum::<Vector3<f64>>() / count;
    let middle = known.iter().map(|(_, value)| value).sum::<f64>() / count;
    let (mut total, mut both, mut own) = (0.0, Vector3::zeros(), 0.0);
    for (field, value) in known {
        let (field, value) = (field - mean, value - middle);
        total += field.norm_squared();
        both += field * value;
        own += value * value;
    }
    own > 0.0 && both.norm_squared() / own > MAX_FIELD_EXPLAINED * total
}

/// What a regression says of a column.
struct Foretold {
    /// Share of the variance within the parts that the other parts foretell; the least of the parts' own.
    explained: f64,
    /// Rms of what is left.
    left: f64,
    /// Coefficients over the whole log, without the constant.
    slopes: Vec<f64>,
}

/// Regressors, each scaled to a mean square of one.
struct Design {
    terms: DMatrix<f64>,
    scale: Vec<f64>,
    /// The regressions without each part, and over the whole, for columns that are known everywhere.
    complete: OnceCell<Option<Vec<Solver>>>,
}

impl Design {
    fn new(mut terms: DMatrix<f64>) -> Self {
        let rows = terms.nrows().max(1) as f64;
        let mut scale = Vec::with_capacity(terms.ncols());
        for (index, mut column) in terms.column_iter_mut().enumerate() {
            if index > 0 {
                let mean = column.sum() / rows;
                column.add_scalar_mut(-mean);
            }
            let size = (column.norm_squared() / rows).sqrt();
            let size = if size > 0.0 { size } else { 1.0 };
            column.scale_mut(1.0 / size);
            scale.push(size);
        }
        Design { terms, scale, complete: OnceCell::new() }
    }

    fn foretell(&self, values: &[f64]) -> Option<Foretold> {
        let rows = self.terms.nrows();
        let known: Vec<bool> = values.iter().map(|value| value.is_finite()).collect();
        let parts: Vec<std::ops::Range<usize>> =
            (0..PARTS).map(|part| rows * part / PARTS..rows * (part + 1) / PARTS).collect();
        let rights: Vec<DVector<f64>> = parts.iter().map(|part| self.right(values, part.clone())).collect();
        let right = rights.iter().sum::<DVector<f64>>();
        let own;
        let solvers = if known.iter().all(|known| *known) {
            self.complete.get_or_init(|| self.solvers(&known, &parts)).as_ref()?
        } else {
            own = self.solvers(&known, &parts)?;
            &own
        };
        let (whole, without) = solvers.split_last()?;
        let (mut left, mut total, mut count, mut worst) = (0.0, 0.0, 0.0, 1.0_f64);
        for ((part, own), solver) in parts.iter().zip(&rights).zip(without) {
            let predicted = self.terms.rows(part.start, part.len()) * solver.solve(&(&right - own));
            let held = || part.clone().filter(|row| known[*row]);
            let n = held().count().max(1) as f64;
            let mean = held().map(|row| values[row]).sum::<f64>() / n;
            let spread: f64 = held().map(|row| (values[row] - mean).powi(2)).sum();
            let missed: f64 = held().map(|row| (values[row] - predicted[row - part.start]).powi(2)).sum();
            (left, total, count) = (left + missed, total + spread, count + n);
            // A part in which the column hardly moves tells nothing of it.
            if spread > 0.0 {
                worst = worst.min(1.0 - missed / spread);
            }
        }
        let explained = 1.0 - left / total;
        // Explained on average, and nowhere missed: what follows time only in one part is not a copy.
        let explained = if worst >= 2.0 * MIN_EXPLAINED - 1.0 { explained } else { explained.min(worst) };
        let slopes = whole.solve(&right);
        let slopes = slopes.iter().zip(&self.scale).skip(1).map(|(slope, scale)| slope / scale).collect();
        explained.is_finite().then(|| Foretold { explained, left: (left / count).sqrt(), slopes })
    }

    /// Products of the regressors with a column over a part of the rows.
    fn right(&self, values: &[f64], part: std::ops::Range<usize>) -> DVector<f64> {
        let known = |value: &f64| if value.is_finite() { *value } else { 0.0 };
        let column = DVector::from_iterator(part.len(), values[part.clone()].iter().map(known));
        self.terms.rows(part.start, part.len()).tr_mul(&column)
    }

    /// The regressions without each part, and behind them that over all parts.
    fn solvers(&self, known: &[bool], parts: &[std::ops::Range<usize>]) -> Option<Vec<Solver>> {
        let normal = |part: &std::ops::Range<usize>| {
            let rows: Vec<usize> = part.clone().filter(|row| known[*row]).collect();
            let terms = self.terms.select_rows(&rows);
            terms.tr_mul(&terms)
        };
        let normals: Vec<DMatrix<f64>> = parts.iter().map(normal).collect();
        let whole = normals.iter().sum::<DMatrix<f64>>();
        let mut solvers: Vec<Solver> =
            normals.iter().map(|own| Solver::of(&whole - own)).collect::<Option<_>>()?;
        solvers.push(Solver::of(whole)?);
        Some(solvers)
    }
}

/// Least squares; directions without information are left at zero.
struct Solver(SymmetricEigen<f64, Dyn>);

impl Solver {
    fn of(normal: DMatrix<f64>) -> Option<Self> {
        let eigen = normal.symmetric_eigen();
        let most = eigen.eigenvalues.max();
        (most.is_finite() && most > 0.0).then_some(Solver(eigen))
    }

    fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let Solver(eigen) = self;
        let most = eigen.eigenvalues.max();
        let mut along = eigen.eigenvectors.tr_mul(right);
        along.iter_mut().zip(eigen.eigenvalues.iter()).for_each(|(value, own)| {
            *value = if *own > RANK * most { *value / own } else { 0.0 };
        });
        &eigen.eigenvectors * along
    }
}
