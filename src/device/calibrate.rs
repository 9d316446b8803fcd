//! Starting, stopping and accepting a calibration, by console and by button.

use core::fmt;

use super::{Active, Device, SensorFault};
use crate::effect::Effect;
use crate::extended::{Effects, FittedEffect};
use crate::fit::FitReport;
use crate::protocol::{Answered, Code, Reply};
use crate::quality::Reason;
use crate::record::Record;
use crate::session::{State, StateError};
use crate::store::{self, Slot, Store, StoreError};

/// Why a calibration was not started.
enum NotStarted {
    Collecting,
    Sensor(SensorFault),
}

/// Why a solution was not accepted.
enum NotAccepted {
    State(StateError),
    Store(StoreError),
}

/// What a press of the button did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ButtonEvent {
    /// Collecting has begun.
    Started,
    /// Nothing: the sensor does not work.
    NoSensor(SensorFault),
    /// The calibration was solved, stored in this slot, and is in use.
    Accepted(Slot),
    /// The data do not support a calibration; the one in use stays.
    Refused,
    /// The calibration is good and could not be stored; the one in use stays. `cal accept` tries again.
    NotStored(StoreError),
}

impl Device {
    /// A press of the button: starts a calibration, or ends one and accepts it if its verdict allows.
    pub fn on_button(&mut self, store: &mut impl Store) -> ButtonEvent {
        match self.start() {
            Ok(()) => ButtonEvent::Started,
            Err(NotStarted::Sensor(fault)) => ButtonEvent::NoSensor(fault),
            Err(NotStarted::Collecting) => {
                // Collecting, so that this cannot fail; what counts is whether there is a solution now.
                let _ = self.session.stop();
                match self.accept(store) {
                    Ok(slot) => ButtonEvent::Accepted(slot),
                    Err(NotAccepted::State(_)) => ButtonEvent::Refused,
                    Err(NotAccepted::Store(error)) => ButtonEvent::NotStored(error),
                }
            }
        }
    }

    fn start(&mut self) -> Result<(), NotStarted> {
        if self.session.state() == State::Collecting {
            return Err(NotStarted::Collecting);
        }
        if let Some(fault) = self.sensor.fault() {
            return Err(NotStarted::Sensor(fault));
        }
        self.session.start();
        Ok(())
    }

    /// Stores the solution, and only then applies it.
    fn accept(&mut self, store: &mut impl Store) -> Result<Slot, NotAccepted> {
        let state = self.session.state();
        let report = self.session.solution().ok_or(NotAccepted::State(StateError { state }))?;
        let in_use = self.active.as_ref().map(|active| active.slot);
        let (slot, record) = store::save(store, in_use, record_of(report)).map_err(NotAccepted::Store)?;
        self.session.accept().map_err(NotAccepted::State)?;
        self.active = Active::new(slot, record);
        Ok(slot)
    }

    pub(super) fn cal_start<W: fmt::Write>(&mut self, reply: Reply<'_, W>) -> Answered {
        match self.start() {
            Ok(()) => reply.ok(format_args!("state={}", self.session.state().name())),
            Err(NotStarted::Collecting) => {
                reply.err(Code::State, format_args!("already collecting: cal stop or cal cancel first"))
            }
            Err(NotStarted::Sensor(fault)) => self.no_sensor(reply, fault),
        }
    }

    pub(super) fn cal_stop<W: fmt::Write>(&mut self, mut reply: Reply<'_, W>) -> Answered {
        let outcome = match self.session.stop() {
            Ok(outcome) => outcome,
            Err(_) => {
                return reply.err(Code::State, format_args!("nothing is being collected: cal start first"));
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

    pub(super) fn cal_accept<W: fmt::Write>(
        &mut self,
        reply: Reply<'_, W>,
        store: &mut impl Store,
    ) -> Answered {
        match self.accept(store) {
            Ok(slot) => {
                self.store_unread = false;
                let sequence = self.record().map_or(0, |record| record.sequence);
                reply.ok(format_args!("calibrated=1 slot={slot} sequence={sequence}"))
            }
            Err(NotAccepted::State(StateError { state: State::Refused })) => {
                let verdict = self.session.outcome().map(|outcome| &outcome.verdict);
                refused(reply, verdict.and_then(|v| v.reasons.iter().find(|reason| reason.refuses())))
            }
            Err(NotAccepted::State(error)) => reply.err(Code::State, format_args!("{error}")),
            Err(NotAccepted::Store(error)) => reply.err(
                Code::Store,
                format_args!(
                    "{error}: the calibration in use is unchanged, the solution waits; cal accept tries again"
                ),
            ),
        }
    }

    pub(super) fn cal_cancel<W: fmt::Write>(&mut self, reply: Reply<'_, W>) -> Answered {
        if self.session.state() == State::Idle {
            return reply.err(Code::State, format_args!("nothing to cancel"));
        }
        self.session.cancel();
        reply.ok(format_args!("state={}", self.session.state().name()))
    }

    pub(super) fn cal_clear<W: fmt::Write>(
        &mut self,
        reply: Reply<'_, W>,
        store: &mut impl Store,
    ) -> Answered {
        match store::erase(store) {
            Ok(()) => {
                self.active = None;
                self.store_unread = false;
                reply.ok(format_args!("calibrated=0"))
            }
            Err(error) => reply.err(
                Code::Store,
                format_args!("{error}: the calibration in use stays; cal clear tries again"),
            ),
        }
    }

    /// The calibration in use, or else the solution that waits to be accepted.
    pub(super) fn cal_show<W: fmt::Write>(&self, mut reply: Reply<'_, W>) -> Answered {
        let solved = self.session.solution().map(record_of);
        let Some(record) = self.record().or(solved.as_ref()) else {
            return reply.err(Code::State, format_args!("there is no calibration: cal start begins one"));
        };
        // `{:?}` writes the shortest digits that read back to the same bits.
        let [x, y, z] = record.calibration.offset_ut;
        reply.line(format_args!("offset_ut={x:?},{y:?},{z:?}"));
        for [x, y, z] in record.calibration.matrix {
            reply.line(format_args!("matrix={x:?},{y:?},{z:?}"));
        }
        for fitted in record.effects.iter() {
            reply.line(format_args!("effect={}", Row(fitted)));
        }
        reply.ok(format_args!(
            "field_ut={:?} method={} model={} n={} rms_ut={:.4} noise_ut={:.4} stored={}",
            record.calibration.field_ut,
            record.method.name(),
            record.model.name(),
            record.samples,
            record.rms_ut,
            record.noise_ut,
            u8::from(self.active.is_some()),
        ))
    }

    pub(super) fn no_sensor<W: fmt::Write>(&self, reply: Reply<'_, W>, fault: SensorFault) -> Answered {
        reply.err(Code::Sensor, format_args!("{} {fault}; it is tried again by itself", self.config.sensor))
    }
}

fn refused<W: fmt::Write>(reply: Reply<'_, W>, reason: Option<&Reason>) -> Answered {
    match reason {
        Some(reason) => reply.err(Code::Refused, format_args!("{} {reason}", reason.code())),
        None => {
            reply.err(Code::Refused, format_args!("not-finite the solution is no calibration: start again"))
        }
    }
}

fn record_of(report: &FitReport) -> Record {
    Record {
        sequence: 0,
        calibration: report.calibration,
        effects: Effects::none(),
        method: report.method,
        model: report.model,
        samples: report.samples,
        noise_ut: report.noise_ut,
        rms_ut: report.rms_ut,
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
            report.calibration.field_ut,
            report.rms_ut,
            report.noise_ut,
            100.0 * report.predicted_error_ut / report.calibration.field_ut,
        )
    }
}

/// An effect, as `cal show` gives it: every number to the last bit but the standard errors.
struct Row<'a>(&'a FittedEffect<f64>);

impl fmt::Display for Row<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Row(FittedEffect { effect, coefficients, std_errors }) = self;
        let k = effect.coefficients();
        Effect::<f64>::id(effect, f)?;
        for (key, values) in [(" coefficients=", coefficients), (" std_errors=", std_errors)] {
            for (index, value) in values.iter().take(k).enumerate() {
                f.write_str(if index == 0 { key } else { "," })?;
                if value.is_nan() { f.write_str("-") } else { write!(f, "{value:?}") }?;
            }
        }
        let parts = effect.parts();
        if let Some(reference) = parts.reference() {
            write!(f, " reference={reference:?}")?;
        }
        match parts.parameter() {
            Some((searched, value)) => write!(f, " {}={value:?}", searched.name()),
            None => Ok(()),
        }
    }
}
