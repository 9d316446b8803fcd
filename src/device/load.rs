//! `cal load`: a calibration from elsewhere, which then waits for `cal accept` as a solution does.

use core::fmt;

use super::loading::NotTaken;
use super::machine::Device;
use crate::number::Num;
use crate::protocol::{Answered, Code, Load, Reply};
use crate::record::Record;
use crate::session::State;

impl Device {
    #[inline(never)]
    pub(super) fn cal_load<W: fmt::Write>(&mut self, reply: Reply<'_, W>, load: Load) -> Answered {
        if self.session.state() == State::Collecting {
            return reply
                .err(Code::State, format_args!("samples are being collected: cal stop or cal cancel first"));
        }
        match load {
            Load::Begin { bytes, crc } => match self.loading.begin(usize::from(bytes), crc) {
                Ok(()) => reply.ok(format_args!("received=0 of={bytes}")),
                Err(why) => not_taken(reply, why),
            },
            Load::Data { offset, bytes } => match self.loading.take(usize::from(offset), bytes.as_slice()) {
                Ok((received, of)) => reply.ok(format_args!("received={received} of={of}")),
                Err(why) => not_taken(reply, why),
            },
            Load::End => self.load_end(reply),
        }
    }

    #[inline(never)]
    fn load_end<W: fmt::Write>(&mut self, reply: Reply<'_, W>) -> Answered {
        if let Err(why) = self.loading.is_whole() {
            return not_taken(reply, why);
        }
        match self.loading.end(self.config.sensor.axes) {
            Ok(record) => {
                // One solution waits at a time: the last that came.
                self.session.cancel();
                self.status = None;
                reply.ok(format_args!(
                    "state={} effects={} field_ut={:?}",
                    self.state().name(),
                    record.effects.len(),
                    Num(record.calibration.field_ut)
                ))
            }
            Err(why) => reply.err(Code::Refused, format_args!("{why}")),
        }
    }

    /// Where the board stands: a calibration that was loaded waits as a solution does.
    pub(super) fn state(&self) -> State {
        if self.loading.waits() { State::Solved } else { self.session.state() }
    }

    /// The calibration that waits for `cal accept`: loaded or solved.
    #[inline(never)]
    pub(super) fn waiting(&self) -> Option<Record> {
        let mut record = match self.loading.record() {
            Some(record) => record,
            None => Record::of(self.session.solution()?),
        };
        record.axes = Some(self.config.sensor.axes);
        Some(record)
    }
}

fn not_taken<W: fmt::Write>(reply: Reply<'_, W>, why: NotTaken) -> Answered {
    let code = if why == NotTaken::Length { Code::Usage } else { Code::State };
    reply.err(code, format_args!("{why}"))
}
