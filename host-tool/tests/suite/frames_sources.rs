//! One recording as each program would have written it, with what the test itself knows of the numbers: their unit, their axes and
//! the calibration in them. Nothing here asks a reader.

use crate::common::target::{Matrix, Vector, product, times};
use crate::writers::blackbox::session;
use crate::writers::dataflash::Cell::{N, T};
use crate::writers::dataflash::Dataflash;
use crate::writers::mavlink;
use crate::writers::ros::{File, Form, Message};
use crate::writers::sqlite::Sqlite;
use crate::writers::truth::Truth;
use crate::writers::ulog::{Ulog, Value, floats};

pub const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// x forward, y left, z up to x forward, y right, z down, and back.
pub const LEFT_UP: Matrix = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
/// Yaw 90° and roll 180°, numbers 2 and 8 of the autopilots.
const YAW_90: Matrix = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
/// A symmetric matrix and two offsets that an autopilot had applied, the second from the middle of the log on.
const APPLIED: Matrix = [[1.05, 0.02, -0.01], [0.02, 0.96, 0.03], [-0.01, 0.03, 1.02]];
const OFFSETS_UT: [Vector; 2] = [[12.0, -34.0, 5.0], [-8.0, 21.0, 17.0]];
const START_US: u64 = 1_700_000_000_000_000;
const DEVICE: u32 = 592_905;

/// One recording in one format.
pub struct Source {
    pub name: &'static str,
    pub file: &'static str,
    pub bytes: Vec<u8>,
    /// Options of `fit` that say how to read it.
    pub options: &'static [&'static str],
    /// The numbers as they were written, row by row.
    pub numbers: Vec<Vector>,
    pub ut_per_number: f64,
    /// `numbers = matrix · (sensor − offset)`, in source axes, row by row.
    pub removed: Vec<(Matrix, Vector)>,
    pub from_source: Matrix,
    /// The export of the same program, and from the sensor's axes to those of the source.
    pub native: (&'static str, Matrix),
}

pub fn transposed(m: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

pub fn inverse(m: &Matrix) -> Matrix {
    let inverse = nalgebra::Matrix3::from_fn(|i, j| m[i][j]).try_inverse().expect("an inverse");
    std::array::from_fn(|i| std::array::from_fn(|j| inverse[(i, j)]))
}

impl Source {
    fn new(name: &'static str, file: &'static str, native: &'static str) -> Self {
        Source {
            name,
            file,
            bytes: Vec::new(),
            options: &[],
            numbers: Vec::new(),
            ut_per_number: 1.0,
            removed: Vec::new(),
            from_source: IDENTITY,
            native: (native, IDENTITY),
        }
    }

    /// Rows from which on the last calibration of the source applies.
    pub fn last_from(&self) -> usize {
        let last = self.removed.last();
        self.removed.iter().rposition(|one| Some(one) != last).map_or(0, |row| row + 1)
    }

    /// What the sensor had measured, µT in the source's axes.
    pub fn measured_ut(&self, row: usize) -> Vector {
        let numbers = self.numbers[row];
        let raw = match self.removed.get(row) {
            Some((matrix, offset)) => {
                let back = times(&inverse(matrix), numbers);
                std::array::from_fn(|axis| back[axis] + offset[axis])
            }
            None => numbers,
        };
        raw.map(|value| value * self.ut_per_number)
    }

    /// The numbers of a field in body axes, with rounding to `step`.
    fn push(&mut self, body_ut: Vector, removed: Option<(Matrix, Vector)>, step: f64) -> Vector {
        let sensor = times(&transposed(&self.from_source), body_ut).map(|ut| ut / self.ut_per_number);
        let applied = match removed {
            Some((matrix, offset)) => times(&matrix, std::array::from_fn(|axis| sensor[axis] - offset[axis])),
            None => sensor,
        };
        let numbers = if step > 0.0 {
            applied.map(|value| (value / step).round() * step)
        } else {
            applied.map(|v| f64::from(v as f32))
        };
        self.numbers.push(numbers);
        self.removed.extend(removed);
        numbers
    }
}

fn applied(row: usize, rows: usize, ut_per_number: f64, turn: &Matrix) -> (Matrix, Vector) {
    let offset = OFFSETS_UT[usize::from(row >= rows / 2)].map(|ut| ut / ut_per_number);
    (product(turn, &product(&APPLIED, &transposed(turn))), times(turn, offset))
}

/// The recording in every format that is read.
pub fn sources(truth: &Truth) -> Vec<Source> {
    let mut all = vec![csv(truth), blackbox(truth, false), blackbox(truth, true), configurator(truth)];
    all.extend([ulog_raw(truth), ulog_corrected(truth)]);
    all.extend(dataflash(truth));
    all.extend([telemetry(truth), mcap(truth), rosbag(truth)]);
    all
}

/// Milligauss of a sensor whose x axis is the body's y.
fn csv(truth: &Truth) -> Source {
    let mut source = Source {
        ut_per_number: 0.1,
        from_source: YAW_90,
        ..Source::new("CSV in mG, --rotate", "log.csv", "")
    };
    source.options = &["--rotate=mag:yaw90"];
    let mut text = "t_s,mx_mg,my_mg,mz_mg,ax_mps2,ay_mps2,az_mps2\n".to_string();
    for row in 0..truth.log.rows {
        let [x, y, z] = source.push(truth.field(row), None, 0.1);
        let [ax, ay, az] = truth.accel(row);
        text += &format!("{},{x:.1},{y:.1},{z:.1},{ax},{ay},{az}\n", truth.micros(row) as f64 / 1e6);
    }
    source.bytes = text.into_bytes();
    source
}

fn blackbox(truth: &Truth, inav: bool) -> Source {
    let (name, native) = if inav { ("INAV blackbox", "") } else { ("Betaflight blackbox", "betaflight") };
    let mut source =
        Source { ut_per_number: 0.02, from_source: LEFT_UP, ..Source::new(name, "log.bbl", native) };
    source.options = &["--ut-per-count=0.02"];
    let rows: Vec<[i32; 13]> = (0..truth.log.rows)
        .map(|row| {
            let [x, y, z] = source.push(truth.field(row), None, 1.0).map(|value| value as i32);
            let counts =
                |v: Vector, scale: f64| times(&LEFT_UP, v).map(|value| (value * scale).round() as i32);
            let [gx, gy, gz] = counts(truth.gyro(row).map(f64::to_degrees), 1000.0);
            let [ax, ay, az] = counts(truth.accel(row), 20480.0 / 9.806_65);
            [3_000_000 + truth.micros(row) as i32, 1600, 10, x, y, z, gx, gy, gz, ax, ay, az, 1000]
        })
        .collect();
    let firmware =
        if inav { "INAV 7.1.2 (4e1e59eb) MATEKF405" } else { "Betaflight 4.5.1 (77d01ba3b) STM32F405" };
    source.bytes = session(firmware, &rows);
    source
}

fn configurator(truth: &Truth) -> Source {
    let name = "Betaflight Configurator";
    let mut source = Source {
        ut_per_number: 0.05,
        from_source: LEFT_UP,
        ..Source::new(name, "calibration.json", "betaflight")
    };
    source.options = &["--ut-per-count=0.05"];
    let offset = (IDENTITY, [40.0, -70.0, 15.0]);
    let samples: Vec<serde_json::Value> = (0..truth.log.rows)
        .map(|row| {
            let [x, y, z] = source.push(truth.field(row), Some(offset), 1.0);
            let ms = (START_US + truth.micros(row)) / 1000;
            serde_json::json!({"x": x, "y": y, "z": z, "roll": 1.5, "pitch": 2.5, "heading": 90.0, "timestamp": ms, "qw": 1})
        })
        .collect();
    let file = serde_json::json!({
        "exportedAt": "2026-06-01T10:00:00.000Z", "type": "calibration_tumble", "samples": samples,
        "firmwareOffsets": {"x": 40, "y": -70, "z": 15},
    });
    // As the program writes it: its keys in this order, the type at the beginning.
    let text = format!("{{\n  \"type\": \"calibration_tumble\",{}", file.to_string().trim_start_matches('{'));
    source.bytes = text.replacen("\"type\":\"calibration_tumble\",", "", 1).into_bytes();
    source
}

fn ulog_head() -> Ulog {
    let mut file = Ulog::new(5_000_000);
    file.info("sys_name", "PX4");
    file.format(
        "sensor_mag:uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;\
         float temperature;uint32_t error_count;",
    );
    file.format(
        "vehicle_magnetometer:uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;\
         float[3] magnetometer_ga;uint8_t calibration_count;uint8_t[7] _padding0;",
    );
    file.format(
        "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;\
         int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;",
    );
    file.parameter("CAL_MAG0_ID", Value::Int(DEVICE as i32));
    file.parameter("CAL_MAG0_ROT", Value::Int(2));
    file
}

fn ulog_imu(file: &mut Ulog, truth: &Truth, row: usize, stamp: &[u8; 8]) {
    let (gyro, accel) = (floats(truth.gyro(row)), floats(truth.accel(row)));
    file.data(1, &[stamp, &gyro, &[0; 4], &[0; 4], &accel, &[0; 4]]);
}

fn ulog_raw(truth: &Truth) -> Source {
    let mut source = Source {
        ut_per_number: 100.0,
        from_source: YAW_90,
        ..Source::new("ULog sensor_mag", "raw.ulg", "px4")
    };
    let mut file = ulog_head();
    file.subscribe(0, 0, "sensor_mag");
    file.subscribe(0, 1, "sensor_combined");
    for row in 0..truth.log.rows {
        let stamp = (5_000_000 + truth.micros(row)).to_le_bytes();
        ulog_imu(&mut file, truth, row, &stamp);
        let field = floats(source.push(truth.field(row), None, 0.0));
        file.data(0, &[&stamp, &stamp, &DEVICE.to_le_bytes(), &field, &[0; 4], &[0; 4]]);
    }
    source.bytes = file.bytes;
    source
}

/// Corrected by PX4, which was calibrated again in the middle of the log.
fn ulog_corrected(truth: &Truth) -> Source {
    let name = "ULog vehicle_magnetometer";
    let mut source = Source { ut_per_number: 100.0, ..Source::new(name, "corrected.ulg", "px4") };
    source.native.1 = YAW_90;
    let mut file = ulog_head();
    let parameters = |file: &mut Ulog, offset: Vector| {
        for (axis, letter) in ["X", "Y", "Z"].iter().enumerate() {
            file.parameter(&format!("CAL_MAG0_{letter}OFF"), Value::Float((offset[axis] / 100.0) as f32));
            file.parameter(&format!("CAL_MAG0_{letter}SCALE"), Value::Float(APPLIED[axis][axis] as f32));
        }
        for (letter, (i, j)) in ["X", "Y", "Z"].iter().zip([(0, 1), (0, 2), (1, 2)]) {
            file.parameter(&format!("CAL_MAG0_{letter}ODIAG"), Value::Float(APPLIED[i][j] as f32));
        }
    };
    parameters(&mut file, OFFSETS_UT[0]);
    file.subscribe(0, 0, "vehicle_magnetometer");
    file.subscribe(0, 1, "sensor_combined");
    let rows = truth.log.rows;
    for row in 0..rows {
        if row == rows / 2 {
            parameters(&mut file, OFFSETS_UT[1]);
        }
        let stamp = (5_000_000 + truth.micros(row)).to_le_bytes();
        let field = source.push(truth.field(row), Some(applied(row, rows, 100.0, &YAW_90)), 0.0);
        file.data(0, &[&stamp, &stamp, &DEVICE.to_le_bytes(), &floats(field), &[1], &[0; 7]]);
        ulog_imu(&mut file, truth, row, &stamp);
    }
    source.bytes = file.bytes;
    source
}

/// Binary and text, of a compass that was calibrated again in the middle of the log.
fn dataflash(truth: &Truth) -> [Source; 2] {
    let new = |name, file| Source {
        ut_per_number: 0.1,
        native: ("ardupilot", YAW_90),
        ..Source::new(name, file, "")
    };
    let mut binary = new("DataFlash", "log.bin");
    let mut file = Dataflash::new();
    file.message("MSG", &[N(1000.0), T("ArduCopter V4.5.7 (2a3dc4b7)")]);
    let parameter = |file: &mut Dataflash, time: f64, name: &str, value: f64| {
        file.message("PARM", &[N(time), T(name), N(value), N(0.0)]);
    };
    parameter(&mut file, 2000.0, "COMPASS_EXTERNAL", 1.0);
    parameter(&mut file, 2000.0, "COMPASS_ORIENT", 2.0);
    for (axis, letter) in ["X", "Y", "Z"].iter().enumerate() {
        parameter(&mut file, 2000.0, &format!("COMPASS_DIA_{letter}"), APPLIED[axis][axis]);
    }
    for (letter, (i, j)) in ["X", "Y", "Z"].iter().zip([(0, 1), (0, 2), (1, 2)]) {
        parameter(&mut file, 2000.0, &format!("COMPASS_ODI_{letter}"), APPLIED[i][j]);
    }
    let rows = truth.log.rows;
    for row in 0..rows {
        let micros = 3e6 + truth.micros(row) as f64;
        let ofs = OFFSETS_UT[usize::from(row >= rows / 2)].map(|ut| (-ut * 10.0).round());
        if row == 0 || row == rows / 2 {
            for (axis, letter) in ["X", "Y", "Z"].iter().enumerate() {
                parameter(&mut file, micros - 1.0, &format!("COMPASS_OFS_{letter}"), ofs[axis]);
            }
        }
        let [x, y, z] = binary.push(truth.field(row), Some((APPLIED, ofs.map(|value| -value))), 1.0);
        let ([gx, gy, gz], [ax, ay, az]) = (truth.gyro(row), truth.accel(row));
        let (time, zero) = (N(micros), N(0.0));
        let sensors = [time, zero, N(gx), N(gy), N(gz), N(ax), N(ay), N(az)];
        let rest = [zero, zero, N(35.5), N(1.0), N(1.0), N(1000.0), N(1000.0)];
        file.message("IMU", &[&sensors[..], &rest].concat());
        let offsets = ofs.map(N);
        let field = [time, zero, N(x), N(y), N(z)];
        file.message("MAG", &[&field[..], &offsets, &[zero, zero, zero, N(1.0), zero]].concat());
    }
    let mut text = new("DataFlash as text", "log.log");
    (text.numbers, text.removed) = (binary.numbers.clone(), binary.removed.clone());
    (binary.bytes, text.bytes) = (file.binary, file.text.into_bytes());
    [binary, text]
}

/// Telemetry of an ArduPilot, whose parameters were asked for at the beginning.
fn telemetry(truth: &Truth) -> Source {
    let native = ("ardupilot", IDENTITY);
    let mut source =
        Source { ut_per_number: 0.1, native, ..Source::new("MAVLink telemetry", "log.tlog", "") };
    let mut bytes = mavlink::heartbeat(2, START_US);
    let offset = OFFSETS_UT[0].map(|ut| ut * 10.0);
    for (axis, letter) in ["X", "Y", "Z"].iter().enumerate() {
        for (name, value) in [("OFS", -offset[axis]), ("DIA", APPLIED[axis][axis])] {
            bytes.extend(mavlink::parameter(2, START_US + 10, &format!("COMPASS_{name}_{letter}"), value));
        }
    }
    for (letter, (i, j)) in ["X", "Y", "Z"].iter().zip([(0, 1), (0, 2), (1, 2)]) {
        bytes.extend(mavlink::parameter(1, START_US + 10, &format!("COMPASS_ODI_{letter}"), APPLIED[i][j]));
    }
    for row in 0..truth.log.rows {
        let boot_us = 7_000_000 + truth.micros(row);
        // The radio takes its time.
        let stamp = START_US + 100 + truth.micros(row) + (row as u64 % 7) * 900;
        let version = if row % 2 == 0 { 1 } else { 2 };
        let field = source.push(truth.field(row), Some((APPLIED, offset)), 1.0).map(|value| value as i16);
        let accel = truth.accel(row).map(|value| (value / 9.806_65 * 1000.0).round() as i16);
        let gyro = truth.gyro(row).map(|value| (value * 1000.0).round() as i16);
        let values = [accel, gyro, field].concat().try_into().expect("nine");
        bytes.extend(mavlink::raw_imu(version, stamp, boot_us, values));
        if row % 10 == 0 {
            bytes.extend(mavlink::status(version, stamp, 16.1, 12.34));
            bytes.extend([0xfe, 0x00, 0x11]);
        }
    }
    source.bytes = bytes;
    source
}

fn ros_message(truth: &Truth, row: usize, imu: bool, source: &mut Source) -> Vec<u8> {
    let message = Message::new(Form::Little, (START_US + truth.micros(row)) * 1000, "imu_link");
    if imu {
        let (gyro, accel) = (times(&LEFT_UP, truth.gyro(row)), times(&LEFT_UP, truth.accel(row)));
        let head = message.doubles(&[0.0, 0.0, 0.0, 1.0]).doubles(&[-1.0; 9]);
        return head.doubles(&gyro).doubles(&[0.01; 9]).doubles(&accel).doubles(&[0.01; 9]).finish();
    }
    let tesla = source.push(truth.field(row), None, 1e-11);
    message.doubles(&tesla).doubles(&[0.0; 9]).finish()
}

fn mcap(truth: &Truth) -> Source {
    let mut source =
        Source { ut_per_number: 1e6, from_source: LEFT_UP, ..Source::new("ROS MCAP", "log.mcap", "ros") };
    let mut file = File::new(Form::Little, None);
    for row in 0..truth.log.rows {
        let ns = (START_US + truth.micros(row)) * 1000;
        file.write("/imu/data", "Imu", ns, &ros_message(truth, row, true, &mut source));
        file.write("/imu/mag", "MagneticField", ns, &ros_message(truth, row, false, &mut source));
    }
    source.bytes = file.finish();
    source
}

fn rosbag(truth: &Truth) -> Source {
    let mut source =
        Source { ut_per_number: 1e6, from_source: LEFT_UP, ..Source::new("ROS rosbag2", "log.db3", "ros") };
    source.bytes = bag(truth, truth.log.rows, &mut source);
    source
}

/// The first rows as a bag, with pictures that flow over their pages.
pub fn bag(truth: &Truth, rows: usize, source: &mut Source) -> Vec<u8> {
    let topics = [
        ("/imu/data", "sensor_msgs/msg/Imu"),
        ("/imu/mag", "sensor_msgs/msg/MagneticField"),
        ("/camera", "sensor_msgs/msg/CompressedImage"),
    ];
    let mut messages = Vec::new();
    for row in 0..rows {
        let ns = ((START_US + truth.micros(row)) * 1000) as i64;
        messages.push((1, ns, ros_message(truth, row, true, source)));
        messages.push((2, ns, ros_message(truth, row, false, source)));
        if row % 100 == 0 {
            messages.push((3, ns, vec![7; 1500]));
        }
    }
    Sqlite::bag(&topics, &messages)
}

/// Short logs of the formats that have no test file of their own, for the fuzz.
pub fn short(truth: &Truth, rows: usize) -> [Vec<u8>; 3] {
    let log = telemetry(truth).bytes;
    let cut = log.len() * rows / truth.log.rows;
    let mut source = Source { ut_per_number: 1e6, from_source: LEFT_UP, ..Source::new("", "", "") };
    let json = configurator(truth).bytes;
    let end = json.len() * rows / truth.log.rows;
    let samples = String::from_utf8_lossy(&json[..end]).into_owned();
    let whole = samples.rfind("},{").map_or(0, |at| at + 1);
    // Keys of the object stand in the order of the alphabet: the samples are its last.
    [log[..cut].to_vec(), bag(truth, rows, &mut source), format!("{}]}}", &samples[..whole]).into_bytes()]
}
