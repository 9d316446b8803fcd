//! The two figures of a candidate: its held-out error, and what chance does.

use super::blocks::BLOCKS;
use super::learner::Learner;
use super::solve::{Chosen, Factor, Gained};
use crate::study::f_tail;

/// Squared error on blocks of time that were not fitted.
pub(super) fn held_out(learner: &Learner, chosen: Chosen) -> Option<f32> {
    let mut rest = learner.total();
    let mut squares = 0.0;
    for index in 0..BLOCKS {
        let Some(own) = learner.part(index) else { continue };
        rest.take_out(&own);
        let delta = Factor::of(&rest, chosen, true)?.step(&rest);
        rest.merge(&own);
        squares += own.squares_after(&delta).max(0.0);
    }
    Some(squares)
}

/// Probability that chance takes as much off, for noise of this variance of which so many samples count as one.
pub(super) fn chance(gained: &Gained, variance: f64, time: f64, rows: u32, parameters: usize) -> f64 {
    if gained.directions == 0 || variance <= 0.0 {
        return 1.0;
    }
    let k = f64::from(gained.directions);
    let f = f64::from(gained.decrease) / k / variance / time;
    f_tail(f, k, f64::from(rows) / time - parameters as f64 - k)
}
