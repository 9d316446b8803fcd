//! `effect list`, `effect add` and `effect remove`: what the study found, taken into the calibration in use.

use core::fmt;

use super::active::Active;
use super::job_purpose::JobPurpose;
use super::learner_inputs::{Change, Purpose};
use super::machine::Device;
use super::name::Id;
use super::why::{Figure, NOTHING_YET};
use crate::effect::{BuiltIn, Effect, TIME};
use crate::extended::{Effects, ExtendedCalibration};
use crate::fit::{MAX_PREDICTED_ERROR, Order};
use crate::learn::{Candidate, Motion, Outcome, Status, has_id};
use crate::number::Num;
use crate::protocol::{Answered, Code, EffectId, Reply};
use crate::record::{PredictedError, Record};
use crate::session::State;
use crate::store::{Done, StoreError, StoreJob};

fn reads_time(effect: &BuiltIn<f64>) -> bool {
    Effect::<f64>::columns(effect).into_iter().flatten().any(|column| column.name == TIME)
}

impl Device {
    /// What the calibration in use carries, and what could be tested beside it.
    #[inline(never)]
    pub(super) fn effect_list<W: fmt::Write>(&self, mut reply: Reply<'_, W>) -> Answered {
        let learner = &self.learner_inputs.learner;
        let in_use = || self.active.iter().flat_map(|active| active.record.effects.iter());
        for fitted in in_use() {
            reply.line(format_args!(
                "effect id={} state=in-use name={}",
                Id(&fitted.effect),
                Effect::<f64>::name(&fitted.effect)
            ));
        }
        for candidate in Candidate::all() {
            let Some(effect) = learner.effect(candidate) else { continue };
            if in_use().any(|fitted| learner.candidate(&fitted.effect) == Some(candidate)) {
                continue;
            }
            let state = match candidate {
                Candidate::Lag if self.learner_inputs.motion == Motion::UNKNOWN => {
                    "needs-gyro-or-accelerometer"
                }
                _ if !learner.is_learning() => "waits",
                _ => "tested",
            };
            let name = Effect::<f64>::name(&effect);
            reply.line(format_args!("effect id={} state={state} name={name}", Id(&effect)));
        }
        reply.line(format_args!("hint offset:NAME is tested from the first cov NAME=VALUE on"));
        reply.line(format_args!(
            "hint the host tests gain, field, nonlinearity, cross-axis and periodic, from a log"
        ));
        reply.ok(format_args!("in_use={}", in_use().count()))
    }

    /// `effect add`: the question first, then what comes of it.
    #[inline(never)]
    pub(super) fn effect_add<W: fmt::Write>(
        &mut self,
        reply: Reply<'_, W>,
        id: EffectId,
    ) -> Option<Answered> {
        let learner = &self.learner_inputs.learner;
        if !learner.is_learning() {
            return Some(reply.err(Code::State, format_args!("{NOTHING_YET}")));
        }
        let in_use = || self.active.iter().flat_map(|active| active.record.effects.iter());
        if in_use().any(|fitted| has_id(&fitted.effect, &id)) {
            return Some(
                reply.err(Code::State, format_args!("{id} is in use; effect remove {id} takes it out")),
            );
        }
        let named = self.named(&id);
        if named.is_none() {
            return Some(reply.err(Code::Unknown, format_args!("{id} is not tested here; see effect list")));
        }
        self.ask(Purpose::Add(id));
        None
    }

    /// The candidate of this id.
    fn named(&self, id: &str) -> Option<Candidate> {
        let learner = &self.learner_inputs.learner;
        Candidate::all()
            .find(|candidate| learner.effect(*candidate).is_some_and(|effect| has_id(&effect, id)))
    }

    /// The question is answered: the effect is taken in, if these samples show it.
    #[inline(never)]
    pub(super) fn add<W: fmt::Write>(
        &mut self,
        reply: Reply<'_, W>,
        id: &EffectId,
        outcome: &Outcome,
    ) -> Option<Answered> {
        let Some(candidate) = self.named(id) else {
            return Some(reply.err(Code::State, format_args!("{id} is no longer tested; see effect list")));
        };
        let finding = outcome.of(candidate);
        if !matches!(finding.status, Status::Missing | Status::Confounded) {
            let text = match finding.status {
                Status::NotNeeded => "not significant in these samples",
                _ => "not enough samples yet: keep rotating the sensor",
            };
            let (status, p) = (finding.status.name(), Num(finding.p_value));
            let (before, after) = (Figure(finding.before), Figure(finding.after));
            return Some(reply.err(
                Code::Refused,
                format_args!("{status} {text} (held-out error {before} to {after}, p={p:.1e}); see why"),
            ));
        }
        let Some(record) = self.to_change(outcome) else {
            return Some(reply.err(
                Code::Refused,
                format_args!(
                    "error-too-large offset and matrix are not accurate enough yet: rotate the sensor through all directions"
                ),
            ));
        };
        let is_foreign = || record.effects.iter().any(|fitted| reads_time(&fitted.effect));
        if candidate.goes_by_time() && !self.learner_inputs.own_clock && is_foreign() {
            return Some(reply.err(
                Code::State,
                format_args!(
                    "the calibration has effects tied to the time of another recording: effect remove those first"
                ),
            ));
        }
        match self.learner_inputs.learner.add(candidate, &record.extended()) {
            Err(why) => Some(reply.err(Code::Refused, format_args!("{why}"))),
            Ok(extended) => {
                self.change(&record, &extended, outcome.rms_ut);
                None
            }
        }
    }

    /// The record in use; without one, that of the base on which the study stands, where that is known as well as a calibration that
    /// is accepted: one whose effect was missing is often refused for that alone.
    fn to_change(&self, outcome: &Outcome) -> Option<Record> {
        if let Some(active) = &self.active {
            return Some(active.record);
        }
        let calibration = self.learner_inputs.learner.calibration()?;
        (f64::from(outcome.base_error) <= MAX_PREDICTED_ERROR).then(|| Record {
            sequence: 0,
            calibration,
            effects: Effects::none(),
            method: self.session.config().solved_by(),
            model: Order::Ellipsoid,
            samples: u64::from(outcome.rows),
            noise_ut: f64::from(outcome.floor_ut),
            rms_ut: f64::from(outcome.rms_ut),
            axes: Some(self.config.sensor.axes),
            predicted_error: PredictedError::of_share(f64::from(outcome.base_error)),
            covariance: None,
            holds_for: None,
        })
    }

    /// `effect remove`.
    #[inline(never)]
    pub(super) fn effect_remove<W: fmt::Write>(
        &mut self,
        reply: Reply<'_, W>,
        id: &EffectId,
    ) -> Option<Answered> {
        let in_use = self.active.as_ref().map(|active| &active.record);
        let found = in_use.and_then(|record| {
            let fitted = record.effects.iter().find(|fitted| has_id(&fitted.effect, id))?;
            Some((record, &fitted.effect))
        });
        let Some((record, effect)) = found else {
            return Some(reply.err(Code::State, format_args!("{id} is not in use; see effect list")));
        };
        let rms_ut = self.learner_inputs.learner.rms_ut();
        let extended = self.learner_inputs.learner.remove(effect, &record.extended());
        let record = *record;
        self.change(&record, &extended, rms_ut);
        None
    }

    /// Stores another calibration in the place of the one in use.
    #[inline(never)]
    fn change(&mut self, before: &Record, extended: &ExtendedCalibration<f64>, before_ut: f32) {
        let after_ut = self.learner_inputs.learner.rms_ut();
        let rows = u64::from(self.learner_inputs.learner.rows());
        let record = Record {
            calibration: extended.base,
            effects: extended.effects,
            rms_ut: if after_ut.is_finite() { f64::from(after_ut) } else { before.rms_ut },
            samples: if rows > 0 { rows } else { before.samples },
            // It was that of another base.
            covariance: None,
            ..*before
        };
        self.learner_inputs.changed =
            Some(Change { before: before.calibration, rms_ut: [before_ut, after_ut] });
        self.begin(JobPurpose::Effect, StoreJob::save(self.slot_in_use(), record));
    }

    /// It was stored, or not; only then it is applied.
    #[inline(never)]
    pub(super) fn effect_stored<W: fmt::Write>(
        &mut self,
        outcome: Result<Done, StoreError>,
        out: &mut W,
    ) -> Answered {
        let reply = Reply::new(out);
        let change = self.learner_inputs.changed.take();
        let error = match outcome {
            Ok(Done::Saved(slot, record)) => {
                let now_ms = self.now_ms;
                let known = self.active.as_ref().and_then(|old| old.recording_s(now_ms));
                Active::install(&mut self.active, slot, &record, self.config.sensor.axes);
                if record.effects.iter().any(|fitted| reads_time(&fitted.effect)) {
                    // What the study found goes by the board's own clock; a calibration that was there before keeps its own.
                    let is_own = self.learner_inputs.own_clock || known.is_none();
                    let now_s = known.filter(|_| !is_own).unwrap_or(now_ms as f64 * 1e-3);
                    if let Some(active) = &mut self.active {
                        active.feed(TIME, now_s, now_ms);
                    }
                    self.learner_inputs.own_clock = is_own;
                }
                self.feed_again();
                if self.session.state() == State::Refused {
                    // What was refused is answered: what was missing is in the calibration that is in use now.
                    self.session.cancel();
                    self.status = None;
                }
                let [before, after] = change.map_or([f32::NAN; 2], |change| change.rms_ut);
                return reply.ok(format_args!(
                    "effects={} rms_before_ut={} rms_ut={} slot={slot} sequence={}",
                    record.effects.len(),
                    Figure(before),
                    Figure(after),
                    record.sequence
                ));
            }
            Ok(_) => StoreError::DoesNotFit,
            Err(error) => error,
        };
        if let Some(change) = change {
            // The study stands at the calibration that is in use.
            self.learner_inputs.learner.begin(&change.before);
        }
        reply.err(Code::Store, format_args!("{error}: the calibration in use is unchanged"))
    }
}
