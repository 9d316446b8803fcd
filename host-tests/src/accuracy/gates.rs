//! What the verdict lets through and turns away: the whole session, rest gate and all, on logs of limited attitude and on
//! good ones.

use super::attitude::Motion;
use super::log::{FIELD_UT, Log, RATE_HZ};
use super::solvers::{SOLVERS, Solver, solve};
use ironout::fit::Method;
use ironout::gate::block_samples;
use ironout::sensor::Sample;
use ironout::session::{Session, SessionConfig};
use nalgebra::Matrix3;

/// A corrected vector off by more than this anywhere, and the calibration should not have been accepted.
pub const WRONG: f64 = 0.03;
/// One off by less than this everywhere should not have been refused.
pub const RIGHT: f64 = 0.005;

/// What became of one log.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Whether the calibration was accepted.
    pub accepted: bool,
    /// The largest error of a corrected vector over the field; `None` without a calibration.
    pub error: Option<f64>,
    /// The error predicted, over the field.
    pub predicted: Option<f64>,
    /// Why it was refused, or notes.
    pub reasons: String,
}

/// Runs a log through a session.
pub fn judge(log: &Log, solver: Solver) -> Judged {
    match solver {
        Solver::Ironout(method) => judge_session(log, method),
        Solver::Magcal => {
            // It has no verdict of its own: what it answers is accepted.
            let solved = solve(solver, &log.counts, log.ut_per_count, FIELD_UT);
            Judged {
                accepted: solved.is_some(),
                error: solved.map(|s| log.worst_error(&s.b, &s.c)),
                predicted: None,
                reasons: String::new(),
            }
        }
    }
}

fn judge_session(log: &Log, method: Method) -> Judged {
    let mut session = Session::new(SessionConfig {
        ut_per_count: [log.ut_per_count; 3],
        field_ut: Some(FIELD_UT),
        method,
        samples_per_block: block_samples(RATE_HZ),
        axes: None,
    });
    session.start();
    for counts in &log.counts {
        session.push(Sample::valid(*counts));
    }
    let outcome = session.stop().expect("the session collects");
    let report = outcome.report.as_ref();
    Judged {
        accepted: outcome.verdict.accepted,
        error: report.map(|r| {
            let c = Matrix3::from_fn(|i, k| r.calibration.matrix[i][k]);
            log.worst_error(&r.calibration.offset_ut.into(), &c)
        }),
        predicted: report.map(|r| r.predicted_error_ut / r.calibration.field_ut),
        reasons: outcome.verdict.reasons.iter().map(|r| r.code()).collect::<Vec<_>>().join(" "),
    }
}

/// Counts of verdicts, right and wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Logs.
    pub logs: usize,
    /// Accepted.
    pub accepted: usize,
    /// Accepted, and off by more than [`WRONG`] somewhere.
    pub wrongly_accepted: usize,
    /// Off by less than [`RIGHT`] everywhere, accepted or not.
    pub good: usize,
    /// Refused, though off by less than [`RIGHT`] everywhere.
    pub wrongly_refused: usize,
}

impl Tally {
    /// Counts one more.
    pub fn add(&mut self, judged: &Judged) {
        self.logs += 1;
        self.accepted += usize::from(judged.accepted);
        // A calibration without a finite error is wrong.
        self.wrongly_accepted += usize::from(judged.accepted && judged.error.is_none_or(|e| !(e <= WRONG)));
        let good = judged.error.is_some_and(|e| e < RIGHT);
        self.good += usize::from(good);
        self.wrongly_refused += usize::from(!judged.accepted && good);
    }
}

/// A group of logs in the tables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Its word.
    pub name: &'static str,
    /// The tallies, in the order of [`SOLVERS`].
    pub tallies: [Tally; SOLVERS.len()],
}

/// Judges the logs `from..to` of limited attitude, or of full attitude, and groups them by motion.
pub fn run(
    limited: bool,
    from: u64,
    to: u64,
    mut wrong: impl FnMut(u64, Solver, &Log, &Judged),
) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for seed in from..to {
        let log = if limited {
            Log::draw(0x11a1 + seed, |s| Motion::limited(seed as usize, s))
        } else {
            Log::draw(0xf011 + seed, |_| Motion::Full)
        };
        let name = log.motion.name();
        let at = groups.iter().position(|g| g.name == name).unwrap_or_else(|| {
            groups.push(Group { name, tallies: [Tally::default(); SOLVERS.len()] });
            groups.len() - 1
        });
        for (solver, tally) in SOLVERS.iter().zip(&mut groups[at].tallies) {
            let judged = judge(&log, *solver);
            let before = *tally;
            tally.add(&judged);
            if tally.wrongly_accepted > before.wrongly_accepted
                || tally.wrongly_refused > before.wrongly_refused
            {
                wrong(seed, *solver, &log, &judged);
            }
        }
    }
    groups
}

/// The sum of all groups.
pub fn total(groups: &[Group]) -> Group {
    let mut all = Group { name: "all", tallies: [Tally::default(); SOLVERS.len()] };
    for group in groups {
        for (sum, tally) in all.tallies.iter_mut().zip(&group.tallies) {
            sum.logs += tally.logs;
            sum.accepted += tally.accepted;
            sum.wrongly_accepted += tally.wrongly_accepted;
            sum.good += tally.good;
            sum.wrongly_refused += tally.wrongly_refused;
        }
    }
    all
}
