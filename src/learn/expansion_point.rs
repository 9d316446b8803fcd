//! Where the study stands: sums are of a model made linear at a point, and are right as far as the truth is near it.
//!
//! The square of what the truth is away, over the field, is what a linear model does not see: a base that is 1 µT off where an
//! effect of 3 µT comes and goes makes some 0.1 µT. So the point moves to what the sums say: early on everything begins anew there,
//! later what was learned is kept, and what comes is looked at from the better point. An effect that stands out stands at the point
//! too, whatever is said of it in the end.

use super::bounds::{
    ABSURD, ANOTHER_DIRECTION, EARLY_ROWS, EFFECT_SHARE, EFFECT_TOLD, FAR, NEAR, POINT_SCORE_FALL, TOLD,
    WELL_TOLD,
};
use super::candidate::{Candidate, Found};
use super::evidence::{Evidence, left};
use super::learner::Learner;
use super::point::BASE;
use super::sums::{DRIFT, DRIFT_UNIT_MS, EFFECTS, STEP, Solved, WIDEST, Work, inverse_diagonal, solved};
use crate::math;

impl Learner {
    /// Looks whether the point is where the sums say, and moves there.
    // Apart from a sample's way: its stack would be that of a sample too.
    #[inline(never)]
    pub(super) fn look(&mut self) {
        let Some((mut delta, far, error)) = self.step_to_the_sums() else { return };
        let Some(point) = self.point else { return };
        let base = delta.iter().take(BASE).fold(0.0f32, |most, value| most.max(value.abs()));
        if base > ABSURD && error < TOLD {
            // Another sensor, or another place: from what a session finds.
            return self.reset();
        }
        // Where the samples do not tell it yet, it is where it was.
        let far = far.max(base);
        if !(base < ABSURD && error < TOLD && far > NEAR) {
            return;
        }
        // The jump keeps its columns: it is not at the point.
        delta.iter_mut().skip(STEP).for_each(|value| *value = 0.0);
        let rotation = self.late.rotation;
        let rows = self.rows();
        let lost = self.lost.saturating_add(rows);
        let way = base.max(if lost <= EARLY_ROWS { far } else { 0.0 });
        let is_far = FAR.into_iter().any(|(limit, rows)| way > limit && lost <= rows);
        // A jump is seen only with what was before it, and where the point is good.
        let is_jump = lost > EARLY_ROWS && self.marks.is_firm();
        if is_far && far > WELL_TOLD * error && !is_jump {
            self.carry(&delta);
            self.point = Some(point.stepped(&delta));
            self.late.begin(rotation);
            self.forget();
            self.lost = lost;
        } else if rows > EARLY_ROWS {
            self.shift(&delta, point.stepped(&delta));
            self.carry(&delta);
            if base > ANOTHER_DIRECTION {
                self.late.begin(rotation);
            }
        }
    }

    /// The step from the point to what the sums say, how far that is for the effects, and the standard error of the base; of effects
    /// that are not told yet there is none.
    #[inline(never)]
    fn step_to_the_sums(&self) -> Option<([f32; WIDEST], f32, f32)> {
        let mut work = Work::EMPTY;
        self.marks.add_to(&self.blocks, &mut work);
        let rows = work.rows() as f32;
        let full = solved(&work, &|column| Found::EVERY.role(column))?;
        let parameters = full.directions;
        let variance = full.squares / (rows - parameters as f32).max(1.0);
        // Noise that has a memory tells less.
        let time = self.memory.time(f64::from(variance), f64::from(rows), parameters as f64) as f32;
        let set = self.standing_out(&work, &Evidence::new(work.rows(), 1.0, parameters, EFFECTS + 1));
        let Solved { step: mut delta, squares, .. } = solved(&work, &|column| set.role(column))?;
        let variance = squares / rows * time;
        let errors = inverse_diagonal(&work, &|column| set.role(column))?
            .map(|inverse| math::sqrtf(variance * inverse));
        let error = errors.iter().take(BASE).copied().fold(0.0, f32::max);
        let mut far = 0.0;
        for (index, three) in delta.get_mut(DRIFT..STEP)?.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let (first, most) = (DRIFT + 3 * index, self.most(index));
            let is_told = errors.iter().skip(first).take(3).all(|error| error * most < EFFECT_TOLD);
            if !is_told {
                *three = [0.0; 3];
            }
            far = three.iter().fold(far, |far: f32, value| far.max(value.abs() * EFFECT_SHARE * most));
        }
        Some((delta, far, error))
    }

    /// The effects at the point, and those that stand out, one after the other.
    fn standing_out(&self, work: &Work, evidence: &Evidence) -> Found {
        let is_open = |set: Found, one: Candidate| {
            !set.has(one) && one != Candidate::Lag && (one == Candidate::Drift || self.is_testable(one))
        };
        let mut set = Candidate::all()
            .zip(&self.carried)
            .filter(|(_, theta)| **theta != [0.0; 3])
            .fold(Found::none(), |set, (one, _)| set.with(one));
        let score = |set: Found| evidence.score(left(work, set), set);
        let mut without = score(set);
        loop {
            let mut best: Option<(f32, Candidate)> = None;
            for one in Candidate::all().filter(|one| is_open(set, *one)) {
                let with = score(set.with(one));
                if without - with > POINT_SCORE_FALL && best.is_none_or(|(least, _)| with < least) {
                    best = Some((with, one));
                }
            }
            let Some((with, one)) = best else { return set };
            (set, without) = (set.with(one), with);
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

    /// Holds each effect's column against its mean over the rows that are left once the oldest block is forgotten, the clock against
    /// where they begin. What was learned is the same, about the same model.
    ///
    /// Held against a value of long ago (a clock at power-up, the temperature of a cold start) a column would be nearly the offset's
    /// itself, and single precision would have no digits for the difference.
    #[inline(never)]
    pub(super) fn hold_against_what_is_left(&mut self) {
        // With every second block, so that both parts of a range reach as far back as the sums do, to within a block.
        self.is_odd = !self.is_odd;
        if !self.is_odd {
            self.columns.forget_ranges();
        }
        for effect in 0..EFFECTS {
            let [along, size] = self
                .blocks
                .iter()
                .map(|block| block.moment(effect))
                .fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
            let mean: f32 = along / size;
            let further = if effect == 0 {
                // The mean is in the middle. Whole units, so that the clock goes with it to the digit.
                let now = self.last_ms.saturating_sub(self.first_ms) as f32 / DRIFT_UNIT_MS;
                (2.0 * mean - now) as u32 as f32
            } else {
                mean
            };
            if !(further.is_finite() && further != 0.0) {
                continue;
            }
            match effect.checked_sub(1) {
                None => self.first_ms += (further * DRIFT_UNIT_MS) as u64,
                Some(place) => self.columns.hold_against(place, further),
            }
            self.blocks.iter_mut().for_each(|block| block.hold_against(effect, further));
            self.marks.hold_against(effect, further);
            self.move_by(effect, further);
        }
    }

    /// The point's offset takes what an effect at it does at a value so far from where its column was held against.
    pub(super) fn move_by(&mut self, effect: usize, value: f32) {
        if let (Some(point), Some(theta)) = (&mut self.point, self.carried.get(effect)) {
            for (offset, along) in point.offset_ut.iter_mut().zip(theta) {
                *offset += point.field_ut * along * value;
            }
        }
    }
}
