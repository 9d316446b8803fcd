//! `why`: the question put to the study, a piece of work a turn, and its answer in words.

use core::fmt;

use super::learner_inputs::{Answer, Purpose, Question};
use super::machine::Device;
use super::name::Id;
use crate::effect::{Effect, advice};
use crate::extended::Effects;
use crate::learn::{Candidate, Finding, Found, Inquiry, Outcome, Status, Verdict};
use crate::number::Num;
use crate::protocol::{Answered, Code, Opt, Reply};

impl Device {
    /// Puts the question; the answer comes once the study has it. An answer at once where there is nothing to study.
    #[inline(never)]
    pub(super) fn why<W: fmt::Write>(&mut self, reply: Reply<'_, W>) -> Option<Answered> {
        if !self.learner_inputs.learner.is_learning() {
            return Some(reply.err(Code::State, format_args!("{NOTHING_YET}")));
        }
        self.ask(Purpose::Why);
        None
    }

    pub(super) fn ask(&mut self, purpose: Purpose) {
        self.learner_inputs.learner.settle();
        let learner = &self.learner_inputs.learner;
        let none = Effects::none();
        let effects = self.active.as_ref().map_or(&none, |active| &active.record.effects);
        let inquiry = Inquiry::new(learner, learner.in_use(effects));
        self.learner_inputs.question = Some(Question { purpose, inquiry, steps: 0 });
    }

    /// Does one piece of the question's work, right after a sample; with the last one it is answered. `false` where it has to wait.
    #[inline(never)]
    pub(super) fn ponder<W: fmt::Write>(&mut self, out: &mut W) -> bool {
        if !self.may_compute(true) {
            return false;
        }
        self.compute_asked_ms = None;
        let learner_inputs = &mut self.learner_inputs;
        let Some(question) = &mut learner_inputs.question else { return false };
        question.steps = question.steps.saturating_add(1);
        let Some(outcome) = question.inquiry.step(&learner_inputs.learner) else { return true };
        let Some(Question { purpose, steps, .. }) = learner_inputs.question.take() else { return true };
        let answered = match purpose {
            Purpose::Why => Some(self.explain(Reply::new(out), &Answer { outcome, steps })),
            Purpose::Add(id) => self.add(Reply::new(out), &id, &outcome),
        };
        if let Some(answered) = answered {
            // Room was made sure of.
            let _ = answered.result();
        }
        true
    }

    // Apart from the question itself, as is what takes an effect in: the stack carries one of them at a time.
    #[inline(never)]
    fn explain<W: fmt::Write>(&self, mut reply: Reply<'_, W>, answer: &Answer) -> Answered {
        let Answer { outcome, steps } = answer;
        let learner = &self.learner_inputs.learner;
        reply.line(format_args!(
            "base rms_ut={} holdout_rms_ut={} noise_floor_ut={} dip_rms_deg={} n={} tested={}",
            Figure(outcome.rms_ut),
            Figure(outcome.holdout_rms_ut),
            Figure(outcome.floor_ut),
            Figure(outcome.dip_rms_deg),
            outcome.rows,
            Names(|f: &mut fmt::Formatter<'_>| {
                let mut any = false;
                for name in learner.tested() {
                    write!(f, "{}{name}", if any { "," } else { "" })?;
                    any = true;
                }
                if any { Ok(()) } else { f.write_str("-") }
            }),
        ));
        let mut rank = 0;
        for (candidate, finding) in outcome.ranked() {
            let Some(effect) = learner.effect(candidate) else { continue };
            rank += 1;
            let unit = if candidate == Candidate::Lag { "deg" } else { "ut" };
            reply.line(format_args!(
                "effect rank={rank} id={} status={} before_{unit}={} after_{unit}={} p={} confounded_with={}",
                Id(&effect),
                finding.status.name(),
                Figure(finding.before),
                Figure(finding.after),
                Opt(Some(finding.p_value).filter(|p| !p.is_nan()).map(Chance)),
                self.ids(finding.partners, ",", Form::Id),
            ));
        }
        for others in self.active.iter().flat_map(|active| active.record.effects.iter()) {
            if learner.candidate(&others.effect).is_none() {
                reply.line(format_args!("effect rank=- id={} status=in-use", Id(&others.effect)));
            }
        }
        self.say(&mut reply, outcome);
        let first = outcome.ranked().find(|(_, finding)| finding.order > 0);
        reply.ok(format_args!(
            "verdict={} first={} steps={steps}",
            outcome.verdict.name(),
            self.ids(first.map_or(Found::none(), |(one, _)| Found::none().with(one)), ",", Form::Id),
        ))
    }

    /// What it means.
    fn say<W: fmt::Write>(&self, reply: &mut Reply<'_, W>, outcome: &Outcome) {
        let with = |status: Status| {
            let is_it = |(_, finding): &(Candidate, Finding)| finding.status == status && finding.order > 0;
            outcome.ranked().filter(is_it).fold(Found::none(), |set, (one, _)| set.with(one))
        };
        let missing = with(Status::Missing);
        match outcome.verdict {
            Verdict::Complete => {
                let besides = if with_in_use(outcome) { " with the effects in use" } else { "" };
                reply.line(format_args!(
                    "says COMPLETE: offset and matrix{besides} explain these samples down to the sensor noise."
                ));
            }
            Verdict::Missing | Verdict::Confounded | Verdict::Unexplained => {
                if !missing.is_empty() {
                    reply.line(format_args!("says FOUND: {}.", self.ids(missing, " and ", Form::Name)));
                }
                for candidate in missing.iter() {
                    let Some(effect) = self.learner_inputs.learner.effect(candidate) else { continue };
                    let (finding, unit) = (
                        outcome.of(candidate),
                        match candidate {
                            Candidate::Lag if outcome.late_by_turning => "deg of the rotation",
                            Candidate::Lag => "deg of the dip",
                            _ => "uT",
                        },
                    );
                    reply.line(format_args!(
                        "says Modelling it reduces the error from {} to {} {unit}: effect add {}",
                        Figure(finding.before),
                        Figure(finding.after),
                        Id(&effect)
                    ));
                }
            }
            Verdict::Undetermined => {
                reply.line(format_args!(
                    "says UNDETERMINED: too few samples or directions. Rotate the sensor through all directions and ask \
                     again."
                ));
            }
        }
        for candidate in with(Status::Confounded).iter() {
            let partners = outcome.of(candidate).partners;
            reply.line(format_args!(
                "says CONFOUNDED: {} explain the error equally well. These samples cannot show which of them is the cause.",
                self.ids(partners.with(candidate), " and ", Form::Name)
            ));
            for partner in partners.iter() {
                self.separate(reply, candidate, partner);
            }
        }
        if outcome.verdict == Verdict::Unexplained {
            reply.line(format_args!(
                "says UNEXPLAINED: error remains that no tested effect explains. Send what changes near the sensor"
            ));
            reply.line(format_args!(
                "says (temperature, current, moving parts) with cov NAME=VALUE, or log it and run ironout diagnose."
            ));
        }
    }

    /// The recording that would tell two effects apart, in the words of the host.
    fn separate<W: fmt::Write>(&self, reply: &mut Reply<'_, W>, one: Candidate, other: Candidate) {
        let learner = &self.learner_inputs.learner;
        let (Some(one), Some(other)) = (learner.effect(one), learner.effect(other)) else { return };
        advice(&one, &other, |text| reply.line(format_args!("says To separate them: {text}")));
    }

    fn ids(&self, set: Found, between: &'static str, form: Form) -> impl fmt::Display + '_ {
        Names(move |f: &mut fmt::Formatter<'_>| {
            let mut any = false;
            for effect in set.iter().filter_map(|one| self.learner_inputs.learner.effect(one)) {
                f.write_str(if any { between } else { "" })?;
                any = true;
                match form {
                    Form::Id => write!(f, "{}", Id(&effect))?,
                    Form::Name => f.write_str(Effect::<f64>::name(&effect))?,
                }
            }
            if any { Ok(()) } else { f.write_str("-") }
        })
    }
}

pub(super) const NOTHING_YET: &str = "no samples to study yet: cal start and rotate the sensor; the study begins with the \
     first calibration";

fn with_in_use(outcome: &Outcome) -> bool {
    outcome.findings.iter().any(|finding| finding.status == Status::InUse)
}

#[derive(Clone, Copy)]
enum Form {
    Id,
    Name,
}

/// A figure with four decimals, `-` where it is not known.
pub(super) struct Figure(pub(super) f32);

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_finite() { write!(f, "{:.4}", Num(self.0)) } else { f.write_str("-") }
    }
}

/// A probability.
struct Chance(f32);

impl fmt::Display for Chance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 < 1e-30 { f.write_str("0") } else { write!(f, "{:.1e}", Num(self.0)) }
    }
}

struct Names<F>(F);

impl<F: Fn(&mut fmt::Formatter<'_>) -> fmt::Result> fmt::Display for Names<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (self.0)(f)
    }
}
