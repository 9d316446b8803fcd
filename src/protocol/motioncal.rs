//! The calibration that the program MotionCal sends: 68 bytes, no line.
//!
//! Bytes 117 and 84, sixteen numbers in single precision, lowest byte first, and a CRC-16 of all before it (polynomial 0x8005
//! reflected, begun with ones). The numbers: offsets of the accelerometer (3, m/s²) and of the gyro (3), which MotionCal leaves zero;
//! the hard iron (3, µT); the field (µT); the soft iron, a symmetric matrix: its diagonal (3), then xy, xz, yz. What is measured
//! becomes `matrix · (measured − hard iron)`. Source: MotionCal by Paul Stoffregen, `rawdata.c`, and the sketches that receive it.

use core::fmt;

use crate::calibration::Calibration;
use crate::number::Num;
use crc::{CRC_16_MODBUS, Crc, NoTable};

/// Bytes of a packet.
pub const PACKET_BYTES: usize = 68;
/// The two that it begins with.
pub const PACKET_BEGINS: [u8; 2] = [117, 84];

// Without a table, which is half a kilobyte for a packet now and then.
const CRC: Crc<u16, NoTable> = Crc::<u16, NoTable>::new(&CRC_16_MODBUS);
const CRC_BYTES: usize = 2;
const NUMBERS: usize = 16;

/// What a packet says of the magnetometer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Packet(pub Calibration<f32>);

impl Packet {
    /// Reads one; `None` where it is none, or not what was sent.
    pub fn read(bytes: &[u8; PACKET_BYTES]) -> Option<Self> {
        let (body, crc) = bytes.split_last_chunk::<CRC_BYTES>()?;
        if CRC.checksum(body) != u16::from_le_bytes(*crc) {
            return None;
        }
        let rest = body.strip_prefix(&PACKET_BEGINS)?;
        let mut numbers = [0.0; NUMBERS];
        for (number, bytes) in numbers.iter_mut().zip(rest.chunks_exact(4)) {
            *number = f32::from_le_bytes(bytes.try_into().ok()?);
        }
        let [_, _, _, _, _, _, x, y, z, field_ut, xx, yy, zz, xy, xz, yz] = numbers;
        let matrix = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        Some(Self(Calibration { offset_ut: [x, y, z], matrix, field_ut }))
    }

    /// The bytes of it, as MotionCal sends them.
    pub fn bytes(&self) -> [u8; PACKET_BYTES] {
        let Self(Calibration { offset_ut: [x, y, z], matrix, field_ut }) = self;
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = matrix;
        let numbers = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, *x, *y, *z, *field_ut, *xx, *yy, *zz, *xy, *xz, *yz];
        let mut bytes = [0; PACKET_BYTES];
        let all = PACKET_BEGINS.into_iter().chain(numbers.into_iter().flat_map(f32::to_le_bytes));
        for (place, byte) in bytes.iter_mut().zip(all) {
            *place = byte;
        }
        if let Some((body, crc)) = bytes.split_last_chunk_mut::<CRC_BYTES>() {
            *crc = CRC.checksum(body).to_le_bytes();
        }
        bytes
    }
}

/// The two lines by which MotionCal knows that its packet has come: the numbers again.
impl fmt::Display for Packet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Calibration { offset_ut: [x, y, z], matrix, field_ut }) = self;
        let (x, y, z, field_ut) = (Num(*x), Num(*y), Num(*z), Num(*field_ut));
        writeln!(f, "Cal1:0.0,0.0,0.0,0.0,0.0,0.0,{x:?},{y:?},{z:?},{field_ut:?}")?;
        f.write_str("Cal2:")?;
        for (index, value) in matrix.iter().flatten().enumerate() {
            write!(f, "{}{:?}", if index == 0 { "" } else { "," }, Num(*value))?;
        }
        f.write_str("\n")
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{PACKET_BYTES, Packet};
    use crate::calibration::Calibration;
    use std::string::ToString;
    use std::vec::Vec;

    fn packet() -> Packet {
        Packet(Calibration {
            offset_ut: [12.5, -30.25, 0.1],
            matrix: [[1.01, 0.02, -0.03], [0.02, 0.99, 0.004], [-0.03, 0.004, 1.1]],
            field_ut: 48.5,
        })
    }

    /// The checksum as MotionCal works it out, bit by bit.
    fn crc16(bytes: &[u8]) -> u16 {
        bytes.iter().fold(0xffff, |crc, byte| {
            (0..8).fold(
                crc ^ u16::from(*byte),
                |crc: u16, _| {
                    if crc & 1 != 0 { (crc >> 1) ^ 0xa001 } else { crc >> 1 }
                },
            )
        })
    }

    #[test]
    fn a_packet_is_laid_out_as_motioncal_does_it() {
        let bytes = packet().bytes();
        let mut expected: Vec<u8> = Vec::from([117, 84]);
        for number in
            [0.0_f32, 0.0, 0.0, 0.0, 0.0, 0.0, 12.5, -30.25, 0.1, 48.5, 1.01, 0.99, 1.1, 0.02, -0.03, 0.004]
        {
            expected.extend_from_slice(&number.to_bits().to_le_bytes());
        }
        let crc = crc16(&expected);
        expected.extend_from_slice(&[crc as u8, (crc >> 8) as u8]);
        assert_eq!(expected.len(), PACKET_BYTES);
        assert_eq!(bytes[..], expected[..]);
        assert_eq!(Packet::read(&bytes), Some(packet()));
        assert_eq!(
            packet().to_string(),
            "Cal1:0.0,0.0,0.0,0.0,0.0,0.0,12.5,-30.25,0.1,48.5\nCal2:1.01,0.02,-0.03,0.02,0.99,0.004,-0.03,0.004,1.1\n"
        );
    }

    #[test]
    fn any_bit_that_flips_is_noticed() {
        let bytes = packet().bytes();
        for bit in 0..8 * PACKET_BYTES {
            let mut spoilt = bytes;
            spoilt[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Packet::read(&spoilt), None, "bit {bit}");
        }
    }
}
