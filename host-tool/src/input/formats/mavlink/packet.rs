//! The packets of a telemetry log (mavlink.io, "Packet Serialization"): eight bytes of time, then a packet of version 1 or 2.

use crate::input::formats::feed::bytes_at;

/// Times of a log lie between 2000 and 2100, µs since 1970.
const TIMES_US: std::ops::Range<u64> = 946_684_800_000_000..4_102_444_800_000_000;
/// Bytes of the time before a packet.
pub const TIME_BYTES: usize = 8;
/// Bytes of the longest packet, with its time.
pub const MOST_BYTES: usize = TIME_BYTES + 10 + 255 + 2 + 13;

/// One packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet<'a> {
    /// When the ground station had it, µs since 1970.
    pub stamp_us: u64,
    /// Number of the vehicle, and of the part of it.
    pub system: [u8; 2],
    /// Number of the message.
    pub id: u32,
    /// Its content. Zeros at the end are not sent by version 2.
    pub payload: &'a [u8],
    /// Bytes with the time.
    pub length: usize,
    covered: &'a [u8],
    checksum: u16,
}

impl<'a> Packet<'a> {
    /// At the beginning of `bytes`; `None` where there is none.
    pub fn at(bytes: &'a [u8]) -> Option<Self> {
        let stamp_us = u64::from_be_bytes(bytes_at(bytes, 0)?);
        if !TIMES_US.contains(&stamp_us) {
            return None;
        }
        let packet = bytes.get(TIME_BYTES..)?;
        let payload_bytes = usize::from(*packet.get(1)?);
        let (head, signature, system, id) = match *packet.first()? {
            0xfe => (6, 0, bytes_at(packet, 3)?, u32::from(*packet.get(5)?)),
            0xfd => {
                let [a, b, c] = bytes_at(packet, 7)?;
                let signed = packet.get(2)? & 1 != 0;
                (10, if signed { 13 } else { 0 }, bytes_at(packet, 5)?, u32::from_le_bytes([a, b, c, 0]))
            }
            _ => return None,
        };
        let payload = packet.get(head..head + payload_bytes)?;
        let end = head + payload_bytes;
        Some(Packet {
            stamp_us,
            system,
            id,
            payload,
            length: TIME_BYTES + end + 2 + signature,
            covered: packet.get(1..end)?,
            checksum: u16::from_le_bytes(bytes_at(packet, end)?),
        })
    }

    /// Whether its checksum is right, for a message whose definition has this number of its own.
    pub fn is_whole(&self, extra: u8) -> bool {
        let sum = self.covered.iter().chain([&extra]).fold(0xffff_u16, |sum, byte| {
            let mut low = byte ^ (sum & 0xff) as u8;
            low ^= low << 4;
            let low = u16::from(low);
            (sum >> 8) ^ (low << 8) ^ (low << 3) ^ (low >> 4)
        });
        sum == self.checksum
    }
}

/// Whether a file begins with packets, each behind its time.
pub fn is_log(first: &[u8]) -> bool {
    let mut rest = first;
    for _ in 0..2 {
        let Some(packet) = Packet::at(rest) else { return false };
        rest = rest.get(packet.length..).unwrap_or_default();
        if rest.is_empty() {
            return true;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heartbeat_is_read_and_a_spoilt_one_is_told() {
        let mut bytes = 1_700_000_000_000_000_u64.to_be_bytes().to_vec();
        // A heartbeat as pymavlink writes it: sequence 0, system 1, component 1.
        bytes.extend([0xfe, 9, 0, 1, 1, 0, 0, 0, 0, 0, 2, 3, 81, 4, 3]);
        let sum = [9_u8, 0, 1, 1, 0, 0, 0, 0, 0, 2, 3, 81, 4, 3, 50].iter().fold(0xffff_u16, |sum, byte| {
            // Bit by bit, as the checksum is defined: x¹⁶ + x¹² + x⁵ + 1, reflected.
            (0..8).fold(
                sum ^ u16::from(*byte),
                |sum, _| if sum & 1 == 1 { (sum >> 1) ^ 0x8408 } else { sum >> 1 },
            )
        });
        bytes.extend(sum.to_le_bytes());
        let packet = Packet::at(&bytes).expect("a packet");
        assert_eq!((packet.id, packet.system, packet.length), (0, [1, 1], bytes.len()));
        assert!(packet.is_whole(50) && !packet.is_whole(51) && is_log(&bytes));
        bytes[18] ^= 1;
        assert!(Packet::at(&bytes).is_some_and(|packet| !packet.is_whole(50)));
        assert!(!is_log(&bytes[1..]) && !is_log(b"t_s,mx_ut,my_ut,mz_ut\n"));
    }
}
