//! `cal dump`: the record of the calibration, byte by byte, and how its errors hang together where that is known.

use core::fmt;

use super::machine::Device;
use crate::fit::Spread;
use crate::number::Num;
use crate::protocol::{Answered, Code, Reply};

/// Bytes of the record on one line.
const LINE_BYTES: usize = 32;

impl Device {
    /// The calibration that `cal show` shows, with every bit of it.
    #[inline(never)]
    pub(super) fn cal_dump<W: fmt::Write>(&self, mut reply: Reply<'_, W>) -> Answered {
        let stored = self.active.as_ref().map(|active| (active.record, active.spread));
        let of_session = || self.session.solution().map(|report| report.spread);
        let Some((record, spread)) = stored.or_else(|| Some((self.waiting()?, of_session()))) else {
            return reply.err(Code::State, format_args!("there is no calibration: cal start begins one"));
        };
        let encoded = match record.encode() {
            Ok(encoded) => encoded,
            Err(why) => return reply.err(Code::Store, format_args!("{why}")),
        };
        let bytes = encoded.as_bytes();
        for (line, chunk) in bytes.chunks(LINE_BYTES).enumerate() {
            reply.line(format_args!("record={} {}", line * LINE_BYTES, Hex(chunk)));
        }
        if let Some(spread) = spread {
            let covariance = spread.covariance();
            for (row, values) in covariance.iter().enumerate() {
                reply.line(format_args!("covariance={}", Row(values.get(row..).unwrap_or_default())));
            }
        }
        reply.ok(format_args!(
            "bytes={} sequence={} stored={} covariance={}",
            bytes.len(),
            record.sequence,
            u8::from(self.active.is_some()),
            u8::from(spread.is_some()),
        ))
    }

    /// How the errors of the solution hang together, for the calibration that it becomes.
    pub(super) fn spread_of_solution(&self) -> Option<Spread> {
        let solved = self.session.solution().filter(|_| !self.loading.waits());
        solved.map(|report| report.spread)
    }
}

/// Bytes as two hexadecimal digits each.
struct Hex<'a>(&'a [u8]);

impl fmt::Display for Hex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Numbers that read back to the same bits, separated by commas.
struct Row<'a>(&'a [f64]);

impl fmt::Display for Row<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().enumerate().try_for_each(|(i, value)| {
            if i > 0 {
                f.write_str(",")?;
            }
            write!(f, "{:?}", Num(*value))
        })
    }
}
