//! A calibration that MotionCal sends while its stream is on.

use core::fmt;

use super::loading::NotLoaded;
use super::machine::Device;
use crate::extended::Effects;
use crate::fit::{Method, Order};
use crate::protocol::{Answered, Code, PACKET_BYTES, Packet, Reply};
use crate::record::{PredictedError, Record};
use crate::session::State;

impl Device {
    /// Takes a packet: its numbers are sent back in MotionCal's own lines, and what it holds is stored and applied as by `cal
    /// accept`. `None` where that has begun.
    #[inline(never)]
    pub(super) fn motioncal_packet<W: fmt::Write>(
        &mut self,
        bytes: &[u8; PACKET_BYTES],
        reply: Reply<'_, W>,
    ) -> Option<Answered> {
        let Some(packet) = Packet::read(bytes) else {
            return Some(
                reply.err(Code::Usage, format_args!("the packet is damaged: send the calibration again")),
            );
        };
        if self.session.state() == State::Collecting {
            return Some(reply.err(
                Code::State,
                format_args!("samples are being collected: cal stop or cal cancel first"),
            ));
        }
        if let Err(why) = self.load_packet(&packet) {
            return Some(reply.err(Code::Refused, format_args!("{why}")));
        }
        self.session.cancel();
        self.status = None;
        let out = reply.into_out();
        // As with any other line: an output that fails has nobody at its end.
        let _ = write!(out, "{packet}");
        self.cal_accept(Reply::new(out), false)
    }

    /// Makes a record of it, which waits to be accepted. Apart, so that the record has left the stack by then.
    #[inline(never)]
    fn load_packet(&mut self, Packet(calibration): &Packet) -> Result<(), NotLoaded> {
        let record = Record {
            sequence: 0,
            calibration: calibration.cast(),
            effects: Effects::none(),
            method: Method::Constant,
            model: Order::Ellipsoid,
            // What is not known of it.
            samples: 0,
            noise_ut: 0.0,
            rms_ut: 0.0,
            axes: Some(self.config.sensor.axes),
            predicted_error: PredictedError::UNKNOWN,
            covariance: None,
            holds_for: None,
        };
        self.loading.take_record(&record, self.config.sensor.axes).map(|_| ())
    }
}
