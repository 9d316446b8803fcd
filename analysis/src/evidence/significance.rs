//! Tests of candidates against a fit: the share of the residual that each explains, its p-value, and what it predicts.

use crate::base::term::Term;
use crate::evidence::design::{Point, candidate_rows};
use crate::evidence::fit::{Fit, Setting};
use crate::evidence::held_out::{changes, p_value};
use crate::evidence::solve::{Sums, taken_off};
use ironout::effect::Follows;
use ironout::study::f_tail;
use ironout::study::rule::{RELEVANCE, SIGNIFICANCE};
use nalgebra::{DMatrix, DVector};

/// Parts of the log that are predicted from the others.
const FOLDS: usize = 10;
/// Columns that are whitened at once.
const AT_ONCE: usize = 96;
/// What keeps directions regular that a log does not show, as a share of their own information.
const RIDGE: f64 = 1e-7;

/// The test of a candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    /// Its id.
    pub id: String,
    /// Its name.
    pub name: &'static str,
    /// What it goes by.
    pub follows: Follows,
    /// The columns that it reads.
    pub columns: Vec<String>,
    /// Whether a log may hold several of it.
    pub is_repeated: bool,
    /// Whether a share of it shows in the dip alone.
    pub hides_delay: bool,
    /// Where what was searched of it was found; zero where nothing was.
    pub parameter: f64,
    /// Share of the squared residual that it explains.
    pub share: f64,
    /// p-value, corrected for its own search but not for the number of candidates.
    pub p_value: f64,
    /// Rms of the held-out residual with it, µT.
    pub held_out_rms_ut: Option<f64>,
    /// Whether that is relevantly less than without it.
    pub falls: bool,
}

impl Test {
    /// What a test says before it is made.
    fn untested(term: &Term) -> Test {
        Test {
            id: term.id.clone(),
            name: term.effect.name(),
            follows: term.named().map_or(Follows::Column, |named| named.family.follows()),
            columns: term.effect.columns().iter().flatten().map(|column| column.name.to_string()).collect(),
            is_repeated: term.is_repeated(),
            hides_delay: term.visible() < term.k(),
            parameter: term.searched().map_or(0.0, |(_, parameter)| parameter),
            share: 0.0,
            p_value: 1.0,
            held_out_rms_ut: None,
            falls: false,
        }
    }
}

/// Rows `[columns of the model | of a candidate | residual]`.
fn joined(own: &[f64], width: usize, candidate: &[f64], (of, from, k): (usize, usize, usize)) -> Vec<f64> {
    let mut rows = Vec::with_capacity(own.len() / width * (width + k));
    for (own, candidate) in own.chunks_exact(width).zip(candidate.chunks_exact(of)) {
        rows.extend_from_slice(&own[..width - 1]);
        rows.extend_from_slice(&candidate[from..from + k]);
        rows.push(own[width - 1]);
    }
    rows
}

/// Sums with what is known of the model's own columns, the first of them, and a trace of information on the others.
fn with_known(mut sums: Sums, known: &Sums) -> Sums {
    let p = known.right.len();
    sums.squares += known.squares;
    for i in 0..p {
        sums.right[i] += known.right[i];
        for j in 0..p {
            sums.matrix[(i, j)] += known.matrix[(i, j)];
        }
    }
    for i in p..sums.right.len() {
        sums.matrix[(i, i)] *= 1.0 + RIDGE;
    }
    sums
}

/// Mean square of the residual of each part of the log when the columns are fitted to the others. `total`: sums of all rows, with what is
/// known. `None` where some part cannot be left out.
fn held_out_square(rows: &[f64], total: &Sums) -> Option<f64> {
    let columns = total.right.len();
    let n = rows.len() / (columns + 1);
    let fold = n.div_ceil(FOLDS).max(1);
    let folds: Vec<Sums> = rows.chunks(fold * (columns + 1)).map(|rows| Sums::of(rows, columns)).collect();
    let mut sum = 0.0;
    for fold in &folds {
        let rest =
            Sums { matrix: &total.matrix - &fold.matrix, right: &total.right - &fold.right, ..fold.clone() };
        let step = -rest.factor()?.solve(&rest.right);
        sum += fold.squares + 2.0 * fold.right.dot(&step) + step.dot(&(&fold.matrix * &step));
    }
    (sum.is_finite() && sum >= 0.0).then(|| sum / n as f64)
}

/// What is known besides the log of the columns of a fit, in sums of rows whose noise has this variance.
fn known_of(fit: &Fit, whitened: &[f64], variance: f64) -> Sums {
    let data = Sums::of(whitened, fit.model.columns());
    let share = variance / fit.noise.variance;
    Sums {
        matrix: (&fit.sums.matrix - data.matrix) * share,
        right: (&fit.sums.right - data.right) * share,
        squares: (fit.sums.squares - data.squares) * share,
        rows: 0,
    }
}

/// Tests each of these terms by itself beside a fit. Gives also the ids of terms whose shape is not finite.
pub fn tests(setting: &Setting, fit: &Fit, terms: &[Term]) -> (Vec<Test>, Vec<String>) {
    let (mut tests, mut dropped) = (Vec::new(), Vec::new());
    let p = fit.model.columns();
    let width = p + 1;
    let mut whitened = fit.rows.clone();
    fit.noise.whiten(&fit.track, width, &mut whitened);
    let plain_variance = fit.residual().iter().map(|r| r * r).sum::<f64>() / fit.track.weight.len() as f64;
    let known_plain = known_of(fit, &whitened, plain_variance.max(f64::MIN_POSITIVE));
    let known = known_of(fit, &whitened, fit.noise.variance);
    let whole_plain = with_known(Sums::of(&fit.rows, p), &known_plain);
    let before = held_out_square(&fit.rows, &whole_plain);
    let left_plain = whole_plain
        .factor()
        .map(|factor| whole_plain.squares - whole_plain.right.dot(&factor.solve(&whole_plain.right)));
    let mut from = 0;
    while from < terms.len() {
        let (mut to, mut columns) = (from, 0);
        while to < terms.len() && (to == from || columns + terms[to].k() <= AT_ONCE) {
            columns += terms[to].k();
            to += 1;
        }
        let batch: Vec<&Term> = terms[from..to].iter().collect();
        from = to;
        let z = candidate_rows(&setting.blocks, &fit.model, &fit.points, &batch);
        let mut z_whitened = z.clone();
        fit.noise.whiten(&fit.track, columns, &mut z_whitened);
        let mut at = 0;
        for term in batch {
            let k = term.k();
            let place = (columns, at, k);
            at += k;
            let plain = joined(&fit.rows, width, &z, place);
            if plain.iter().any(|value| !value.is_finite()) {
                dropped.push(term.id.clone());
                continue;
            }
            let white = joined(&whitened, width, &z_whitened, place);
            let all = with_known(Sums::of(&plain, p + k), &known_plain);
            let (taken, _) = taken(&all, p);
            let held_out = held_out_square(&plain, &all);
            tests.push(Test {
                share: left_plain.map_or(0.0, |left| (taken / left.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)),
                p_value: chance(&white, p, k, &known, term.trials, setting.candidates),
                held_out_rms_ut: held_out.map(f64::sqrt),
                falls: match (before, held_out) {
                    (Some(before), Some(after)) => after < before * (1.0 - RELEVANCE),
                    (None, after) => after.is_some(),
                    (Some(_), None) => false,
                },
                ..Test::untested(term)
            });
        }
    }
    (tests, dropped)
}

/// The test of a tone that a log is freed of, beside the fit that it stood out of.
pub fn of_tone(fit: &Fit, tone: &Term) -> Test {
    let left = |(sample, point): (usize, &Point)| {
        let by = tone.disturbance(sample, &point.quantities(&fit.model.offset));
        (point.residual - point.direction.dot(&by)).powi(2)
    };
    let share = (1.0 - fit.points.iter().enumerate().map(left).sum::<f64>() / fit.squares).clamp(0.0, 1.0);
    let (k, n) = (tone.k() as f64, fit.points.len() as f64);
    let freedom = (n - k - fit.model.columns() as f64).max(1.0);
    let f = share / (1.0 - share).max(f64::MIN_POSITIVE) * freedom / k;
    let p_value = (f_tail(f, k, freedom) * tone.trials).min(1.0);
    Test { share, p_value, held_out_rms_ut: None, falls: true, ..Test::untested(tone) }
}

/// Squares that the columns from `p` on take off, and of how many directions.
fn taken(sums: &Sums, p: usize) -> (f64, usize) {
    let k = sums.right.len() - p;
    let own = Sums {
        matrix: sums.matrix.view((0, 0), (p, p)).into_owned(),
        right: sums.right.rows(0, p).into_owned(),
        squares: sums.squares,
        rows: sums.rows,
    };
    let Some(factor) = own.factor() else { return (0.0, 0) };
    let cross: DMatrix<f64> = sums.matrix.view((0, p), (p, k)).into_owned();
    let step = -factor.solve(&own.right);
    let right = sums.right.rows(p, k) + cross.transpose() * step;
    let whole: DMatrix<f64> = sums.matrix.view((p, p), (k, k)).into_owned();
    let schur = &whole - cross.transpose() * factor.solve_all(&cross);
    taken_off(&schur, &right, &whole.diagonal())
}

/// p-value of the `k` columns from `p` on: the larger of that under the noise (F), and that by the spread of
/// the coefficients over parts of the log, whatever the noise. The second is looked at where it can matter.
fn chance(rows: &[f64], p: usize, k: usize, known: &Sums, places: f64, candidates: f64) -> f64 {
    let sums = with_known(Sums::of(rows, p + k), known);
    let (taken, directions) = taken(&sums, p);
    let freedom = sums.rows as f64 - (p + directions) as f64;
    if directions == 0 || freedom < 1.0 {
        return 1.0;
    }
    let Some(factor) = sums.factor() else { return 1.0 };
    let theta: DVector<f64> = -factor.solve(&sums.right);
    let left = (sums.squares + sums.right.dot(&theta)).max(f64::MIN_POSITIVE);
    let f = taken / directions as f64 / (left / freedom);
    let by_noise = (f_tail(f, directions as f64, freedom) * places).min(1.0);
    if by_noise * candidates >= SIGNIFICANCE {
        return by_noise;
    }
    let by_parts =
        changes(rows, p + k, &sums.matrix).map(|list| p_value(&list, p, &theta.rows(p, k).into_owned()));
    by_parts.map_or(by_noise, |p| (p * places).clamp(by_noise, 1.0))
}
