//! The question which effect is missing, answered in steps so small that no sample waits.

use super::candidate::{CANDIDATES, Candidate, Found, SHOWN_BY_MAGNITUDE};
use super::finding::{Finding, InUse, NOTHING, Outcome, Status, Verdict};
use super::lateness::Lateness;
use super::learner::Learner;
use super::point::BASE;
use super::solve::{Chosen, Factor};
use super::test::{chance, held_out};
use crate::math;
use crate::study::rule::{NEARLY, RELEVANCE, RIVAL_SHARE, STEP_PLACES, falls, is_accepted, is_significant};

/// Fewer samples say nothing.
const LEAST_ROWS: u32 = 300;
/// Standard error of a base parameter, relative to the field, beyond which the orientations do not suffice for a study.
const MOST_BASE_ERROR: f32 = 0.03;
/// A step that takes this share off the squared error is relevant whatever blocks of time say that it is hardly seen in.
const STEP_SHARE: f32 = 0.1;
/// What two effects explain beyond each other is at most this share of what each explains: they are the same.
const SAME: f32 = 0.01;
/// Structure makes at least this share of the residual's variance, or it may be noise.
const STRUCTURE_SHARE: f64 = 0.25;

/// One test of one round.
#[derive(Clone, Copy, Debug)]
struct Tested {
    decrease: f32,
    accepted: bool,
}

const UNTESTED: Tested = Tested { decrease: 0.0, accepted: false };

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Begin,
    Model,
    Test(u8),
    Choose,
    Rival(u8, u8),
    Drop(u8),
    Dip,
    End,
}

/// A question under way. Its answer is of one moment where the learner takes no samples meanwhile; those that it takes move it by what
/// they say, and where it began anew, so does the question.
#[derive(Clone, Debug)]
pub struct Inquiry {
    stage: Stage,
    epoch: u16,
    in_use: InUse,
    /// Candidates that can be tested, and those in the model.
    testable: Found,
    model: Found,
    used: Found,
    swapped: Found,
    partners: Found,
    /// Variance of the residual with everything in, relative to the field, and how many samples count as one.
    variance: f64,
    time: f64,
    model_held_out: Option<f32>,
    model_squares: f32,
    tested: [Tested; SHOWN_BY_MAGNITUDE],
    added: u8,
    /// The last stage was work, not only a decision.
    worked: bool,
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
            model: Found::none(),
            used: Found::none(),
            swapped: Found::none(),
            partners: Found::none(),
            variance: 0.0,
            time: 1.0,
            model_held_out: None,
            model_squares: f32::NAN,
            tested: [UNTESTED; SHOWN_BY_MAGNITUDE],
            added: 0,
            worked: false,
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
        self.worked = false;
        while !self.worked {
            self.stage = match self.stage {
                Stage::Begin => self.begin(learner),
                Stage::Model => self.look_at_model(learner),
                Stage::Test(place) => self.test(learner, place),
                Stage::Choose => self.choose(),
                Stage::Rival(winner, other) => self.rival(learner, winner, other),
                Stage::Drop(place) => self.drop_one(learner, place),
                Stage::Dip => self.conclude(learner),
                Stage::End => return Some(self.outcome),
            };
        }
        None
    }

    fn searched(candidate: Candidate) -> f64 {
        if candidate == Candidate::Step { STEP_PLACES as f64 } else { 1.0 }
    }

    /// How many are tested.
    fn count(&self) -> usize {
        self.testable.len().max(1)
    }

    fn ut(&self, learner: &Learner, squares: f32) -> f32 {
        let field = learner.point.map_or(f32::NAN, |point| point.field_ut);
        math::sqrtf(squares.max(0.0) / learner.rows().max(1) as f32) * field
    }

    fn finding(&mut self, candidate: Candidate) -> Option<&mut Finding> {
        self.outcome.findings.get_mut(candidate.place())
    }

    /// Whether there is enough; how much noise there is.
    fn begin(&mut self, learner: &Learner) -> Stage {
        self.worked = true;
        let rows = learner.rows();
        self.outcome.rows = rows;
        if rows < LEAST_ROWS {
            return Stage::End;
        }
        for candidate in Candidate::all() {
            let is_testable = match candidate {
                Candidate::Drift => true,
                Candidate::Column(place) => {
                    learner.columns.get(usize::from(place)).is_some_and(|column| !column.is_constant())
                }
                Candidate::Step => learner.marks.has_step(rows),
                Candidate::Lag => false,
            };
            if self.in_use.get(candidate.place()).is_some_and(Option::is_some) {
                // One whose columns are not here is only taken off.
                if is_testable && (candidate != Candidate::Step || learner.marks.pinned) {
                    self.used = self.used.with(candidate);
                }
                if let Some(finding) = self.finding(candidate) {
                    finding.status = Status::InUse;
                }
            } else if is_testable {
                self.testable = self.testable.with(candidate);
            }
        }
        self.model = self.used;
        let total = learner.total();
        let all = self.testable.iter().fold(self.used, Found::with);
        let Some(full) = Factor::of(&total, all.chosen(), true) else { return Stage::End };
        let parameters = BASE + 3 * all.len();
        let squares = f64::from(full.squares(&total));
        self.variance = squares / (f64::from(rows) - parameters as f64).max(1.0);
        if !(self.variance > 0.0) {
            // All digits are used up: of such sums nothing can be said.
            return Stage::End;
        }
        self.time = learner.memory.time(self.variance, f64::from(rows), parameters as f64);
        let field = learner.point.map_or(f64::NAN, |point| f64::from(point.field_ut));
        self.outcome.floor_ut = (learner.memory.floor(self.variance) * field) as f32;
        let Some(base) = Factor::of(&total, Chosen::base(BASE), false) else { return Stage::End };
        let scale = (self.variance * self.time) as f32;
        let error = (0..BASE).map(|column| base.inverse(column) * scale).fold(0.0, f32::max);
        self.outcome.base_error = math::sqrtf(error);
        if self.outcome.base_error > MOST_BASE_ERROR {
            return Stage::End;
        }
        self.outcome.verdict = Verdict::Complete;
        Stage::Model
    }

    /// The error of the model as it is.
    fn look_at_model(&mut self, learner: &Learner) -> Stage {
        self.worked = true;
        let chosen = self.model.chosen();
        self.model_held_out = held_out(learner, chosen);
        let mut total = learner.total();
        let squares = Factor::of(&total, chosen, true).map_or(f32::NAN, |factor| factor.squares(&total));
        self.model_squares = squares;
        if self.added == 0 {
            self.outcome.rms_ut = self.ut(learner, squares);
            self.outcome.holdout_rms_ut = self.model_held_out.map_or(f32::NAN, |held| self.ut(learner, held));
            // What it would be without each effect in use.
            for candidate in self.used.iter() {
                let (Some(first), Some(theta)) =
                    (candidate.first_column(), self.in_use.get(candidate.place()).copied().flatten())
                else {
                    continue;
                };
                let away = learner.in_columns(candidate, theta, -1.0, first);
                total.shift(&away);
                let without = self.used.without(candidate).chosen();
                let squares =
                    Factor::of(&total, without, true).map_or(f32::NAN, |factor| factor.squares(&total));
                total.shift(&away.map(|value| -value));
                let (before, after) = (self.ut(learner, squares), self.outcome.rms_ut);
                if let Some(finding) = self.finding(candidate) {
                    (finding.before, finding.after) = (before, after);
                }
            }
        }
        self.tested = [UNTESTED; SHOWN_BY_MAGNITUDE];
        Stage::Test(0)
    }

    fn test(&mut self, learner: &Learner, place: u8) -> Stage {
        let next = Stage::Test(place + 1);
        let Some(candidate) = Candidate::at(usize::from(place)).filter(|one| *one != Candidate::Lag) else {
            return Stage::Choose;
        };
        if !self.testable.has(candidate) || self.model.has(candidate) {
            return next;
        }
        let Some(first) = candidate.first_column() else { return next };
        self.worked = true;
        let chosen = self.model.chosen();
        let total = learner.total();
        let Some(factor) = Factor::of(&total, chosen, true) else { return next };
        let gained = factor.test(&total, first, 3, candidate != Candidate::Step);
        let p_value = (chance(&gained, self.variance, self.time, learner.rows(), chosen.len())
            * Self::searched(candidate))
        .min(1.0);
        let held = held_out(learner, chosen.with(first, 3));
        let share = gained.decrease / self.model_squares;
        // Of a step that lies in the first block or the last, the others know nothing: what it takes off has to be so much the more.
        let lowers = share > RELEVANCE as f32
            && (falls(self.model_held_out.map(f64::from), held.map(f64::from))
                || (candidate == Candidate::Step && share > STEP_SHARE));
        let accepted = is_accepted(p_value, self.count(), lowers);
        if let Some(slot) = self.tested.get_mut(usize::from(place)) {
            *slot = Tested { decrease: gained.decrease, accepted };
        }
        let count = self.count() as f64;
        let (before, after) = (
            self.model_held_out.map_or(f32::NAN, |held| self.ut(learner, held)),
            held.map_or(f32::NAN, |held| self.ut(learner, held)),
        );
        if let Some(finding) = self.finding(candidate)
            && finding.status != Status::Confounded
        {
            finding.status = Status::NotNeeded;
            (finding.before, finding.after) = (before, after);
            finding.p_value = (p_value * count).min(1.0) as f32;
        }
        next
    }

    fn of(&self, candidate: Candidate) -> Tested {
        self.tested.get(candidate.place()).copied().unwrap_or(UNTESTED)
    }

    /// The best of those that pass; a logged cause before a shape in time that is hardly better.
    fn choose(&mut self) -> Stage {
        let passing = |candidate: &Candidate| self.of(*candidate).accepted;
        let better =
            |a: Candidate, b: Candidate| if self.of(b).decrease > self.of(a).decrease { b } else { a };
        let Some(mut winner) = self.testable.iter().filter(passing).reduce(better) else {
            return self.concluded();
        };
        if winner.is_in_time() {
            let logged = self.testable.iter().filter(|one| !one.is_in_time()).filter(passing).reduce(better);
            let left = |one: Candidate| self.model_squares - self.of(one).decrease;
            if let Some(logged) = logged.filter(|one| left(*one) < (NEARLY * NEARLY) as f32 * left(winner)) {
                winner = logged;
            }
        }
        (self.swapped, self.partners) = (Found::none().with(winner), Found::none());
        Stage::Rival(winner.place() as u8, 0)
    }

    /// Whether another candidate explains what the winner does.
    fn rival(&mut self, learner: &Learner, winner: u8, place: u8) -> Stage {
        let Some(own) = Candidate::at(usize::from(winner)) else { return Stage::Dip };
        let Some(other) = Candidate::at(usize::from(place)).filter(|one| *one != Candidate::Lag) else {
            return self.add(own);
        };
        let next = Stage::Rival(winner, place + 1);
        let (mine, its) = (self.of(own), self.of(other));
        let (Some(first), Some(second)) = (own.first_column(), other.first_column()) else { return next };
        if own == other || !its.accepted || its.decrease < RIVAL_SHARE as f32 * mine.decrease {
            return next;
        }
        self.worked = true;
        let total = learner.total();
        let given = |with: usize, tested: usize, candidate: Candidate| {
            let chosen = self.model.chosen().with(with, 3);
            let gained =
                Factor::of(&total, chosen, true)?.test(&total, tested, 3, candidate != Candidate::Step);
            let p = chance(&gained, self.variance, self.time, learner.rows(), chosen.len());
            Some((p * Self::searched(candidate), gained.decrease))
        };
        let (Some((p_mine, more)), Some((p_its, others))) =
            (given(second, first, own), given(first, second, other))
        else {
            return next;
        };
        let (stands, its_stands) =
            (is_significant(p_mine, self.count()), is_significant(p_its, self.count()));
        let same = more < SAME * mine.decrease && others < SAME * its.decrease;
        if same || (!stands && !its_stands) {
            self.partners = self.partners.with(other);
        } else if !stands && !self.swapped.has(other) && (own.is_in_time() || !other.is_in_time()) {
            // The other explains all that this one does, and more.
            self.swapped = self.swapped.with(other);
            self.partners = Found::none();
            return Stage::Rival(other.place() as u8, 0);
        }
        next
    }

    fn add(&mut self, winner: Candidate) -> Stage {
        self.added += 1;
        self.model = self.model.with(winner);
        let (partners, order) = (self.partners, self.added);
        let status = if partners.is_empty() { Status::Missing } else { Status::Confounded };
        if let Some(finding) = self.finding(winner) {
            (finding.status, finding.partners, finding.order) = (status, partners, order);
        }
        for partner in partners.iter() {
            if let Some(finding) = self.finding(partner) {
                finding.status = Status::Confounded;
                finding.partners = partners.with(winner).without(partner);
            }
        }
        Stage::Drop(0)
    }

    /// An earlier one that the last has made superfluous goes.
    fn drop_one(&mut self, learner: &Learner, place: u8) -> Stage {
        let Some(candidate) = Candidate::at(usize::from(place)).filter(|one| *one != Candidate::Lag) else {
            return if usize::from(self.added) < SHOWN_BY_MAGNITUDE {
                Stage::Model
            } else {
                self.concluded()
            };
        };
        let next = Stage::Drop(place + 1);
        let is_earlier = self
            .outcome
            .of(candidate)
            .order
            .checked_sub(1)
            .is_some_and(|before| before + 1 < self.added && self.model.has(candidate));
        if let (true, Some(first)) = (is_earlier, candidate.first_column()) {
            self.worked = true;
            let chosen = self.model.without(candidate).chosen();
            let total = learner.total();
            if let Some(factor) = Factor::of(&total, chosen, true) {
                let gained = factor.test(&total, first, 3, candidate != Candidate::Step);
                let p = chance(&gained, self.variance, self.time, learner.rows(), chosen.len());
                if !is_significant(p * Self::searched(candidate), self.count()) {
                    self.model = self.model.without(candidate);
                    self.testable = self.testable.without(candidate);
                    if let Some(finding) = self.finding(candidate) {
                        (finding.status, finding.order) = (Status::NotNeeded, 0);
                        finding.partners = Found::none();
                    }
                }
            }
        }
        next
    }

    /// Nothing more is added: does an error remain?
    fn concluded(&mut self) -> Stage {
        let found = |status: Status| self.outcome.findings.iter().any(|one| one.status == status);
        self.outcome.verdict = if found(Status::Confounded) {
            Verdict::Confounded
        } else if found(Status::Missing) {
            Verdict::Missing
        } else {
            Verdict::Complete
        };
        Stage::Dip
    }

    /// The dip, and the last word.
    fn conclude(&mut self, learner: &Learner) -> Stage {
        self.worked = true;
        self.unexplained(learner);
        let dip_rms_deg = Lateness::by_dip(&learner.late).map_or(f32::NAN, |dip| dip.rms_deg);
        let Some(dip) = Lateness::of(&learner.late) else { return Stage::End };
        self.outcome.dip_rms_deg = dip_rms_deg;
        self.outcome.late_by_turning = dip.by_turning;
        let is_in_use = self.in_use.get(Candidate::Lag.place()).is_some_and(Option::is_some);
        let is_missing = dip.is_shown && !is_in_use;
        let order = if is_missing { self.added + 1 } else { 0 };
        let status = match (is_in_use, is_missing) {
            (true, _) => Status::InUse,
            (false, true) => Status::Missing,
            (false, false) => Status::NotNeeded,
        };
        if let Some(finding) = self.finding(Candidate::Lag) {
            *finding = Finding {
                status,
                before: dip.before_deg,
                after: dip.after_deg,
                p_value: dip.p_value as f32,
                partners: Found::none(),
                order,
            };
        }
        if is_missing && self.outcome.verdict == Verdict::Complete {
            self.outcome.verdict = Verdict::Missing;
        }
        Stage::End
    }

    /// What the final model leaves beyond noise.
    fn unexplained(&mut self, learner: &Learner) {
        let total = learner.total();
        let Some(factor) = Factor::of(&total, self.model.chosen(), true) else { return };
        let parameters = BASE + 3 * self.model.len();
        let variance =
            f64::from(factor.squares(&total)) / (f64::from(learner.rows()) - parameters as f64).max(1.0);
        if learner.memory.noise(variance) < (1.0 - STRUCTURE_SHARE) * variance
            && self.outcome.verdict != Verdict::Confounded
        {
            self.outcome.verdict = Verdict::Unexplained;
        }
    }
}
