//! `cal dump`: the record of the calibration, byte by byte, and how its errors hang together where that is known.

use core::fmt;

use super::machine::Device;
use crate::number::Num;
use crate::protocol::{Answered, Code, Reply};

/// Bytes of the record on one line.
const LINE_BYTES: usize = 32;

impl Device {
    /// The calibration that `cal show` shows, with every bit of it.
    #[inline(never)]
    pub(super) fn cal_dump<W: fmt::Write>(&self, mut reply: Reply<'_, W>) -> Answered {
        let stored = self.active.as_ref().map(|active| active.record);
        let Some(record) = stored.or_else(|| self.waiting()) else {
            return reply.err(Code::State, format_args!("there is no calibration: cal start"));
        };
        let encoded = match record.encode() {
            Ok(encoded) => encoded,
            Err(why) => return reply.err(Code::Store, format_args!("{why}")),
        };
        let bytes = encoded.as_bytes();
        for (line, chunk) in bytes.chunks(LINE_BYTES).enumerate() {
            reply.line(format_args!("record={} {}", line * LINE_BYTES, Hex(chunk)));
        }
        for row in record.covariance.iter().flat_map(|covariance| covariance.rows()) {
            reply.line(format_args!("covariance={}", Row(row)));
        }
        reply.ok(format_args!(
            "bytes={} sequence={} stored={} covariance={}",
            bytes.len(),
            record.sequence,
            u8::from(self.active.is_some()),
            u8::from(record.covariance.is_some()),
        ))
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
struct Row<'a>(&'a [f32]);

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
