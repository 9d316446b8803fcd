//! Where the study stands: sums are of a model made linear at a point, and are right as far as the truth is near it.
//!
//! The square of what the truth is away, over the field, is what a linear model does not see: a base that is 1 µT off where an
//! effect of 3 µT comes and goes makes some 0.1 µT. So the point moves to what the sums say: early on everything begins anew there,
//! later what was learned is kept, and what comes is looked at from the better point. An effect that stands out stands at the point
//! too, whatever is said of it in the end.

use super::candidate::Candidate;
use super::layout::{DRIFT, DRIFT_UNIT_MS, EFFECTS};
use super::learner::{EARLY_ROWS, Learner};
use super::point::BASE;
use super::solve::{Chosen, Factor};
use super::sums::WIDEST;
use crate::math;
use crate::study::rule::{NEARLY, RELEVANCE};

/// A point further than this from what the sums say, relative to the field, is left, and everything begins anew, while no more rows
/// than that would be lost with those that were lost so before: what is wrong for long is rather an effect.
const FAR: [(f32, u32); 3] = [(0.008, 400), (0.05, 1600), (0.25, u32::MAX)];
/// An effect may be as many times as far: it goes there only when its column does.
const EFFECT_SHARE: f32 = 0.5;
/// A point nearer than this is near enough.
const NEAR: f32 = 0.002;
/// No base is that far.
const ABSURD: f32 = 1.0;
/// The samples tell the base once its standard errors are this small, ...
const TOLD: f32 = 0.01;
/// ... and well enough to begin anew where they are so many times smaller than the way there.
const WELL_TOLD: f32 = 3.5;
/// The dip is of another direction once the base has moved by more than this.
const ANOTHER_DIRECTION: f32 = 0.01;
/// An effect stands out that takes so many variances off the squared error.
const STANDS_OUT: f32 = 60.0;
/// Its columns at their ends are known to this, relative to the field.
const EFFECT_TOLD: f32 = 0.004;

impl Learner {
    /// Looks whether the point is where the sums say, and moves there.
    pub(super) fn look(&mut self) {
        let Some(point) = self.point else { return };
        let work = self.total_here();
        let mut chosen = Chosen::base(BASE);
        for (index, theta) in self.carried.iter().enumerate() {
            if *theta != [0.0; 3] {
                chosen.add(DRIFT + 3 * index, 3);
            }
        }
        let mut open: [bool; EFFECTS + 1] = core::array::from_fn(|index| match self.carried.get(index) {
            Some(theta) => *theta == [0.0; 3],
            None => self.marks.has_step(work.rows),
        });
        // What stands out, one after the other.
        let factor = loop {
            let Some(factor) = Factor::of(&work, chosen, true) else { return };
            let left = factor.squares(&work);
            let least = (STANDS_OUT * left / work.rows as f32).max(RELEVANCE as f32 * left);
            // A logged cause, and a shape in time.
            let mut best: [Option<(f32, usize)>; 2] = [None; 2];
            for (index, _) in open.iter().enumerate().filter(|(_, open)| **open) {
                let gained = factor.test(&work, DRIFT + 3 * index, 3, index < EFFECTS).decrease;
                let is_in_time = index == 0 || index == EFFECTS;
                for best in best.iter_mut().skip(usize::from(is_in_time)).take(1) {
                    if gained > least && best.is_none_or(|(known, _)| gained > known) {
                        *best = Some((gained, index));
                    }
                }
            }
            // The cause stands before a shape that is hardly better.
            let best = match best {
                [Some(logged), Some(timed)]
                    if left - logged.0 > (NEARLY * NEARLY) as f32 * (left - timed.0) =>
                {
                    Some(timed)
                }
                [logged, timed] => logged.or(timed),
            };
            let Some((_, index)) = best else { break factor };
            chosen.add(DRIFT + 3 * index, 3);
            open.iter_mut().skip(index).take(1).for_each(|open| *open = false);
        };
        let mut delta = factor.step(&work);
        // Noise that has a memory tells less.
        let rows = work.rows as f32;
        let variance = factor.squares(&work) / rows.max(1.0);
        let time = self.memory.time(f64::from(variance), f64::from(rows), chosen.len() as f64) as f32;
        let error = factor.largest_error(&work) * math::sqrtf(time);
        // The jump keeps its columns: it is not at the point.
        delta.iter_mut().skip(DRIFT + 3 * EFFECTS).for_each(|value| *value = 0.0);
        let base = delta.iter().take(BASE).fold(0.0f32, |most, value| most.max(value.abs()));
        if base > ABSURD && error < TOLD {
            // Another sensor, or another place: from what a session finds.
            return self.reset();
        }
        // Where the samples do not tell it yet, it is where it was.
        if !(base < ABSURD && error < TOLD) {
            return;
        }
        let variance = variance * time;
        let mut far = base;
        for index in 0..EFFECTS {
            let (first, most) = (DRIFT + 3 * index, self.most(index));
            let three = || delta.iter().skip(first).take(3);
            let is_told = (first..first + 3)
                .all(|column| variance * factor.inverse(column) * most * most < EFFECT_TOLD * EFFECT_TOLD);
            if three().any(|value| *value != 0.0) && !is_told {
                delta.iter_mut().skip(first).take(3).for_each(|value| *value = 0.0);
            }
            let most = EFFECT_SHARE * most;
            far = delta.iter().skip(first).take(3).fold(far, |far, value| far.max(value.abs() * most));
        }
        if !(far > NEAR) {
            return;
        }
        let rotation = self.late.rotation;
        let lost = self.lost.saturating_add(work.rows);
        let is_far = FAR.into_iter().any(|(limit, rows)| {
            base.max(if lost <= EARLY_ROWS { far } else { 0.0 }) > limit && lost <= rows
        });
        // A jump is seen only with what was before it, and where the point is good.
        let is_jump = lost > EARLY_ROWS && self.marks.is_firm();
        if is_far && far > WELL_TOLD * error && !is_jump {
            self.carry(&delta);
            self.point = Some(point.stepped(&delta));
            self.late.begin(rotation);
            self.forget();
            self.lost = lost;
        } else if work.rows > EARLY_ROWS {
            self.shift(&delta, point.stepped(&delta));
            self.carry(&delta);
            if base > ANOTHER_DIRECTION {
                self.late.begin(rotation);
            }
        }
    }

    /// The effects at the point, moved.
    fn carry(&mut self, delta: &[f32; WIDEST]) {
        let carried = self.carried.as_flattened_mut().iter_mut();
        carried.zip(delta.iter().skip(DRIFT)).for_each(|(slot, value)| *slot += value);
    }

    /// The most that an effect's column was away from its first value.
    fn most(&self, index: usize) -> f32 {
        match Candidate::at(index) {
            Some(Candidate::Column(place)) => self.columns.get(usize::from(place)).map_or(0.0, |column| {
                let [least, most] = column.range();
                (most - column.first).max(column.first - least)
            }),
            _ => self.last_ms.saturating_sub(self.first_ms) as f32 / DRIFT_UNIT_MS,
        }
    }
}
