//! A telemetry log, from mavlink.io ("Packet Serialization") and common.xml.

/// The checksum, bit by bit as it is defined.
fn checksum(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xffff, |sum, byte| {
        (0..8)
            .fold(sum ^ u16::from(*byte), |sum, _| if sum & 1 == 1 { (sum >> 1) ^ 0x8408 } else { sum >> 1 })
    })
}

/// One packet of version 1 or 2 behind its time.
pub fn packet(version: u8, stamp_us: u64, id: u8, extra: u8, payload: &[u8]) -> Vec<u8> {
    let mut payload = payload.to_vec();
    let mut body = if version == 1 {
        vec![payload.len() as u8, 7, 1, 1, id]
    } else {
        // Zeros at the end are not sent.
        while payload.len() > 1 && payload.last() == Some(&0) {
            payload.pop();
        }
        vec![payload.len() as u8, 0, 0, 7, 1, 1, id, 0, 0]
    };
    body.extend(payload);
    let sum = checksum(&[&body[..], &[extra]].concat());
    let mut out = stamp_us.to_be_bytes().to_vec();
    out.push(if version == 1 { 0xfe } else { 0xfd });
    out.extend(body);
    out.extend(sum.to_le_bytes());
    out
}

/// `HEARTBEAT` of an ArduPilot.
pub fn heartbeat(version: u8, stamp_us: u64) -> Vec<u8> {
    packet(version, stamp_us, 0, 50, &[0, 0, 0, 0, 2, 3, 81, 4, 3])
}

/// `PARAM_VALUE`.
pub fn parameter(version: u8, stamp_us: u64, name: &str, value: f64) -> Vec<u8> {
    let mut payload = (value as f32).to_le_bytes().to_vec();
    payload.extend([1, 0, 0, 0]);
    payload.extend(name.bytes().chain(std::iter::repeat(0)).take(16));
    payload.push(9);
    packet(version, stamp_us, 22, 220, &payload)
}

/// `RAW_IMU` at a time since boot: mG of gravity, mrad/s, milligauss.
pub fn raw_imu(version: u8, stamp_us: u64, boot_us: u64, values: [i16; 9]) -> Vec<u8> {
    let mut payload = boot_us.to_le_bytes().to_vec();
    values.iter().for_each(|value| payload.extend(value.to_le_bytes()));
    packet(version, stamp_us, 27, 144, &payload)
}

/// `SYS_STATUS`: volts and amperes.
pub fn status(version: u8, stamp_us: u64, volts: f64, amperes: f64) -> Vec<u8> {
    let mut payload = vec![0; 14];
    payload.extend(((volts * 1000.0).round() as u16).to_le_bytes());
    payload.extend(((amperes * 100.0).round() as i16).to_le_bytes());
    payload.extend([0; 13]);
    packet(version, stamp_us, 1, 124, &payload)
}
