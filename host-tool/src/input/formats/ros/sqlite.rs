//! Tables of an SQLite file, read from its bytes (sqlite.org/fileformat2.html): what rosbag2 writes, and no SQL. Written here and not
//! taken from SQLite itself, so that a browser reads what the desk reads, and that a broken file is no more than broken.

use crate::input::formats::feed::bytes_at;
use std::borrow::Cow;

/// Mark at the beginning of the file.
pub const MARK: &[u8] = b"SQLite format 3\0";
const HEADER_BYTES: usize = 100;
const LEAF: u8 = 0x0d;
const INTERIOR: u8 = 0x05;

/// A value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'a> {
    /// None.
    Null,
    /// A whole number.
    Int(i64),
    /// A number.
    Real(f64),
    /// Text or bytes.
    Bytes(&'a [u8]),
}

impl Value<'_> {
    /// The whole number that it is.
    pub fn int(self) -> Option<i64> {
        match self {
            Value::Int(value) => Some(value),
            _ => None,
        }
    }

    /// The text that it is.
    pub fn text(self) -> Option<String> {
        match self {
            Value::Bytes(bytes) => Some(String::from_utf8_lossy(bytes).into_owned()),
            _ => None,
        }
    }
}

/// A table: its first page and the names of its columns in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    root: usize,
    columns: Vec<String>,
}

impl Table {
    /// The place of a column.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
}

/// A file in memory.
#[derive(Debug, Clone, Copy)]
pub struct Database<'a> {
    data: &'a [u8],
    page_bytes: usize,
    usable: usize,
    /// Whether newest changes may stand in a file next to it.
    pub has_wal: bool,
}

impl<'a> Database<'a> {
    /// Of the bytes of a file; `None` where its head makes no sense, or its text is not UTF-8.
    pub fn open(data: &'a [u8]) -> Option<Self> {
        let page_bytes = match u16::from_be_bytes(bytes_at(data.strip_prefix(MARK).map(|_| data)?, 16)?) {
            1 => 65536,
            bytes => usize::from(bytes),
        };
        let usable = page_bytes.checked_sub(usize::from(*data.get(20)?))?;
        let encoding = u32::from_be_bytes(bytes_at(data, 56)?);
        let sound = page_bytes.is_power_of_two() && page_bytes >= 512 && usable >= 480 && encoding <= 1;
        sound.then_some(Database { data, page_bytes, usable, has_wal: data.get(18) == Some(&2) })
    }

    /// The table of that name.
    pub fn table(&self, name: &str) -> Option<Table> {
        let mut found = None;
        self.rows(1, &mut |_, values| {
            let text = |place: usize| values.get(place).copied().and_then(Value::text);
            let is = text(0).as_deref() == Some("table") && text(1).as_deref() == Some(name);
            let root =
                values.get(3).and_then(|value| value.int()).and_then(|root| usize::try_from(root).ok());
            if let (true, Some(root), Some(sql)) = (is, root, text(4)) {
                found = Some(Table { root, columns: columns(&sql) });
            }
        });
        found
    }

    /// Every row of a table: its number and its values. Gives how many rows or pages could not be read.
    pub fn each(&self, table: &Table, take: &mut dyn FnMut(i64, &[Value<'_>])) -> u64 {
        self.rows(table.root, take)
    }

    fn page(&self, number: usize) -> Option<&'a [u8]> {
        let from = number.checked_sub(1)?.checked_mul(self.page_bytes)?;
        // The last page of a file that is cut off is whole in part.
        let end = from.checked_add(self.page_bytes)?.min(self.data.len());
        self.data.get(from..end).filter(|page| !page.is_empty())
    }

    fn rows(&self, root: usize, take: &mut dyn FnMut(i64, &[Value<'_>])) -> u64 {
        let pages = self.data.len().div_ceil(self.page_bytes);
        let mut seen = vec![false; pages + 1];
        let (mut left, mut broken, mut values) = (vec![root], 0, Vec::new());
        while let Some(number) = left.pop() {
            // A page that comes twice is one of a circle.
            let fresh = seen.get_mut(number).map(|seen| !std::mem::replace(seen, true)).unwrap_or(false);
            let Some(page) = self.page(number).filter(|_| fresh) else {
                broken += 1;
                continue;
            };
            let at = if number == 1 { HEADER_BYTES } else { 0 };
            let count = bytes_at(page, at + 3).map_or(0, u16::from_be_bytes);
            let pointers = |head: usize| (0..usize::from(count)).map(move |cell| at + head + 2 * cell);
            let cell =
                |pointer: usize| bytes_at(page, pointer).map(|bytes| usize::from(u16::from_be_bytes(bytes)));
            match page.get(at) {
                Some(&INTERIOR) => {
                    let child = |at: usize| Some(u32::from_be_bytes(bytes_at(page, at)?) as usize);
                    let mut children: Vec<usize> = pointers(12).filter_map(|p| child(cell(p)?)).collect();
                    children.extend(child(at + 8));
                    // From the first on: the last that is put away is the next that is taken.
                    left.extend(children.into_iter().rev());
                }
                Some(&LEAF) => {
                    for pointer in pointers(8) {
                        let row = cell(pointer).and_then(|at| self.payload(page, at));
                        let whole =
                            row.as_ref().is_some_and(|(_, payload)| record(payload, &mut values).is_some());
                        match row {
                            Some((rowid, _)) if whole => {
                                take(rowid, &own(&values, row.as_ref().map(|(_, p)| &**p)))
                            }
                            _ => broken += 1,
                        }
                    }
                }
                _ => broken += 1,
            }
        }
        broken
    }

    /// Number and payload of the cell at a place of a leaf.
    fn payload(&self, page: &'a [u8], at: usize) -> Option<(i64, Cow<'a, [u8]>)> {
        let (length, at) = varint(page, at)?;
        let (rowid, at) = varint(page, at)?;
        let length = usize::try_from(length).ok().filter(|length| *length <= self.data.len())?;
        let most = self.usable - 35;
        if length <= most {
            return Some((rowid, Cow::Borrowed(page.get(at..at.checked_add(length)?)?)));
        }
        let least = (self.usable - 12) * 32 / 255 - 23;
        let local = least + (length - least) % (self.usable - 4);
        let local = if local <= most { local } else { least };
        let mut payload = page.get(at..at + local)?.to_vec();
        let mut next = u32::from_be_bytes(bytes_at(page, at + local)?) as usize;
        while payload.len() < length {
            let more = self.page(next)?;
            let count = (length - payload.len()).min(self.usable - 4);
            payload.extend(more.get(4..4 + count)?);
            next = u32::from_be_bytes(bytes_at(more, 0)?) as usize;
        }
        Some((rowid, Cow::Owned(payload)))
    }
}

/// Where a value lies in a payload, and what it is.
#[derive(Debug, Clone, Copy)]
enum Place {
    Value(Value<'static>),
    Bytes(usize, usize),
}

/// The values of a record, by their places; `None` where it is not whole.
fn record(payload: &[u8], places: &mut Vec<Place>) -> Option<()> {
    places.clear();
    let (head, mut at) = varint(payload, 0)?;
    let head = usize::try_from(head).ok()?;
    let mut body = head;
    while at < head {
        let (kind, next) = varint(payload, at)?;
        at = next;
        let mut whole = |bytes: usize| {
            let from = payload.get(body..body + bytes)?;
            body += bytes;
            let negative = from.first().is_some_and(|byte| byte & 0x80 != 0);
            let start = if negative { -1_i64 } else { 0 };
            Some(from.iter().fold(start, |value, byte| (value << 8) | i64::from(*byte)))
        };
        places.push(match kind {
            0 => Place::Value(Value::Null),
            1..=4 => Place::Value(Value::Int(whole(usize::try_from(kind).ok()?)?)),
            5 => Place::Value(Value::Int(whole(6)?)),
            6 => Place::Value(Value::Int(whole(8)?)),
            7 => Place::Value(Value::Real(f64::from_bits(whole(8)?.cast_unsigned()))),
            8 | 9 => Place::Value(Value::Int(kind - 8)),
            12.. => {
                let length = usize::try_from((kind - 12) / 2).ok()?;
                let end = body.checked_add(length).filter(|end| *end <= payload.len())?;
                let place = Place::Bytes(body, end);
                body = end;
                place
            }
            _ => return None,
        });
    }
    Some(())
}

fn own<'p>(places: &[Place], payload: Option<&'p [u8]>) -> Vec<Value<'p>> {
    let payload = payload.unwrap_or_default();
    let value = |place: &Place| match *place {
        Place::Value(value) => value,
        Place::Bytes(from, end) => Value::Bytes(payload.get(from..end).unwrap_or_default()),
    };
    places.iter().map(value).collect()
}

/// A number of one to nine bytes, and the place behind it.
fn varint(bytes: &[u8], at: usize) -> Option<(i64, usize)> {
    let mut value = 0_u64;
    for index in 0..8 {
        let byte = *bytes.get(at.checked_add(index)?)?;
        value = (value << 7) | u64::from(byte & 0x7f);
        if byte < 0x80 {
            return Some((value.cast_signed(), at + index + 1));
        }
    }
    let byte = *bytes.get(at.checked_add(8)?)?;
    Some((((value << 8) | u64::from(byte)).cast_signed(), at + 9))
}

/// Names of the columns that a `CREATE TABLE` lists.
fn columns(sql: &str) -> Vec<String> {
    let inside = sql.split_once('(').map_or("", |(_, rest)| rest);
    let name = |part: &str| {
        let word = part.split_whitespace().next().unwrap_or_default();
        word.trim_matches(['"', '`', '[', ']', ')']).to_ascii_lowercase()
    };
    inside.split(',').map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_records_and_names() {
        assert_eq!(varint(&[0x7f], 0), Some((127, 1)));
        assert_eq!(varint(&[0x81, 0x00], 0), Some((128, 2)));
        assert_eq!(varint(&[0xff; 9], 0), Some((-1, 9)));
        assert_eq!(varint(&[0x81], 0), None);
        let mut places = Vec::new();
        // Head of six bytes: null, -2 in one byte, 300 in two, the constant 1, a text of two bytes.
        let payload = [6, 0, 1, 2, 9, 17, 0xfe, 0x01, 0x2c, b'a', b'b'];
        record(&payload, &mut places).expect("whole");
        let values = own(&places, Some(&payload));
        let wanted = [Value::Null, Value::Int(-2), Value::Int(300), Value::Int(1), Value::Bytes(b"ab")];
        assert_eq!(values, wanted);
        assert_eq!(record(&payload[..10], &mut places), None);
        let sql = "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL, timestamp INTEGER, data BLOB)";
        assert_eq!(columns(sql), ["id", "topic_id", "timestamp", "data"]);
        assert!(Database::open(b"SQLite format 3").is_none() && Database::open(&[0; 200]).is_none());
    }
}
