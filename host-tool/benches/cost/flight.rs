//! A long flight as PX4 records it.

// The tests' writer, so that there is one; the bench uses a part of it.
#[allow(dead_code)]
#[path = "../../tests/suite/writers/ulog.rs"]
mod writer;

use ironout_cli::input::{Log, ReadOptions, read_stream};
use writer::{Ulog, floats};

/// A ULog of at least `bytes`: accelerometer and gyroscope 250 times a second, the magnetometer 50 times, and topics that are not
/// read, three quarters of it all.
pub fn ulog(bytes: usize) -> Vec<u8> {
    let mut file = Ulog::new(0);
    file.format(
        "sensor_mag:uint64_t timestamp;uint32_t device_id;float x;float y;float z;float temperature;",
    );
    file.format("sensor_combined:uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;");
    file.format("vehicle_attitude:uint64_t timestamp;float[4] q;float[24] more;");
    for (id, name) in ["sensor_mag", "sensor_combined", "vehicle_attitude"].iter().enumerate() {
        file.subscribe(0, id as u16, name);
    }
    file.bytes.reserve(bytes + 1000);
    let mut row = 0_u64;
    while file.bytes.len() < bytes {
        let stamp = (row * 4000).to_le_bytes();
        let angle = row as f64 * 1e-3;
        let turning = [angle.sin(), angle.cos(), (angle * 0.7).sin()];
        file.data(1, &[&stamp, &floats(turning), &floats(turning.map(|v| v * 9.8))]);
        file.data(2, &[&stamp, &[0; 112]]);
        if row.is_multiple_of(5) {
            file.data(
                0,
                &[&stamp, &7_u32.to_le_bytes(), &floats(turning.map(|v| v * 0.5)), &25_f32.to_le_bytes()],
            );
        }
        row += 1;
    }
    file.bytes
}

/// Reads it.
pub fn read(bytes: &[u8]) -> Log {
    read_stream(bytes, bytes.len() as u64, &ReadOptions::default()).expect("the log is good")
}
