//! A bag of rosbag2 in SQLite, from the format of the file (sqlite.org/fileformat2.html).

/// Bytes of a page: small, so that a bag has many pages and its longest messages flow over.
const PAGE: usize = 512;
const USABLE: usize = PAGE;

/// A value of a row.
pub enum Value<'a> {
    Null,
    Int(i64),
    Text(&'a str),
    Blob(&'a [u8]),
}

fn varint(value: u64, out: &mut Vec<u8>) {
    let mut groups = vec![(value & 0x7f) as u8];
    let mut rest = value >> 7;
    while rest > 0 {
        groups.push((rest & 0x7f) as u8 | 0x80);
        rest >>= 7;
    }
    out.extend(groups.iter().rev());
}

fn record(values: &[Value]) -> Vec<u8> {
    let (mut kinds, mut body) = (Vec::new(), Vec::new());
    for value in values {
        match value {
            Value::Null => kinds.push(0),
            Value::Int(value) => {
                varint(6, &mut kinds);
                body.extend(value.to_be_bytes());
            }
            Value::Text(text) => {
                varint(13 + 2 * text.len() as u64, &mut kinds);
                body.extend(text.bytes());
            }
            Value::Blob(bytes) => {
                varint(12 + 2 * bytes.len() as u64, &mut kinds);
                body.extend(*bytes);
            }
        }
    }
    assert!(kinds.len() < 127);
    let mut out = vec![kinds.len() as u8 + 1];
    out.extend(kinds);
    out.extend(body);
    out
}

/// Tables of rows by their number, each a tree of two levels.
pub struct Sqlite {
    pages: Vec<Vec<u8>>,
}

impl Sqlite {
    /// A bag with these topics (name, type) and messages (topic from 1, ns, bytes).
    pub fn bag(topics: &[(&str, &str)], messages: &[(i64, i64, Vec<u8>)]) -> Vec<u8> {
        let mut file = Sqlite { pages: vec![Vec::new()] };
        let rows = topics.iter().map(|(name, kind)| {
            record(&[Value::Null, Value::Text(name), Value::Text(kind), Value::Text("cdr"), Value::Text("")])
        });
        let topics_root = file.table(rows.collect());
        let rows = messages.iter().map(|(topic, ns, data)| {
            record(&[Value::Null, Value::Int(*topic), Value::Int(*ns), Value::Blob(data)])
        });
        let messages_root = file.table(rows.collect());
        let topics_sql = "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,\
                          serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL)";
        let messages_sql = "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, \
                            data BLOB NOT NULL)";
        let schema = [("topics", topics_root, topics_sql), ("messages", messages_root, messages_sql)].map(
            |(name, root, sql)| {
                record(&[
                    Value::Text("table"),
                    Value::Text(name),
                    Value::Text(name),
                    Value::Int(root as i64),
                    Value::Text(sql),
                ])
            },
        );
        let cells: Vec<Vec<u8>> =
            schema.iter().enumerate().map(|(i, row)| file.cell(i as u64 + 1, row)).collect();
        file.pages[0] = page(0x0d, &cells, None, 100);
        let mut head = b"SQLite format 3\0".to_vec();
        head.extend((PAGE as u16).to_be_bytes());
        head.extend([1, 1, 0, 64, 32, 32]);
        head.extend(1_u32.to_be_bytes());
        head.extend((file.pages.len() as u32).to_be_bytes());
        head.extend([0; 8]);
        head.extend([0, 0, 0, 1, 0, 0, 0, 4]);
        head.extend([0; 8]);
        // Text in UTF-8.
        head.extend([0, 0, 0, 1]);
        head.extend([0; 32]);
        head.extend(1_u32.to_be_bytes());
        head.extend(3_040_001_u32.to_be_bytes());
        assert_eq!(head.len(), 100);
        file.pages[0][..100].copy_from_slice(&head);
        file.pages.concat()
    }

    /// A cell of a leaf; what does not fit goes to pages of its own.
    fn cell(&mut self, rowid: u64, payload: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        varint(payload.len() as u64, &mut out);
        varint(rowid, &mut out);
        let most = USABLE - 35;
        if payload.len() <= most {
            out.extend(payload);
            return out;
        }
        let least = (USABLE - 12) * 32 / 255 - 23;
        let local = least + (payload.len() - least) % (USABLE - 4);
        let local = if local <= most { local } else { least };
        out.extend(&payload[..local]);
        out.extend((self.pages.len() as u32 + 1).to_be_bytes());
        let parts: Vec<&[u8]> = payload[local..].chunks(USABLE - 4).collect();
        for (index, part) in parts.iter().enumerate() {
            let next = if index + 1 < parts.len() { self.pages.len() as u32 + 2 } else { 0 };
            let mut page = next.to_be_bytes().to_vec();
            page.extend(*part);
            page.resize(PAGE, 0);
            self.pages.push(page);
        }
        out
    }

    /// Gives the root.
    fn table(&mut self, rows: Vec<Vec<u8>>) -> usize {
        let (mut level, mut cells, mut used): (Vec<(usize, u64)>, Vec<Vec<u8>>, usize) =
            (Vec::new(), Vec::new(), 8);
        let count = rows.len() as u64;
        for (index, row) in rows.iter().enumerate() {
            let rowid = index as u64 + 1;
            let cell = self.cell(rowid, row);
            if used + cell.len() + 2 > USABLE {
                self.pages.push(page(0x0d, &cells, None, 0));
                level.push((self.pages.len(), rowid - 1));
                (cells, used) = (Vec::new(), 8);
            }
            used += cell.len() + 2;
            cells.push(cell);
        }
        self.pages.push(page(0x0d, &cells, None, 0));
        level.push((self.pages.len(), count));
        while level.len() > 1 {
            let mut above = Vec::new();
            for part in level.chunks(30) {
                let (last, key) = part[part.len() - 1];
                let cells: Vec<Vec<u8>> = part[..part.len() - 1]
                    .iter()
                    .map(|(child, key)| {
                        let mut cell = (*child as u32).to_be_bytes().to_vec();
                        varint(*key, &mut cell);
                        cell
                    })
                    .collect();
                self.pages.push(page(0x05, &cells, Some(last as u32), 0));
                above.push((self.pages.len(), key));
            }
            level = above;
        }
        level[0].0
    }
}

/// A page of these cells, which stand at its end.
fn page(kind: u8, cells: &[Vec<u8>], last: Option<u32>, before: usize) -> Vec<u8> {
    let mut page = vec![0; PAGE];
    let mut end = PAGE;
    let head = before + if last.is_some() { 12 } else { 8 };
    for (index, cell) in cells.iter().enumerate() {
        end -= cell.len();
        assert!(end >= head + 2 * cells.len(), "a page holds its cells");
        page[end..end + cell.len()].copy_from_slice(cell);
        page[head + 2 * index..head + 2 * index + 2].copy_from_slice(&(end as u16).to_be_bytes());
    }
    page[before] = kind;
    page[before + 3..before + 5].copy_from_slice(&(cells.len() as u16).to_be_bytes());
    page[before + 5..before + 7].copy_from_slice(&(end as u16).to_be_bytes());
    if let Some(last) = last {
        page[before + 8..before + 12].copy_from_slice(&last.to_be_bytes());
    }
    page
}
