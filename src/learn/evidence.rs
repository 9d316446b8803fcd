//! The score that compares sets of effects, as the host's does (docs/method.md, section 3).

use super::blocks::BLOCKS;
use super::bounds::{JUMP_PLACES, MIN_SCORE_FALL, MIN_SHARE, MIN_SHARE_ELSEWHERE};
use super::candidate::{Candidate, Found};
use super::learner::Learner;
use super::point::BASE;
use super::sums::{WIDEST, Work};
use crate::math;
use crate::study::{Role, f_tail};

/// Coefficients of an effect of the magnitude.
const COEFFICIENTS: f64 = 3.0;

/// What a model leaves of the samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Squared residual; NaN of a model that is not determined.
    pub(super) squares: f32,
    /// The same on blocks of time that were not fitted.
    pub(super) held_out: f32,
}

impl Fit {
    pub(super) const NONE: Self = Self { squares: f32::NAN, held_out: f32::NAN };

    /// Of all samples, with these effects.
    pub(super) fn of(learner: &Learner, set: Found) -> Self {
        let mut total = learner.total();
        let squares = left(&total, set);
        let sizes: [f32; WIDEST] = core::array::from_fn(|column| total.entry(column, column));
        let mut held_out = 0.0;
        for index in 0..BLOCKS {
            let Some(own) = learner.part(index) else { continue };
            total.take_out(&own);
            // Of an effect that hardly was elsewhere, the others say nothing.
            let is_left = |column: usize| {
                let size = sizes.get(column).copied().unwrap_or(0.0);
                column < BASE || total.entry(column, column) > MIN_SHARE_ELSEWHERE * size
            };
            let roles = set.roles();
            let rest = |column: usize| if is_left(column) { roles(column) } else { Role::Absent };
            held_out += match total.partial_factor(rest) {
                Some(factor) => own.squares_after(&total.step(&factor)).max(0.0),
                None => f32::NAN,
            };
            total.merge(&own);
        }
        Self { squares, held_out }
    }
}

/// The squared residual that a model with these effects leaves.
#[inline(never)]
pub(super) fn left(total: &Work, set: Found) -> f32 {
    total.partial_factor(set.roles()).map_or(f32::NAN, |factor| factor.squares(total))
}

/// The samples as evidence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evidence {
    /// Independent ones among them, less the parameters of the largest model.
    pub(super) samples: f64,
    /// Effects that are tested.
    pub(super) candidates: usize,
}

impl Evidence {
    /// Of so many samples, `time` of which count as one.
    pub(super) fn new(rows: u32, time: f64, parameters: usize, candidates: usize) -> Self {
        Self { samples: (f64::from(rows) / time - parameters as f64).max(1.0), candidates }
    }

    /// What a coefficient, and the choice among `places`, have to be paid with.
    fn price(&self, coefficients: f64, places: f64) -> f64 {
        coefficients * math::ln(self.samples) + 2.0 * math::ln(places * self.candidates.max(1) as f64)
    }

    fn places(candidate: Candidate) -> f64 {
        if candidate == Candidate::Step { JUMP_PLACES } else { 1.0 }
    }

    /// `−2 log L`, the noise estimated with the model, and the prices of its effects.
    pub(super) fn score(&self, squares: f32, set: Found) -> f64 {
        let price = set.iter().map(|one| self.price(COEFFICIENTS, Self::places(one))).sum::<f64>();
        self.samples * math::ln(f64::from(squares)) + price
    }

    /// Whether an effect of so many coefficients is likely, relevant, and holds on blocks of time that were not fitted.
    pub(super) fn is_worth(&self, without: Fit, with: Fit, coefficients: f64, places: f64) -> bool {
        let fall = self.samples * math::ln(f64::from(without.squares) / f64::from(with.squares));
        fall - self.price(coefficients, places) > MIN_SCORE_FALL
            && without.squares - with.squares > MIN_SHARE * without.squares
            // Without it some block cannot be predicted at all, perhaps.
            && (with.held_out < without.held_out || without.held_out.is_nan())
    }

    /// [`Evidence::is_worth`] of an effect of the magnitude.
    pub(super) fn supports(&self, without: Fit, with: Fit, candidate: Candidate) -> bool {
        self.is_worth(without, with, COEFFICIENTS, Self::places(candidate))
    }

    /// Probability that chance takes as much off, everything tested counted.
    pub(super) fn p_value(&self, without: Fit, with: Fit, coefficients: f64, places: f64) -> f64 {
        let f = (f64::from(without.squares) / f64::from(with.squares) - 1.0) * self.samples / coefficients;
        (f_tail(f, coefficients, self.samples) * places * self.candidates.max(1) as f64).min(1.0)
    }

    /// [`Evidence::p_value`] of an effect of the magnitude.
    pub(super) fn chance(&self, without: Fit, with: Fit, candidate: Candidate) -> f32 {
        self.p_value(without, with, COEFFICIENTS, Self::places(candidate)) as f32
    }
}
