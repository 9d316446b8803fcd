//! What candidates would gain: their columns through the same filter as the model's, which stay free.

use crate::base::term::Term;
use crate::evidence::design::{Blocks, candidate_rows};
use crate::evidence::fit::Fit;
use crate::evidence::log::Log;
use crate::evidence::solve::{Factor, Sums, taken_off};
use crate::noise::model::Noise;
use nalgebra::{DMatrix, DVector};

/// Columns that are whitened at once.
const AT_ONCE: usize = 96;

/// Columns of candidates that cost as much as one look at a sample.
const COLUMNS_OF_A_LOOK: usize = 6;

/// A fit under one noise, ready for candidates.
pub struct Screen<'l, 'a> {
    log: &'l Log<'a>,
    noise: Noise,
    whitened: Vec<f64>,
    width: usize,
    sums: Sums,
    factor: Factor,
    step: DVector<f64>,
    /// Squares that are left when the model's own columns have taken what they can.
    squares: f64,
    blocks: Blocks,
}

impl<'l, 'a> Screen<'l, 'a> {
    /// Of a fit under its own noise, or under white noise: the wander may have taken a cause for itself.
    pub fn new(log: &'l Log<'a>, fit: &Fit, blocks: Blocks, white: bool) -> Option<Self> {
        let noise = if white { Noise::white(&fit.track, &fit.residual()) } else { fit.noise.clone() };
        let width = fit.model.columns() + 1;
        let mut whitened = fit.rows.clone();
        noise.whiten(&fit.track, width, &mut whitened);
        let mut sums = Sums::of(&whitened, width - 1);
        // The priors are those of the fit.
        let own = &fit.sums.matrix;
        if !white {
            sums.matrix.copy_from(own);
            sums.right.copy_from(&fit.sums.right);
        }
        let factor = sums.factor()?;
        let step = -factor.solve(&sums.right);
        let squares = sums.squares + sums.right.dot(&step);
        Some(Screen { log, noise, whitened, width, sums, factor, step, squares, blocks })
    }

    /// Mean time between blocks, s.
    pub fn block_s(&self) -> f64 {
        self.log.step_s() * self.blocks.size as f64
    }

    /// The residual, whitened.
    pub fn residual(&self) -> Vec<f64> {
        self.whitened.chunks_exact(self.width).map(|row| row[self.width - 1]).collect()
    }

    /// Gain of −2 log likelihood of each candidate, its coefficients free.
    pub fn gains(&self, fit: &Fit, terms: &[&Term]) -> Vec<f64> {
        let mut gains = Vec::with_capacity(terms.len());
        let mut from = 0;
        while from < terms.len() {
            let (mut to, mut width) = (from, 0);
            while to < terms.len() && (to == from || width + terms[to].k() <= AT_ONCE) {
                width += terms[to].k();
                to += 1;
            }
            self.some(fit, &terms[from..to], width, &mut gains);
            from = to;
        }
        gains
    }

    fn some(&self, fit: &Fit, terms: &[&Term], width: usize, gains: &mut Vec<f64>) {
        self.log.look((self.blocks.samples * width).div_ceil(COLUMNS_OF_A_LOOK));
        let mut z = candidate_rows(&self.blocks, &fit.model, &fit.points, terms);
        self.noise.whiten(&fit.track, width, &mut z);
        let p = self.width - 1;
        // Products with the model's columns and the residual, and of each candidate with itself.
        let mut cross = vec![0.0; self.width * width];
        let ks: Vec<usize> = terms.iter().map(|term| term.k()).collect();
        let mut squares = vec![0.0; ks.iter().map(|k| k * k).sum()];
        for (row, z) in self.whitened.chunks_exact(self.width).zip(z.chunks_exact(width)) {
            for (i, &a) in row.iter().enumerate() {
                let line = &mut cross[i * width..][..width];
                line.iter_mut().zip(z).for_each(|(entry, z)| *entry += a * z);
            }
            let (mut z, mut squares) = (z, squares.as_mut_slice());
            for &k in &ks {
                let (own, others) = z.split_at(k);
                let (square, rest) = squares.split_at_mut(k * k);
                for (line, a) in square.chunks_exact_mut(k).zip(own) {
                    line.iter_mut().zip(own).for_each(|(entry, b)| *entry += a * b);
                }
                (z, squares) = (others, rest);
            }
        }
        let n = self.sums.rows as f64;
        let (mut at, mut from) = (0, 0);
        for k in ks {
            let a = DMatrix::from_fn(p, k, |i, j| cross[i * width + at + j]);
            let own = DMatrix::from_row_slice(k, k, &squares[from..from + k * k]);
            from += k * k;
            let right = DVector::from_fn(k, |j, _| cross[p * width + at + j]) + a.transpose() * &self.step;
            let schur = &own - a.transpose() * self.factor.solve_all(&a);
            let (taken, _) = taken_off(&schur, &right, &own.diagonal());
            let left = (self.squares - taken).max(1e-9 * self.squares);
            let gain = n * (self.squares / left).ln();
            gains.push(if gain.is_finite() { gain } else { 0.0 });
            at += k;
        }
    }
}
