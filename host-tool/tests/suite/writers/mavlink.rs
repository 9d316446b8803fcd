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

/// `SCALED_IMU` (26), `SCALED_IMU2` (116), `SCALED_IMU3` (129): mG of gravity, mrad/s, milligauss, hundredths of a degree.
pub fn scaled_imu(
    version: u8,
    stamp_us: u64,
    boot_ms: u64,
    id: u8,
    values: [i16; 9],
    centidegrees: i16,
) -> Vec<u8> {
    let extra = match id {
        26 => 170,
        116 => 76,
        129 => 46,
        other => panic!("message {other}"),
    };
    let mut payload = (boot_ms as u32).to_le_bytes().to_vec();
    values.iter().for_each(|value| payload.extend(value.to_le_bytes()));
    if version == 2 {
        payload.extend(centidegrees.to_le_bytes());
    }
    packet(version, stamp_us, id, extra, &payload)
}

/// `HIGHRES_IMU`: m/s², rad/s, gauss, degrees.
pub fn highres_imu(version: u8, stamp_us: u64, boot_us: u64, values: [[f64; 3]; 3], celsius: f64) -> Vec<u8> {
    let mut payload = boot_us.to_le_bytes().to_vec();
    let pressures = [1013.2, 0.1, 12.0];
    let all = values.iter().flatten().chain(&pressures).chain(std::iter::once(&celsius));
    all.for_each(|value| payload.extend((*value as f32).to_le_bytes()));
    payload.extend(0x1fff_u16.to_le_bytes());
    packet(version, stamp_us, 105, 93, &payload)
}

/// `BATTERY_STATUS`: amperes and degrees, where they are measured.
pub fn battery(version: u8, stamp_us: u64, id: u8, amperes: Option<f64>, celsius: Option<f64>) -> Vec<u8> {
    let hundredths =
        |value: Option<f64>, none: i16| value.map_or(none, |value| (value * 100.0).round() as i16);
    let mut payload = 0_i32.to_le_bytes().to_vec();
    payload.extend(0_i32.to_le_bytes());
    payload.extend(hundredths(celsius, i16::MAX).to_le_bytes());
    (0..10).for_each(|cell| payload.extend(if cell < 4 { 4020_u16 } else { u16::MAX }.to_le_bytes()));
    payload.extend(hundredths(amperes, -1).to_le_bytes());
    payload.extend([id, 0, 1, 80]);
    packet(version, stamp_us, 147, 154, &payload)
}
