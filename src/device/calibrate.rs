//! Starting, stopping and accepting a calibration, by console and by button.

use core::fmt;

use super::button::ButtonEvent;
use super::job_purpose::JobPurpose;
use super::level::Tilts;
use super::level_worse::LevelWorse;
use super::machine::Device;
use super::sensor::SensorFault;
use crate::effect::{Bends, Effect};
use crate::extended::FittedEffect;
use crate::fit::FitReport;
use crate::level::Forces;
use crate::number::Num;
use crate::protocol::{Answered, Code, Reply, StreamMode};
use crate::quality::Reason;
use crate::replacement::{Worse, clearly_worse};
use crate::session::{State, StateError};
use crate::store::{Done, Slot, StoreError, StoreJob};

/// Why no solution is stored.
enum NotSaved {
    NoSolution,
    Worse(Worse),
    WorseLevel(LevelWorse),
}

/// Why a calibration was not started.
enum NotStarted {
    Collecting,
    Sensor(SensorFault),
    /// The calibration in use has effects.
    Effects,
    /// This firmware has no level calibration.
    NotLinked,
}

impl Device {
    /// Does what a press of the button does: starts a calibration, or ends one and accepts it if its verdict allows.
    #[inline(never)]
    pub(super) fn pressed(&mut self) {
        match self.start(false) {
            Ok(()) => self.tell(ButtonEvent::Started),
            Err(NotStarted::Sensor(fault)) => self.tell(ButtonEvent::NoSensor(fault)),
            // The button starts no level calibration.
            Err(NotStarted::Effects | NotStarted::NotLinked) => {}
            Err(NotStarted::Collecting) => {
                // What counts is whether there is a solution now.
                if self.is_level() {
                    let _ = self.solve_level();
                } else {
                    let _ = self.session.stop();
                }
                // Whoever has only a button cannot insist: what is better stays.
                match self.save(JobPurpose::AcceptByButton, false) {
                    Ok(()) => {}
                    Err(NotSaved::NoSolution) => self.tell(ButtonEvent::Refused),
                    Err(NotSaved::Worse(_) | NotSaved::WorseLevel(_)) => self.tell(ButtonEvent::Worse),
                }
            }
        }
    }

    #[inline(never)]
    fn start(&mut self, level: bool) -> Result<(), NotStarted> {
        if self.session.state() == State::Collecting {
            return Err(NotStarted::Collecting);
        }
        if let Some(fault) = self.sensor.fault() {
            return Err(NotStarted::Sensor(fault));
        }
        if level && !cfg!(feature = "methods") {
            return Err(NotStarted::NotLinked);
        }
        if level && self.active.as_ref().is_some_and(|active| !active.record.effects.is_empty()) {
            return Err(NotStarted::Effects);
        }
        self.session.start();
        self.level = level.then(Forces::default);
        self.loading.forget();
        self.learn_anew();
        self.status = None;
        Ok(())
    }

    /// Begins to store the solution.
    #[inline(never)]
    fn save(&mut self, purpose: JobPurpose, force: bool) -> Result<(), NotSaved> {
        let record = self.waiting().ok_or(NotSaved::NoSolution)?;
        let in_use = self.active.as_ref().map(|active| &active.record).filter(|_| !force);
        if let Some(worse) = in_use.and_then(|in_use| clearly_worse(&record, in_use)) {
            return Err(NotSaved::Worse(worse));
        }
        if let Some(worse) = self.loading.worse.filter(|_| !force) {
            return Err(NotSaved::WorseLevel(worse));
        }
        self.begin(purpose, StoreJob::save(self.slot_in_use(), record));
        Ok(())
    }

    /// The solution was stored, or not; only then it is applied.
    #[inline(never)]
    pub(super) fn stored(&mut self, outcome: Result<Done, StoreError>) -> Result<Slot, StoreError> {
        let Done::Saved(slot, record) = outcome? else { return Err(StoreError::DoesNotFit) };
        // It was solved or loaded when the job began, and nothing is answered meanwhile.
        let _ = self.session.accept();
        self.loading.forget();
        self.put_to_work(slot, &record);
        Ok(slot)
    }

    pub(super) fn cal_start<W: fmt::Write>(&mut self, reply: Reply<'_, W>, level: bool) -> Answered {
        match self.start(level) {
            Ok(()) if level => reply.ok(format_args!("state=collecting level=1")),
            Ok(()) => reply.ok(format_args!("state={}", self.session.state().name())),
            Err(NotStarted::Collecting) => {
                reply.err(Code::State, format_args!("already collecting: cal stop or cal cancel first"))
            }
            Err(NotStarted::Sensor(fault)) => self.no_sensor(reply, fault),
            Err(NotStarted::NotLinked) => reply.err(
                Code::Unknown,
                format_args!("this firmware has no level calibration: build it with the feature methods"),
            ),
            Err(NotStarted::Effects) => reply.err(
                Code::State,
                format_args!("the calibration in use has effects, and level turns do not show them: effect remove them first"),
            ),
        }
    }

    #[inline(never)]
    pub(super) fn cal_stop<W: fmt::Write>(&mut self, mut reply: Reply<'_, W>) -> Answered {
        if self.is_level() && self.session.state() == State::Collecting {
            return self.level_stop(reply);
        }
        let outcome = match self.session.stop() {
            Ok(outcome) => outcome,
            Err(_) => {
                return reply
                    .err(Code::State, format_args!("no samples are being collected: cal start first"));
            }
        };
        let mut reasons = outcome.verdict.reasons.iter();
        if let (true, Some(report)) = (outcome.verdict.accepted, &outcome.report) {
            for note in reasons {
                reply.line(format_args!("note {} {note}", note.code()));
            }
            return reply.ok(format_args!("verdict=accepted {}", Quality(report)));
        }
        let first = reasons.find(|reason| reason.refuses());
        for reason in outcome.verdict.reasons.iter().filter(|&reason| Some(reason) != first) {
            reply.line(format_args!("also {} {reason}", reason.code()));
        }
        refused(reply, first)
    }

    #[inline(never)]
    pub(super) fn cal_accept<W: fmt::Write>(&mut self, reply: Reply<'_, W>, force: bool) -> Option<Answered> {
        match self.save(JobPurpose::Accept, force) {
            Ok(()) => return None,
            Err(NotSaved::Worse(worse)) => {
                return Some(reply.err(Code::Refused, format_args!("{} {worse}", Worse::CODE)));
            }
            Err(NotSaved::WorseLevel(worse)) => {
                return Some(reply.err(Code::Refused, format_args!("{worse}")));
            }
            Err(NotSaved::NoSolution) => {}
        }
        Some(match self.session.state() {
            State::Refused => {
                let verdict = self.session.outcome().map(|outcome| &outcome.verdict);
                refused(reply, verdict.and_then(|v| v.reasons.iter().find(|reason| reason.refuses())))
            }
            state => reply.err(Code::State, format_args!("{}", StateError { state })),
        })
    }

    #[inline(never)]
    pub(super) fn accepted<W: fmt::Write>(
        &mut self,
        outcome: Result<Done, StoreError>,
        out: &mut W,
    ) -> Answered {
        let reply = Reply::new(out);
        match self.stored(outcome) {
            Ok(slot) => {
                let sequence = self.record().map_or(0, |record| record.sequence);
                match self.record().and_then(|record| record.holds_for) {
                    None => reply.ok(format_args!("calibrated=1 slot={slot} sequence={sequence}")),
                    Some(holds_for) => reply.ok(format_args!(
                        "calibrated=1 slot={slot} sequence={sequence} holds_to_deg={:.0}",
                        Num(holds_for.tilt_deg)
                    )),
                }
            }
            Err(error) => reply.err(
                Code::Store,
                format_args!(
                    "{error}: the calibration in use is unchanged and the solution is kept; cal accept tries again"
                ),
            ),
        }
    }

    #[inline(never)]
    pub(super) fn cal_cancel<W: fmt::Write>(&mut self, reply: Reply<'_, W>) -> Answered {
        if self.state() == State::Idle {
            return reply.err(Code::State, format_args!("nothing to cancel"));
        }
        self.session.cancel();
        self.level = None;
        self.loading.forget();
        reply.ok(format_args!("state={}", self.state().name()))
    }

    #[inline(never)]
    pub(super) fn cleared<W: fmt::Write>(
        &mut self,
        outcome: Result<Done, StoreError>,
        out: &mut W,
    ) -> Answered {
        let reply = Reply::new(out);
        match outcome {
            Ok(_) => {
                self.cleared_from_work();
                if self.stream == StreamMode::Calibrated {
                    // Nothing is left to stream.
                    self.stream = StreamMode::Off;
                }
                reply.ok(format_args!("calibrated=0"))
            }
            Err(error) => reply.err(
                Code::Store,
                format_args!("{error}: the calibration in use is unchanged; cal clear tries again"),
            ),
        }
    }

    /// The stored calibration, applied or not, or else the solution that waits to be accepted.
    #[inline(never)]
    pub(super) fn cal_show<W: fmt::Write>(&self, mut reply: Reply<'_, W>) -> Answered {
        let waiting = self.waiting();
        let stored = self.active.as_ref().map(|active| &active.record);
        let Some(record) = stored.or(waiting.as_ref()) else {
            return reply.err(Code::State, format_args!("there is no calibration: cal start"));
        };
        // `{:?}` writes the shortest digits that read back to the same bits.
        let [x, y, z] = record.calibration.offset_ut.map(Num);
        reply.line(format_args!("offset_ut={x:?},{y:?},{z:?}"));
        for row in record.calibration.matrix {
            let [x, y, z] = row.map(Num);
            reply.line(format_args!("matrix={x:?},{y:?},{z:?}"));
        }
        for fitted in record.effects.iter() {
            reply.line(format_args!("effect={}", Row(fitted)));
        }
        if let Some(holds_for) = &record.holds_for {
            reply.line(format_args!("{}", Tilts(holds_for)));
        }
        reply.ok(format_args!(
            "field_ut={:?} method={} model={} n={} rms_ut={:.4} noise_ut={:.4} stored={}",
            Num(record.calibration.field_ut),
            record.method.name(),
            record.model.name(),
            record.samples,
            Num(record.rms_ut),
            Num(record.noise_ut),
            u8::from(stored.is_some()),
        ))
    }

    pub(super) fn no_sensor<W: fmt::Write>(&self, reply: Reply<'_, W>, fault: SensorFault) -> Answered {
        let again = if fault == SensorFault::AtRest { "" } else { "; it is tried again by itself" };
        reply.err(Code::Sensor, format_args!("{} {fault}{again}", self.config.sensor.name))
    }
}

fn refused<W: fmt::Write>(reply: Reply<'_, W>, reason: Option<&Reason>) -> Answered {
    match reason {
        Some(reason) => reply.err(Code::Refused, format_args!("{} {reason}", reason.code())),
        None => reply
            .err(Code::Refused, format_args!("not-finite the solution is not a calibration: start again")),
    }
}

/// The figures of a fit, as `cal stop` gives them.
struct Quality<'a>(&'a FitReport);

impl fmt::Display for Quality<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Quality(report) = self;
        write!(
            f,
            "method={} model={} n={} field_ut={:.3} rms_ut={:.4} noise_ut={:.4} error_percent={:.3}",
            report.method.name(),
            report.model.name(),
            report.samples,
            Num(report.calibration.field_ut),
            Num(report.rms_ut),
            Num(report.noise_ut),
            Num(100.0 * report.predicted_error_ut / report.calibration.field_ut),
        )
    }
}

/// An effect, as `cal show` gives it: every number to the last bit but the standard errors.
struct Row<'a>(&'a FittedEffect<f64>);

impl fmt::Display for Row<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Row(FittedEffect { effect, coefficients, std_errors, ranges, bends }) = self;
        let k = effect.coefficients();
        Effect::<f64>::id(effect, f)?;
        for (key, values) in [(" coefficients=", coefficients), (" std_errors=", std_errors)] {
            for (index, value) in values.iter().take(k).enumerate() {
                f.write_str(if index == 0 { key } else { "," })?;
                if value.is_nan() { f.write_str("-") } else { write!(f, "{:?}", Num(*value)) }?;
            }
        }
        let parts = effect.parts();
        if let Some(reference) = parts.reference() {
            write!(f, " reference={:?}", Num(reference))?;
        }
        if let Some((searched, value)) = parts.parameter() {
            write!(f, " {}={:?}", searched.name(), Num(value))?;
        }
        for (column, range) in effect.columns().into_iter().zip(ranges) {
            match (column, range) {
                (None, _) => {}
                (Some(_), Some([least, most])) => write!(f, " range={:?},{:?}", Num(*least), Num(*most))?,
                (Some(_), None) => f.write_str(" range=-")?,
            }
        }
        if *bends == Bends::Field {
            f.write_str(" bends=field")?;
        }
        Ok(())
    }
}
