//! Where the fields of a ULog message lie in its bytes.

use crate::input::formats::feed::bytes_at;
use std::collections::HashMap;

/// A message has at most so many bytes.
const MOST_BYTES: usize = u16::MAX as usize;
/// And so many fields, arrays written out.
const MOST_FIELDS: usize = 8192;
/// Messages in messages in messages.
const DEEPEST: usize = 8;

/// A basic type of ULog.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// 8 bits.
    I8,
    /// 8 bits; `bool` and `char` too.
    U8,
    /// 16 bits.
    I16,
    /// 16 bits.
    U16,
    /// 32 bits.
    I32,
    /// 32 bits.
    U32,
    /// 64 bits.
    I64,
    /// 64 bits.
    U64,
    /// `float`.
    F32,
    /// `double`.
    F64,
}

impl Kind {
    fn of(name: &str) -> Option<(Kind, usize)> {
        Some(match name {
            "int8_t" => (Kind::I8, 1),
            "uint8_t" | "bool" | "char" => (Kind::U8, 1),
            "int16_t" => (Kind::I16, 2),
            "uint16_t" => (Kind::U16, 2),
            "int32_t" => (Kind::I32, 4),
            "uint32_t" => (Kind::U32, 4),
            "int64_t" => (Kind::I64, 8),
            "uint64_t" => (Kind::U64, 8),
            "float" => (Kind::F32, 4),
            "double" => (Kind::F64, 8),
            _ => return None,
        })
    }
}

/// One number in the bytes of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Bytes from the beginning of the message.
    pub at: usize,
    /// How it is written.
    pub kind: Kind,
}

impl Field {
    /// Its value; NaN where the message is too short for it.
    pub fn value(self, data: &[u8]) -> f64 {
        self.read(data).unwrap_or(f64::NAN)
    }

    /// The byte behind it.
    pub fn end(self) -> usize {
        self.at
            + match self.kind {
                Kind::I8 | Kind::U8 => 1,
                Kind::I16 | Kind::U16 => 2,
                Kind::I32 | Kind::U32 | Kind::F32 => 4,
                Kind::I64 | Kind::U64 | Kind::F64 => 8,
            }
    }

    fn read(self, data: &[u8]) -> Option<f64> {
        let at = self.at;
        Some(match self.kind {
            Kind::I8 => f64::from(i8::from_le_bytes(bytes_at(data, at)?)),
            Kind::U8 => f64::from(u8::from_le_bytes(bytes_at(data, at)?)),
            Kind::I16 => f64::from(i16::from_le_bytes(bytes_at(data, at)?)),
            Kind::U16 => f64::from(u16::from_le_bytes(bytes_at(data, at)?)),
            Kind::I32 => f64::from(i32::from_le_bytes(bytes_at(data, at)?)),
            Kind::U32 => f64::from(u32::from_le_bytes(bytes_at(data, at)?)),
            Kind::I64 => i64::from_le_bytes(bytes_at(data, at)?) as f64,
            Kind::U64 => u64::from_le_bytes(bytes_at(data, at)?) as f64,
            Kind::F32 => f64::from(f32::from_le_bytes(bytes_at(data, at)?)),
            Kind::F64 => f64::from_le_bytes(bytes_at(data, at)?),
        })
    }
}

/// The fields of one message by their paths: `timestamp`, `magnetometer_ga[0]`, `esc[1].esc_current`.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    fields: HashMap<String, Field>,
}

impl Layout {
    /// The field at a path.
    pub fn field(&self, path: &str) -> Option<Field> {
        self.fields.get(path).copied()
    }
}

#[derive(Debug, Clone)]
struct Member {
    kind: String,
    count: Option<usize>,
    name: String,
}

/// The formats that a log defines.
#[derive(Debug, Clone, Default)]
pub struct Formats {
    members: HashMap<String, Vec<Member>>,
}

impl Formats {
    /// Takes the text of a format message: `name:type field;type[3] field;`. False where it is none.
    pub fn define(&mut self, text: &[u8]) -> bool {
        self.parse(text).is_some()
    }

    fn parse(&mut self, text: &[u8]) -> Option<()> {
        let (name, fields) = std::str::from_utf8(text).ok()?.split_once(':')?;
        let members = fields
            .split(';')
            .filter(|field| !field.trim().is_empty())
            .map(|field| {
                let (kind, name) = field.trim().split_once(' ')?;
                let (kind, count) = match kind.split_once('[') {
                    Some((kind, rest)) => (kind, Some(rest.strip_suffix(']')?.parse().ok()?)),
                    None => (kind, None),
                };
                Some(Member { kind: kind.into(), count, name: name.trim().into() })
            })
            .collect::<Option<Vec<Member>>>()?;
        self.members.insert(name.to_string(), members);
        Some(())
    }

    /// The layout of a format; `None` where it is not defined, refers to itself, or is larger than a message can be.
    pub fn layout(&self, name: &str) -> Option<Layout> {
        let mut layout = Layout::default();
        let mut fields_left = MOST_FIELDS;
        self.place(name, "", 0, 0, &mut layout, &mut fields_left)?;
        Some(layout)
    }

    fn place(
        &self,
        name: &str,
        prefix: &str,
        mut at: usize,
        depth: usize,
        layout: &mut Layout,
        fields_left: &mut usize,
    ) -> Option<usize> {
        if depth > DEEPEST {
            return None;
        }
        for member in self.members.get(name)? {
            for index in 0..member.count.unwrap_or(1) {
                *fields_left = fields_left.checked_sub(1)?;
                let mut path = format!("{prefix}{}", member.name);
                if member.count.is_some() {
                    path.push_str(&format!("[{index}]"));
                }
                match Kind::of(&member.kind) {
                    Some((kind, size)) => {
                        layout.fields.insert(path, Field { at, kind });
                        at += size;
                    }
                    None => {
                        path.push('.');
                        at = self.place(&member.kind, &path, at, depth + 1, layout, fields_left)?;
                    }
                }
                if at > MOST_BYTES {
                    return None;
                }
            }
        }
        Some(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_messages_and_arrays_are_laid_out() {
        let mut formats = Formats::default();
        assert!(formats.define(b"esc_report:int32_t esc_rpm;float esc_current;"));
        assert!(formats.define(b"esc_status:uint64_t timestamp;uint8_t n;esc_report[2] esc;"));
        let layout = formats.layout("esc_status").expect("sound");
        assert_eq!(layout.field("esc[1].esc_current"), Some(Field { at: 8 + 1 + 8 + 4, kind: Kind::F32 }));
        assert_eq!(layout.field("esc[2].esc_rpm"), None);
        let mut data = vec![0; 25];
        data[21..25].copy_from_slice(&1.5_f32.to_le_bytes());
        assert_eq!(layout.field("esc[1].esc_current").map(|field| field.value(&data)), Some(1.5));
        assert!(layout.field("esc[1].esc_current").expect("there").value(&data[..22]).is_nan());
    }

    #[test]
    fn hostile_definitions_end() {
        let mut formats = Formats::default();
        for text in ["a:b[30000] x;", "b:c[30000] y;", "c:", "me:me x;", "big:double[99999999999999] x;"] {
            formats.define(text.as_bytes());
        }
        for name in ["a", "me", "big", "none"] {
            assert!(formats.layout(name).is_none(), "{name}");
        }
        assert!(!formats.define(b"\xff:float x;") && !formats.define(b"x:float[3 y;"));
    }
}
