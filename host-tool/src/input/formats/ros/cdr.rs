//! Numbers and texts as ROS writes them: CDR of OMG (DDSI-RTPS 10, XTypes 7.4) with ROS 2, packed little-endian with ROS 1.

use crate::input::formats::feed::bytes_at;

/// How messages are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// `cdr`.
    Cdr,
    /// `ros1`.
    Ros1,
}

/// Reads one message from its beginning.
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    data: &'a [u8],
    at: usize,
    little: bool,
    /// Numbers stand at multiples of their size, up to this; 1 where they are packed.
    alignment: usize,
    /// The encoding, for what differs between the messages of ROS 1 and 2.
    pub encoding: Encoding,
}

impl<'a> Reader<'a> {
    /// For one message; `None` where its head names a form that is not known.
    pub fn new(data: &'a [u8], encoding: Encoding) -> Option<Self> {
        if encoding == Encoding::Ros1 {
            return Some(Reader { data, at: 0, little: true, alignment: 1, encoding });
        }
        let [0, form, _, _] = bytes_at::<4>(data, 0)? else { return None };
        let (little, alignment) = match form {
            0 | 1 => (form == 1, 8),
            // Plain CDR of the second version.
            6 | 7 => (form == 7, 4),
            _ => return None,
        };
        Some(Reader { data: data.get(4..)?, at: 0, little, alignment, encoding })
    }

    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.at = self.at.checked_next_multiple_of(N.clamp(1, self.alignment))?;
        let mut bytes: [u8; N] = bytes_at(self.data, self.at)?;
        self.at += N;
        if !self.little {
            bytes.reverse();
        }
        Some(bytes)
    }

    /// One byte.
    pub fn u8(&mut self) -> Option<u8> {
        self.bytes().map(u8::from_le_bytes)
    }

    /// 16 bits.
    pub fn u16(&mut self) -> Option<u16> {
        self.bytes().map(u16::from_le_bytes)
    }

    /// 32 bits.
    pub fn u32(&mut self) -> Option<u32> {
        self.bytes().map(u32::from_le_bytes)
    }

    /// Single precision.
    pub fn f32(&mut self) -> Option<f64> {
        self.bytes().map(f32::from_le_bytes).map(f64::from)
    }

    /// Double precision.
    pub fn f64(&mut self) -> Option<f64> {
        self.bytes().map(f64::from_le_bytes)
    }

    /// `N` doubles.
    pub fn doubles<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Some(values)
    }

    /// A text, without the zero byte at its end.
    pub fn text(&mut self) -> Option<String> {
        let length = usize::try_from(self.u32()?).ok()?;
        let bytes = self.data.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        Some(String::from_utf8_lossy(bytes).trim_end_matches('\0').to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_are_aligned_behind_the_head() {
        for little in [true, false] {
            let mut data = vec![0, u8::from(little), 0, 0, 7, 0, 0, 0];
            let three = 3_u32;
            data.extend(if little { three.to_le_bytes() } else { three.to_be_bytes() });
            data.extend(b"ab\0");
            // Up to a multiple of eight behind the head.
            data.extend([0xee; 5]);
            data.extend(if little { 1.5_f64.to_le_bytes() } else { 1.5_f64.to_be_bytes() });
            let mut reader = Reader::new(&data, Encoding::Cdr).expect("a known form");
            assert_eq!(reader.u8(), Some(7));
            assert_eq!(reader.text().as_deref(), Some("ab"));
            assert_eq!(reader.f64(), Some(1.5));
            assert_eq!(reader.u8(), None);
        }
        assert!(Reader::new(&[0, 3, 0, 0], Encoding::Cdr).is_none());
        assert!(Reader::new(&[0, 1], Encoding::Cdr).is_none());
        let endless = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 1];
        assert_eq!(Reader::new(&endless, Encoding::Cdr).and_then(|mut reader| reader.text()), None);
    }
}
