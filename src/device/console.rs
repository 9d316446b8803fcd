//! The commands that are not about a calibration itself, and the choice between all of them.

use core::fmt;

use super::active::Active;
use super::job_purpose::JobPurpose;
use super::machine::Device;
use super::sensor::SensorFault;
use crate::fit::Method;
use crate::number::Num;
use crate::protocol::{self, Answered, Code, Command, Line, Opt, ParseError, Reply, StreamMode};
use crate::session::{Hint, State};
use crate::store::StoreJob;

const HELP: [&str; 13] = [
    "help | version | status",
    "cal start [level] | cal stop | cal accept [force] | cal cancel | cal show | cal clear",
    "cal zero: another offset with the matrix in use, after some turns (a battery was swapped); cal zero start: begin again",
    "cal start level: for a vehicle that only turns level: two circles to the left and two to the right",
    "cal method adjusted|trace|constant",
    "cal dump: print the calibration byte by byte; cal load: receive one (ironout fetch, ironout send)",
    "stream off | stream raw | stream cal | stream motioncal | stream log",
    "field UT: the expected magnitude, microtesla",
    "cov NAME=VALUE: the value of a column, as in cov temp_c=31.5; NAME=- forgets it, NAME=on tests a column that the board \
     measures",
    "heading | heading DECLINATION_DEG: heading of the x axis, clockwise from north; east positive",
    #[cfg(not(feature = "study"))]
    "effect list",
    #[cfg(feature = "study")]
    "why: which effect is missing | effect list | effect add ID | effect remove ID",
    "a calibration: cal start, rotate the sensor in all directions, cal stop, cal accept",
    "status says where to turn next",
];

impl Device {
    /// `cal method`.
    fn set_method<W: fmt::Write>(&mut self, reply: Reply<'_, W>, method: Method) -> Answered {
        #[cfg(feature = "methods")]
        self.session.set_method(method);
        if self.session.config().solved_by() != method {
            return reply
                .err(Code::Unknown, format_args!("this firmware solves by the adjusted method alone"));
        }
        self.status = None;
        reply.ok(format_args!("method={}", method.name()))
    }

    /// Whether the answer takes a solve.
    pub(super) fn is_long(&self, line: Line<'_>) -> bool {
        let Line::Text(text) = line else { return false };
        match protocol::parse(text) {
            Ok(Command::CalStop) => self.session.state() == State::Collecting,
            Ok(Command::Status) => self.status_is_old() || self.may_propose_zero() || self.is_level(),
            Ok(Command::CalZero { .. }) => true,
            _ => false,
        }
    }

    /// Answers a line; `None` where a job at the store was begun, whose end answers it.
    pub(super) fn answer<W: fmt::Write>(&mut self, line: Line<'_>, out: &mut W) -> Option<Answered> {
        let reply = Reply::new(out);
        let text = match line {
            Line::Text(text) => text,
            Line::TooLong => {
                let most = protocol::MAX_LINE;
                return Some(reply.err(Code::Long, format_args!("a line has at most {most} characters")));
            }
            Line::Packet(bytes) => return self.motioncal_packet(bytes, reply),
            Line::NotText => {
                return Some(
                    reply
                        .err(Code::Usage, format_args!("a line may contain printable ASCII characters only")),
                );
            }
        };
        match protocol::parse(text) {
            Ok(command) => self.obey(command, reply),
            Err(ParseError::Unknown) => {
                Some(reply.err(Code::Unknown, format_args!("no such command; try help")))
            }
            Err(ParseError::Usage(usage)) => Some(reply.err(Code::Usage, format_args!("{usage}"))),
        }
    }

    fn obey<W: fmt::Write>(&mut self, command: Command, mut reply: Reply<'_, W>) -> Option<Answered> {
        let at_rest = self.sensor.fault() == Some(SensorFault::AtRest);
        Some(match command {
            Command::Help => {
                HELP.iter().for_each(|line| reply.line(format_args!("{line}")));
                reply.done()
            }
            Command::Version if at_rest => self.version(reply.into_out()),
            Command::CalAccept { .. }
            | Command::CalClear
            | Command::EffectAdd(_)
            | Command::EffectRemove(_)
                if at_rest =>
            {
                reply.err(Code::Store, format_args!("the store {}", SensorFault::AtRest))
            }
            Command::Version => {
                self.begin(JobPurpose::Version, StoreJob::inspect());
                return None;
            }
            Command::Status => self.status(reply),
            Command::CalStart { level } => self.cal_start(reply, level),
            Command::CalStop => self.cal_stop(reply),
            Command::CalAccept { force } => return self.cal_accept(reply, force),
            Command::CalCancel => self.cal_cancel(reply),
            Command::CalShow => self.cal_show(reply),
            Command::CalZero { begins } => self.cal_zero(reply, begins),
            Command::CalLoad(load) => self.cal_load(reply, load),
            Command::CalDump => self.cal_dump(reply),
            Command::CalClear => {
                self.begin(JobPurpose::Clear, StoreJob::erase());
                return None;
            }
            Command::CalMethod(method) => self.set_method(reply, method),
            Command::Stream(mode) => self.set_stream(reply, mode),
            Command::Cov(list) => self.cov(reply, &list),
            Command::Heading(declination_deg) => self.heading(reply, declination_deg),
            Command::Why => return self.why(reply),
            Command::EffectList => self.effect_list(reply),
            Command::EffectAdd(id) => return self.effect_add(reply, id),
            Command::EffectRemove(id) => return self.effect_remove(reply, &id),
            Command::Field(field_ut) => {
                if self.session.set_field_ut(Some(field_ut)) {
                    self.status = None;
                    reply.ok(format_args!("field_ut={:?}", Num(field_ut)))
                } else {
                    reply.err(Code::Usage, format_args!("field UT, a positive magnitude in microtesla"))
                }
            }
        })
    }

    #[inline(never)]
    pub(super) fn version<W: fmt::Write>(&self, out: &mut W) -> Answered {
        let mut reply = Reply::new(out);
        let [a, b] = self.slots().states;
        reply.line(format_args!("slots={a},{b}"));
        let [x, y, z] = self.config.sensor.board_ut_per_count().map(Num);
        reply.line(format_args!("ut_per_count={x:?},{y:?},{z:?}"));
        reply.line(format_args!(
            "samples_lost={} longest_turn_us={} stamp_jitter_us={}",
            self.samples_lost(),
            self.longest_turn_us,
            Opt(self.stamp_jitter_us)
        ));
        if self.restarts.count > 0 {
            reply.line(format_args!("last_fault={}", self.restarts.last));
        }
        reply.ok(format_args!(
            "ironout={} board={} sensor={}",
            env!("CARGO_PKG_VERSION"),
            self.config.board,
            self.config.sensor.name
        ))
    }

    #[inline(never)]
    fn status<W: fmt::Write>(&mut self, mut reply: Reply<'_, W>) -> Answered {
        let counts = self.session.counts();
        let status = match self.status {
            Some((_, status)) if self.session.state() == State::Collecting && !self.status_is_old() => status,
            _ => {
                let mut status = self.session.status();
                if let Some(loaded) = self.loading.record() {
                    (status.state, status.hint) = (self.state(), Hint::Accept);
                    (status.rms_ut, status.noise_ut) = (Some(loaded.rms_ut), Some(loaded.noise_ut));
                }
                self.status = Some((self.now_ms, status));
                status
            }
        };
        if let Some(active) = &mut self.active {
            // Late columns and the time are as of now, though nothing may be streamed.
            active.at(self.now_ms);
        }
        match self.sensor.fault() {
            Some(fault) => reply.line(format_args!("sensor {} {fault}", self.config.sensor.name)),
            None => match self.active.as_ref().map(|active| &active.live) {
                Some(Err(why)) if matches!(status.state, State::Idle) => reply.line(format_args!(
                    "hint the stored calibration is not applied: {why}; start another one with: cal start"
                )),
                Some(Ok(live)) if status.state == State::Idle => match live.waits_for() {
                    Some(column) => {
                        reply.line(format_args!("hint the calibration needs: cov {column}=VALUE"));
                    }
                    None => reply.line(format_args!(
                        "hint a calibration is in use; start another one with: cal start"
                    )),
                },
                _ if status.state == State::Collecting && self.is_level() => {
                    self.level_hint(&mut reply);
                }
                _ => match said_with_command(status.hint) {
                    Some(hint) => reply.line(format_args!("hint {hint}")),
                    None => reply.line(format_args!("hint {}", status.hint)),
                },
            },
        }
        if let Some(active) = &self.active {
            for one in active.extrapolated() {
                reply.line(format_args!("outside {one}"));
            }
        }
        if let Some(Active { live: Ok(_), monitor, .. }) = &self.active {
            let condition = monitor.condition().name();
            let (ratio, dip_ratio) = (Num(monitor.ratio()), Opt(monitor.dip_ratio().map(Num)));
            reply.line(format_args!(
                "monitor condition={condition} residual_ratio={ratio:.2} dip_ratio={dip_ratio:.2}"
            ));
        }
        self.say_tilts(&mut reply);
        self.propose_zero(&mut reply);
        if self.store_watch.is_silent() {
            let [a, b] = self.slots().states;
            reply.line(format_args!(
                "store does not answer (slots={a},{b}): check its power and wiring; the firmware retries"
            ));
        }
        // What went wrong: restarts of the firmware, lost transactions, and samples out of range.
        let faults = [self.restarts.count, self.sensor.faults()]
            .into_iter()
            .fold(counts.saturated, |sum, faults| sum.saturating_add(u64::from(faults)));
        reply.ok(format_args!(
            "state={} n={} skipped={} coverage={:.3} gap_deg={:.1} rms_ut={:.4} noise_ut={:.4} calibrated={} \
             faults={faults}",
            status.state.name(),
            counts.n,
            counts.skipped,
            Num(status.coverage),
            Num(status.gap_deg),
            Opt(status.rms_ut.map(Num)),
            Opt(status.noise_ut.map(Num)),
            u8::from(self.record().is_some()),
        ))
    }

    /// Whether a line is sent with every sample.
    pub fn streams(&self) -> bool {
        self.stream != StreamMode::Off
    }

    #[inline(never)]
    fn set_stream<W: fmt::Write>(&mut self, reply: Reply<'_, W>, mode: StreamMode) -> Answered {
        if let (true, Some(fault)) = (mode != StreamMode::Off, self.sensor.fault()) {
            return self.no_sensor(reply, fault);
        }
        let name = match mode {
            StreamMode::Off => "off",
            StreamMode::Raw => "raw",
            StreamMode::Calibrated if self.record().is_none() => {
                return reply.err(Code::State, format_args!("there is no calibration: cal start"));
            }
            StreamMode::Calibrated => "cal",
            StreamMode::MotionCal => "motioncal",
            StreamMode::Log => "log",
        };
        self.stream = mode;
        self.log.begin();
        reply.ok(format_args!("stream={name}"))
    }
}

/// A hint with the command that does it; `None` where it is done with the board in the hand.
const fn said_with_command(hint: Hint) -> Option<&'static str> {
    match hint {
        Hint::Start => Some("start a calibration with: cal start"),
        Hint::Stop => Some("enough directions covered; solve with: cal stop"),
        Hint::Accept => Some("store and apply the solution with: cal accept"),
        Hint::Again => Some("the data were rejected; start again with: cal start"),
        Hint::Move | Hint::Turn { .. } => None,
    }
}
