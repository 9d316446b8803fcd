//! The question which effect is missing, answered in steps so small that no sample waits.
//!
//! Every set of effects is fitted, and the set is taken that the samples support most: each of its effects has to be worth its price
//! next to the others ([`Evidence`]), and to hold on blocks of time that were not fitted. What would do as well in the place of one of
//! them cannot be told from it.

use super::bounds::{
    COLUMN_ERROR, LEAST_ROWS, MOST_BASE_ERROR, NOISE_SIGMAS, RIVAL_SCORE_FALL, STRUCTURE_SHARE,
};
use super::candidate::{CANDIDATES, Candidate, Found, SETS};
use super::evidence::{Evidence, held_out, holds, is_worth, left};
use super::finding::{Finding, InUse, NOTHING, Outcome, Status, Verdict};
use super::lateness::Lateness;
use super::learner::Learner;
use super::point::BASE;
use super::sums::{Work, inverse_diagonal};
use crate::math;
use crate::study::rule::NEARLY;

/// Sets that are fitted in one step.
const AT_ONCE: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Begin,
    /// Sets from this number on are fitted.
    Fit(u8),
    Conclude,
    Dip,
    End,
}

/// A set whose held-out error is not known yet.
type Unknown = Found;

fn sets() -> impl Iterator<Item = Found> {
    (0..SETS as u8).map(Found::numbered)
}

/// A question under way. Its answer is of one moment where the learner takes no samples meanwhile; those that it takes move it by what
/// they say, and where it began anew, so does the question.
#[derive(Clone, Debug)]
pub struct Inquiry {
    stage: Stage,
    epoch: u16,
    in_use: InUse,
    /// Candidates that can be tested, and those in every model.
    testable: Found,
    used: Found,
    evidence: Evidence,
    /// Squared residual with each set of effects, NaN of one that is no model; and on blocks of time that were not fitted, where that was
    /// asked for.
    squares: [f32; SETS],
    scores: [f32; SETS],
    held_out: [Option<f32>; SETS],
    outcome: Outcome,
}

impl Inquiry {
    /// A question; `in_use` are the coefficients of the effects in the calibration in use.
    pub fn new(learner: &Learner, in_use: InUse) -> Self {
        Self {
            stage: Stage::Begin,
            epoch: learner.epoch,
            in_use,
            testable: Found::none(),
            used: Found::none(),
            evidence: Evidence::new(0, 1.0, 0, 0),
            squares: [f32::NAN; SETS],
            scores: [f32::NAN; SETS],
            held_out: [None; SETS],
            outcome: Outcome {
                verdict: Verdict::Undetermined,
                rows: 0,
                rms_ut: f32::NAN,
                holdout_rms_ut: f32::NAN,
                floor_ut: f32::NAN,
                base_error: f32::NAN,
                dip_rms_deg: f32::NAN,
                late_by_turning: false,
                findings: [NOTHING; CANDIDATES],
            },
        }
    }

    /// Does one piece of work; the answer once all is done.
    #[inline(never)]
    pub fn step(&mut self, learner: &Learner) -> Option<Outcome> {
        if self.epoch != learner.epoch {
            *self = Self::new(learner, self.in_use);
        }
        self.stage = match self.stage {
            Stage::Begin => self.begin(learner),
            Stage::Fit(first) => self.fit(learner, first),
            Stage::Conclude => match self.conclude(learner) {
                Ok(()) => Stage::Dip,
                Err(set) => {
                    if let Some(slot) = self.held_out.get_mut(set.number()) {
                        *slot = Some(held_out(learner, set));
                    }
                    Stage::Conclude
                }
            },
            Stage::Dip => self.dip(learner),
            Stage::End => return Some(self.outcome),
        };
        None
    }

    fn ut(&self, learner: &Learner, squares: f32) -> f32 {
        let field = learner.point.map_or(f32::NAN, |point| point.field_ut);
        math::sqrtf(squares.max(0.0) / learner.rows().max(1) as f32) * field
    }

    fn finding(&mut self, candidate: Candidate) -> Option<&mut Finding> {
        self.outcome.findings.get_mut(candidate.place())
    }

    /// Whether there is enough; how much noise there is.
    #[inline(never)]
    fn begin(&mut self, learner: &Learner) -> Stage {
        let rows = learner.rows();
        self.outcome.rows = rows;
        if rows < LEAST_ROWS {
            return Stage::End;
        }
        for candidate in Candidate::all() {
            if self.in_use.get(candidate.place()).is_some_and(Option::is_some) {
                // One whose columns are not here is only taken off.
                if learner.is_studied(candidate) {
                    self.used = self.used.with(candidate);
                }
                if let Some(finding) = self.finding(candidate) {
                    finding.status = Status::InUse;
                }
            } else if learner.is_testable(candidate) {
                self.testable = self.testable.with(candidate);
            }
        }
        let mut total = Work::EMPTY;
        learner.add_to(&mut total);
        let all = self.testable.iter().fold(self.used, Found::with);
        let parameters = BASE + 3 * all.len();
        let variance = f64::from(left(&total, all)) / (f64::from(rows) - parameters as f64).max(1.0);
        if !(variance > 0.0) {
            // The base is not told, or all digits are used up: of such sums nothing can be said.
            return Stage::End;
        }
        let time = learner.memory.time(variance, f64::from(rows), parameters as f64);
        self.evidence = Evidence::new(rows, time, parameters, self.testable.len());
        let field = learner.point.map_or(f64::NAN, |point| f64::from(point.field_ut));
        self.outcome.floor_ut =
            (math::sqrt(learner.memory.noise(variance, f64::from(rows)).0) * field) as f32;
        let none = |column| Found::none().role(column);
        let Some(inverse) = inverse_diagonal(&total, &none) else { return Stage::End };
        let largest = inverse.into_iter().fold(0.0, f32::max);
        self.outcome.base_error = math::sqrtf(largest * (variance * time) as f32);
        if self.outcome.base_error > MOST_BASE_ERROR {
            return Stage::End;
        }
        Stage::Fit(0)
    }

    /// Fits the next sets, of those that hold all in use and nothing that cannot be tested.
    #[inline(never)]
    fn fit(&mut self, learner: &Learner, first: u8) -> Stage {
        let mut total = Work::EMPTY;
        learner.add_to(&mut total);
        let all = self.testable.iter().fold(self.used, Found::with);
        let slots = self.squares.iter_mut().zip(&mut self.scores);
        for (set, (squares, score)) in sets().zip(slots).skip(usize::from(first)).take(AT_ONCE) {
            if self.used.less(set).is_empty() && set.less(all).is_empty() {
                *squares = left(&total, set);
                *score = self.evidence.score(*squares, set);
            }
        }
        let next = first + AT_ONCE as u8;
        if usize::from(next) < SETS {
            return Stage::Fit(next);
        }
        self.say_in_use(learner, &mut total);
        Stage::Conclude
    }

    fn squares(&self, set: Found) -> f32 {
        self.squares.get(set.number()).copied().unwrap_or(f32::NAN)
    }

    fn held_out(&self, set: Found) -> Result<f32, Unknown> {
        self.held_out.get(set.number()).copied().flatten().ok_or(set)
    }

    fn score(&self, set: Found) -> f32 {
        self.scores.get(set.number()).copied().unwrap_or(f32::NAN)
    }

    /// Whether an effect is worth its price next to others, and holds.
    fn supports(&self, others: Found, candidate: Candidate) -> Result<bool, Unknown> {
        let [without, with] = [others, others.with(candidate)];
        let fall = self.score(without) - self.score(with);
        Ok(is_worth(fall, [self.squares(without), self.squares(with)])
            && holds([self.held_out(without)?, self.held_out(with)?]))
    }

    /// The likeliest set of effects each of which is worth its price.
    fn best(&self) -> Result<Found, Unknown> {
        let mut refused = f32::NEG_INFINITY;
        loop {
            // NaN, of a set that was not fitted, is no score.
            let open = sets().filter(|set| self.score(*set) > refused);
            let better = |a: Found, b: Found| if self.score(b) < self.score(a) { b } else { a };
            let Some(set) = open.reduce(better).filter(|set| *set != self.used) else { return Ok(self.used) };
            if self.is_supported(set)? {
                return self.logged_before(set);
            }
            refused = self.score(set);
        }
    }

    fn is_supported(&self, set: Found) -> Result<bool, Unknown> {
        for one in set.less(self.used).iter() {
            if !self.supports(set.without(one), one)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// A set, or the likeliest one with logged causes in the place of shapes in time that are hardly better.
    fn logged_before(&self, set: Found) -> Result<Found, Unknown> {
        let shapes = Found::none().with(Candidate::Drift).with(Candidate::Step);
        let better = |a: Found, b: Found| if self.score(b) < self.score(a) { b } else { a };
        let is_hardly_worse = |other: &Found| {
            other.less(shapes).len() > set.less(shapes).len()
                && shapes.less(*other).len() > shapes.less(set).len()
                && self.squares(*other) < (NEARLY * NEARLY) as f32 * self.squares(set)
        };
        let Some(other) = sets().filter(is_hardly_worse).reduce(better) else { return Ok(set) };
        Ok(if self.is_supported(other)? { other } else { set })
    }

    /// The findings, or the set whose held-out error they need.
    #[inline(never)]
    fn conclude(&mut self, learner: &Learner) -> Result<(), Unknown> {
        let best = self.best()?;
        self.outcome.holdout_rms_ut = self.ut(learner, self.held_out(self.used)?);
        let (added, left) = (best.less(self.used), self.testable.less(best));
        for one in left.iter() {
            self.say(learner, best, one, Status::NotNeeded, 0)?;
        }
        self.outcome.verdict = if added.is_empty() { Verdict::Complete } else { Verdict::Missing };
        // By what each explains beyond those before it.
        let (mut set, mut order) = (self.used, 0);
        while let Some(next) = best
            .less(set)
            .iter()
            .reduce(|a, b| if self.score(set.with(b)) < self.score(set.with(a)) { b } else { a })
        {
            order += 1;
            self.say(learner, set, next, Status::Missing, order)?;
            set = set.with(next);
        }
        for one in added.iter() {
            let others = best.without(one);
            let mut partners = Found::none();
            for other in left.iter() {
                if self.is_rival(others, one, other)? {
                    partners = partners.with(other);
                }
            }
            for partner in partners.iter() {
                self.say(learner, others, partner, Status::Confounded, 0)?;
                if let Some(finding) = self.finding(partner) {
                    finding.partners = partners.with(one).without(partner);
                }
            }
            if !partners.is_empty()
                && let Some(finding) = self.finding(one)
            {
                (finding.status, finding.partners) = (Status::Confounded, partners);
                self.outcome.verdict = Verdict::Confounded;
            }
        }
        // What the final model leaves beyond noise.
        let rows = f64::from(learner.rows());
        let variance = f64::from(self.squares(best)) / (rows - (BASE + 3 * best.len()) as f64).max(1.0);
        let (noise, error) = learner.memory.noise(variance, rows);
        let most = (1.0 - STRUCTURE_SHARE - NOISE_SIGMAS * error) * variance;
        if noise < most && self.outcome.verdict != Verdict::Confounded {
            self.outcome.verdict = Verdict::Unexplained;
        }
        Ok(())
    }

    /// Whether another effect explains what one does, next to the others.
    fn is_rival(&self, others: Found, one: Candidate, other: Candidate) -> Result<bool, Unknown> {
        let (mine, its) = (others.with(one), others.with(other));
        let [left, my_left, its_left] = [others, mine, its].map(|set| self.squares(set));
        Ok((self.score(its) - self.score(mine) < RIVAL_SCORE_FALL
            || its_left - my_left < COLUMN_ERROR * (left - my_left))
            && self.supports(others, other)?)
    }

    /// What an effect does next to others.
    fn say(
        &mut self,
        learner: &Learner,
        others: Found,
        one: Candidate,
        status: Status,
        order: u8,
    ) -> Result<(), Unknown> {
        let sets = [others, others.with(one)];
        let [before, after] =
            [self.held_out(sets[0])?, self.held_out(sets[1])?].map(|held| self.ut(learner, held));
        let p_value = self.evidence.chance(sets.map(|set| self.squares(set)), one);
        if let Some(finding) = self.finding(one) {
            *finding = Finding { status, before, after, p_value, partners: Found::none(), order };
        }
        Ok(())
    }

    /// The model in use, and what it would be without each of its effects.
    fn say_in_use(&mut self, learner: &Learner, total: &mut Work) {
        self.outcome.rms_ut = self.ut(learner, self.squares(self.used));
        for one in self.used.iter() {
            let Some(theta) = self.in_use.get(one.place()).copied().flatten() else { continue };
            let away = learner.in_columns(one, theta.map(|value| -value));
            total.shift(&away);
            let before = self.ut(learner, left(total, self.used.without(one)));
            total.shift(&away.map(|value| -value));
            let after = self.outcome.rms_ut;
            if let Some(finding) = self.finding(one) {
                (finding.before, finding.after) = (before, after);
            }
        }
    }

    /// The dip, and the last word.
    #[inline(never)]
    fn dip(&mut self, learner: &Learner) -> Stage {
        self.outcome.dip_rms_deg = Lateness::by_dip(&learner.late).map_or(f32::NAN, |dip| dip.rms_deg);
        let Some(late) = Lateness::of(&learner.late) else { return Stage::End };
        self.outcome.late_by_turning = late.by_turning;
        let is_in_use = self.in_use.get(Candidate::Lag.place()).is_some_and(Option::is_some);
        let is_missing = late.is_shown && !is_in_use;
        let added = self.outcome.findings.iter().map(|one| one.order).max().unwrap_or(0);
        if let Some(finding) = self.finding(Candidate::Lag) {
            *finding = Finding {
                status: match (is_in_use, is_missing) {
                    (true, _) => Status::InUse,
                    (false, true) => Status::Missing,
                    (false, false) => Status::NotNeeded,
                },
                before: late.before_deg,
                after: late.after_deg,
                p_value: late.p_value,
                partners: Found::none(),
                order: if is_missing { added + 1 } else { 0 },
            };
        }
        if is_missing && self.outcome.verdict == Verdict::Complete {
            self.outcome.verdict = Verdict::Missing;
        }
        Stage::End
    }
}
