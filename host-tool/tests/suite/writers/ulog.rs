//! A ULog file, from its specification (docs.px4.io, "ULog File Format").

/// A file that grows by records.
pub struct Ulog {
    pub bytes: Vec<u8>,
}

/// A value of a parameter.
pub enum Value {
    Int(i32),
    Float(f32),
}

impl Ulog {
    pub fn new(start_us: u64) -> Self {
        let mut bytes = b"ULog\x01\x12\x35\x01".to_vec();
        bytes.extend(start_us.to_le_bytes());
        let mut file = Ulog { bytes };
        file.record(b'B', &[0; 40]);
        file
    }

    pub fn record(&mut self, kind: u8, data: &[u8]) {
        self.bytes.extend((data.len() as u16).to_le_bytes());
        self.bytes.push(kind);
        self.bytes.extend(data);
    }

    pub fn format(&mut self, text: &str) {
        self.record(b'F', text.as_bytes());
    }

    fn keyed(&mut self, record: u8, key: &str, value: &[u8]) {
        let mut data = vec![key.len() as u8];
        data.extend(key.as_bytes());
        data.extend(value);
        self.record(record, &data);
    }

    pub fn info(&mut self, name: &str, value: &str) {
        self.keyed(b'I', &format!("char[{}] {name}", value.len()), value.as_bytes());
    }

    pub fn parameter(&mut self, name: &str, value: Value) {
        match value {
            Value::Int(value) => self.keyed(b'P', &format!("int32_t {name}"), &value.to_le_bytes()),
            Value::Float(value) => self.keyed(b'P', &format!("float {name}"), &value.to_le_bytes()),
        }
    }

    pub fn subscribe(&mut self, instance: u8, id: u16, name: &str) {
        let mut data = vec![instance];
        data.extend(id.to_le_bytes());
        data.extend(name.as_bytes());
        self.record(b'A', &data);
    }

    pub fn data(&mut self, id: u16, fields: &[&[u8]]) {
        let mut data = id.to_le_bytes().to_vec();
        fields.iter().for_each(|field| data.extend(*field));
        self.record(b'D', &data);
    }

    pub fn sync(&mut self) {
        self.record(b'S', &[0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12]);
    }
}

/// Three numbers in single precision.
pub fn floats(values: [f64; 3]) -> [u8; 12] {
    let mut bytes = [0; 12];
    for (cell, value) in bytes.chunks_exact_mut(4).zip(values) {
        cell.copy_from_slice(&(value as f32).to_le_bytes());
    }
    bytes
}
