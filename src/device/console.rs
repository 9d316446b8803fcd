//! The commands that are not about a calibration itself, and the choice between all of them.

use core::fmt;

use super::Device;
use crate::effect::ColumnName;
use crate::extended::Live;
use crate::protocol::{self, Answered, Code, Command, Line, Opt, ParseError, Reply, StreamMode};
use crate::session::State;
use crate::store::{Slots, Store};

const HELP: [&str; 8] = [
    "help | version | status",
    "cal start | cal stop | cal accept | cal cancel | cal show | cal clear",
    "cal method adjusted|trace|constant",
    "stream off | stream raw | stream cal | stream motioncal",
    "field UT: the expected magnitude, microtesla",
    "cov NAME=VALUE: a column that the calibration's effects follow, as in cov temp_c=31.5",
    "a calibration: cal start, turn the board in all directions, cal stop, cal accept",
    "status says where to turn next",
];

impl Device {
    pub(super) fn answer<W: fmt::Write>(
        &mut self,
        line: Line<'_>,
        out: &mut W,
        store: &mut impl Store,
    ) -> Answered {
        let mut reply = Reply::new(out);
        let text = match line {
            Line::Text(text) => text,
            Line::TooLong => {
                return reply
                    .err(Code::Long, format_args!("a line has at most {} characters", protocol::MAX_LINE));
            }
            Line::NotText => {
                return reply.err(Code::Usage, format_args!("a line holds printable ASCII characters only"));
            }
        };
        let command = match protocol::parse(text) {
            Ok(command) => command,
            Err(ParseError::Unknown) => {
                return reply.err(Code::Unknown, format_args!("no such command; try help"));
            }
            Err(ParseError::NotBuilt(word)) => {
                return reply.err(Code::Unknown, format_args!("{word} is not built into this firmware yet"));
            }
            Err(ParseError::Usage(usage)) => return reply.err(Code::Usage, format_args!("{usage}")),
        };
        match command {
            Command::Help => {
                HELP.iter().for_each(|line| reply.line(format_args!("{line}")));
                reply.done()
            }
            Command::Version => self.version(reply, store),
            Command::Status => self.status(reply),
            Command::CalStart => self.cal_start(reply),
            Command::CalStop => self.cal_stop(reply),
            Command::CalAccept => self.cal_accept(reply, store),
            Command::CalCancel => self.cal_cancel(reply),
            Command::CalShow => self.cal_show(reply),
            Command::CalClear => {
                let answered = self.cal_clear(reply, store);
                if self.stream == StreamMode::Calibrated && self.active.is_none() {
                    // Nothing is left to stream.
                    self.stream = StreamMode::Off;
                }
                answered
            }
            Command::CalMethod(method) => {
                self.session.set_method(method);
                reply.ok(format_args!("method={}", method.name()))
            }
            Command::Stream(mode) => self.set_stream(reply, mode),
            Command::Cov(name, value) => self.cov(reply, &name, value),
            Command::Field(field_ut) => {
                if self.session.set_field_ut(Some(field_ut)) {
                    reply.ok(format_args!("field_ut={field_ut:?}"))
                } else {
                    reply.err(Code::Usage, format_args!("field UT, a positive magnitude in microtesla"))
                }
            }
        }
    }

    /// Feeds a column to the calibration in use; it keeps the value until it is fed again.
    fn cov<W: fmt::Write>(&mut self, reply: Reply<'_, W>, name: &ColumnName, value: f64) -> Answered {
        let now_ms = self.now_ms;
        let Some(active) = &mut self.active else {
            return reply
                .err(Code::State, format_args!("there is no calibration whose effects could follow {name}"));
        };
        let used = active.feed(name.as_str(), value, now_ms);
        reply.ok(format_args!("{name}={value:?} used={}", u8::from(used)))
    }

    fn version<W: fmt::Write>(&self, mut reply: Reply<'_, W>, store: &mut impl Store) -> Answered {
        let [a, b] = Slots::inspect(store).states;
        reply.line(format_args!("slots={a},{b}"));
        if self.restarts.count > 0 {
            reply.line(format_args!("last_fault={}", self.restarts.last));
        }
        reply.ok(format_args!(
            "ironout={} board={} sensor={}",
            env!("CARGO_PKG_VERSION"),
            self.config.board,
            self.config.sensor
        ))
    }

    fn status<W: fmt::Write>(&self, mut reply: Reply<'_, W>) -> Answered {
        let status = self.session.status();
        match self.sensor.fault() {
            Some(fault) => reply.line(format_args!("sensor {} {fault}", self.config.sensor)),
            None if status.state == State::Idle && self.active.is_some() => {
                let live = self.active.as_ref().map(|active| &active.live);
                match live.and_then(Live::waits_for) {
                    Some(column) => {
                        reply.line(format_args!("hint the calibration waits for: cov {column}=VALUE"))
                    }
                    None if live.is_some_and(Live::needs_gyro) => reply.line(format_args!(
                        "hint the calibration needs a rate of turn, which this board does not have"
                    )),
                    None => reply.line(format_args!(
                        "hint a calibration is in use; begin another one with: cal start"
                    )),
                }
            }
            None => reply.line(format_args!("hint {}", status.hint)),
        }
        // What went wrong: restarts of the firmware, lost transactions, and samples out of range.
        let faults = [self.restarts.count, self.sensor.faults()]
            .into_iter()
            .fold(status.saturated, |sum, faults| sum.saturating_add(u64::from(faults)));
        reply.ok(format_args!(
            "state={} n={} skipped={} coverage={:.3} gap_deg={:.1} rms_ut={:.4} noise_ut={:.4} calibrated={} faults={faults}",
            status.state.name(),
            status.n,
            status.skipped,
            status.coverage,
            status.gap_deg,
            Opt(status.rms_ut),
            Opt(status.noise_ut),
            u8::from(self.active.is_some()),
        ))
    }

    fn set_stream<W: fmt::Write>(&mut self, reply: Reply<'_, W>, mode: StreamMode) -> Answered {
        if let (true, Some(fault)) = (mode != StreamMode::Off, self.sensor.fault()) {
            return self.no_sensor(reply, fault);
        }
        let name = match mode {
            StreamMode::Off => "off",
            StreamMode::Raw => "raw",
            StreamMode::Calibrated if self.active.is_none() => {
                return reply.err(Code::State, format_args!("there is no calibration: cal start begins one"));
            }
            StreamMode::Calibrated => "cal",
            StreamMode::MotionCal => "motioncal",
        };
        self.stream = mode;
        reply.ok(format_args!("stream={name}"))
    }
}
