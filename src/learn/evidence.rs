//! The score that compares sets of effects, as the host's does (docs/method.md, section 3).

use super::blocks::BLOCKS;
use super::bounds::{JUMP_PLACES, JUMP_PLACES_PRICE, MIN_SCORE_FALL, MIN_SHARE, MIN_SHARE_ELSEWHERE};
use super::candidate::{Candidate, Found};
use super::learner::Learner;
use super::sums::{self, Work, solved};
use crate::math;
use crate::study::{Role, f_tail};

/// Coefficients of an effect of the magnitude.
const COEFFICIENTS: f64 = 3.0;

/// The squared residual that a model with these effects leaves; NaN of one that is not determined.
pub(super) fn left(total: &Work, set: Found) -> f32 {
    sums::left(total, &|column| set.role(column)).unwrap_or(f32::NAN)
}

/// The same on blocks of time that were not fitted; NaN where one is not predicted.
#[inline(never)]
pub(super) fn held_out(learner: &Learner, set: Found) -> f32 {
    let mut total = Work::EMPTY;
    learner.add_to(&mut total);
    // About the fit to all: what the others do not tell of an effect stays as it is there.
    let Some(all) = solved(&total, &|column| set.role(column)) else { return f32::NAN };
    total.shift(&all.step);
    let mut squares = 0.0;
    for index in 0..BLOCKS {
        let mut own = Work::EMPTY;
        learner.add_part_to(index, &mut own);
        own.shift(&all.step);
        total.take_out(&own);
        let rest = solved(&total, &|column| match set.role(column) {
            Role::Optional(least) => {
                let own = all.own.get(column).copied().unwrap_or(0.0);
                Role::Optional(least.max(MIN_SHARE_ELSEWHERE * own / total.entry(column, column)))
            }
            role => role,
        });
        squares += rest.map_or(f32::NAN, |rest| own.squares_after(&rest.step).max(0.0));
        total.merge(&own);
    }
    squares
}

/// Whether an effect is likely and relevant: by how far the score falls, and by the squared residual without it and with it.
pub(super) fn is_worth(fall: f32, [without, with]: [f32; 2]) -> bool {
    fall > MIN_SCORE_FALL && without - with > MIN_SHARE * without
}

/// Whether blocks of time that were not fitted bear an effect out, by their squared residual without it and with it.
pub(super) fn holds([without, with]: [f32; 2]) -> bool {
    // Without it some block is not predicted at all, perhaps.
    with < without || without.is_nan()
}

/// The samples as evidence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evidence {
    /// Independent ones among them, less the parameters of the largest model.
    samples: f64,
    /// Effects that are tested.
    candidates: f64,
    /// What a coefficient has to be paid with, and the choice among the effects.
    per_coefficient: f64,
    choice: f64,
}

impl Evidence {
    /// Of so many samples, `time` of which count as one.
    pub(super) fn new(rows: u32, time: f64, parameters: usize, candidates: usize) -> Self {
        let samples = (f64::from(rows) / time - parameters as f64).max(1.0);
        let candidates = candidates.max(1) as f64;
        Self { samples, candidates, per_coefficient: math::ln(samples), choice: 2.0 * math::ln(candidates) }
    }

    fn places(candidate: Candidate) -> f64 {
        if candidate == Candidate::Step { JUMP_PLACES } else { 1.0 }
    }

    /// `−2 log L`, the noise estimated with the model, and the prices of its effects.
    pub(super) fn score(&self, squares: f32, set: Found) -> f32 {
        let price = set.len() as f64 * (COEFFICIENTS * self.per_coefficient + self.choice);
        let places = if set.has(Candidate::Step) { JUMP_PLACES_PRICE } else { 0.0 };
        (self.samples * math::ln(f64::from(squares)) + price + places) as f32
    }

    /// How far the score falls with an effect of so many coefficients, by the squared residual without it and with it.
    pub(super) fn fall(&self, [without, with]: [f32; 2], coefficients: f64) -> f32 {
        let likelihood = self.samples * math::ln(f64::from(without) / f64::from(with));
        (likelihood - coefficients * self.per_coefficient - self.choice) as f32
    }

    /// Probability that chance takes as much off, everything tested counted.
    pub(super) fn p_value(&self, [without, with]: [f32; 2], coefficients: f64, places: f64) -> f64 {
        let f = (f64::from(without) / f64::from(with) - 1.0) * self.samples / coefficients;
        (f_tail(f, coefficients, self.samples) * places * self.candidates).min(1.0)
    }

    /// [`Evidence::p_value`] of an effect of the magnitude.
    pub(super) fn chance(&self, squares: [f32; 2], candidate: Candidate) -> f32 {
        self.p_value(squares, COEFFICIENTS, Self::places(candidate)) as f32
    }
}
