//! Which messages of ArduPilot are read, and what each of their fields becomes.

use crate::input::formats::stream::{Between, GROUND};

/// One field that is read.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Its label in the message.
    pub label: &'static str,
    /// The column's name; `#` stands for the number of the sensor from 1.
    pub name: &'static str,
    /// Its unit in the file.
    pub unit: &'static str,
    /// From there to the log's unit.
    pub scale: f64,
    /// How it is read between two samples.
    pub between: Between,
}

const fn field(label: &'static str, name: &'static str, unit: &'static str) -> Field {
    scaled(label, name, unit, 1.0)
}

const fn scaled(label: &'static str, name: &'static str, unit: &'static str, scale: f64) -> Field {
    Field { label, name, unit, scale, between: Between::Line }
}

/// Milligauss to microtesla.
const UT: f64 = 0.1;

/// The compass: the field as it was used, the offsets that were added, and what was added for the motors.
pub const MAG: [Field; 12] = [
    scaled("MagX", "mx_ut", "mG", UT),
    scaled("MagY", "my_ut", "mG", UT),
    scaled("MagZ", "mz_ut", "mG", UT),
    scaled("OfsX", "offset_x", "mG", UT),
    scaled("OfsY", "offset_y", "mG", UT),
    scaled("OfsZ", "offset_z", "mG", UT),
    scaled("MOX", "motor_x", "mG", UT),
    scaled("MOY", "motor_y", "mG", UT),
    scaled("MOZ", "motor_z", "mG", UT),
    scaled("MOfsX", "motor_x", "mG", UT),
    scaled("MOfsY", "motor_y", "mG", UT),
    scaled("MOfsZ", "motor_z", "mG", UT),
];

const IMU: [Field; 7] = [
    field("AccX", "ax_mps2", "m/s²"),
    field("AccY", "ay_mps2", "m/s²"),
    field("AccZ", "az_mps2", "m/s²"),
    field("GyrX", "gx_radps", "rad/s"),
    field("GyrY", "gy_radps", "rad/s"),
    field("GyrZ", "gz_radps", "rad/s"),
    field("T", "imu_c", "°C"),
];

const BAT: [Field; 3] =
    [field("Curr", "current#_a", "A"), field("Volt", "voltage#_v", "V"), field("Temp", "battery#_c", "°C")];

const BARO: [Field; 2] = [field("Alt", "height_m", "m"), field("Temp", "baro_c", "°C")];

const RCOU: [Field; 14] = [
    field("C1", "output_1", "µs"),
    field("C2", "output_2", "µs"),
    field("C3", "output_3", "µs"),
    field("C4", "output_4", "µs"),
    field("C5", "output_5", "µs"),
    field("C6", "output_6", "µs"),
    field("C7", "output_7", "µs"),
    field("C8", "output_8", "µs"),
    field("C9", "output_9", "µs"),
    field("C10", "output_10", "µs"),
    field("C11", "output_11", "µs"),
    field("C12", "output_12", "µs"),
    field("C13", "output_13", "µs"),
    field("C14", "output_14", "µs"),
];

const MOTB: [Field; 3] = [
    field("ThrOut", "throttle", ""),
    field("LiftMax", "lift_max", ""),
    field("ThLimit", "throttle_limit", ""),
];

const CTUN: [Field; 2] = [field("ThO", "throttle", ""), field("ThrOut", "throttle", "")];

const ESC: [Field; 3] =
    [field("Curr", "esc_#_a", "A"), field("RPM", "esc_#_rpm", "1/min"), field("Temp", "esc_#_c", "°C")];

/// The filter's attitude, from body axes to north, east, down.
const FILTER: [Field; 4] =
    [field("Q1", "q_w", ""), field("Q2", "q_x", ""), field("Q3", "q_y", ""), field("Q4", "q_z", "")];

/// The attitude in use; [`crate::input::formats::stream::Stream::attitude_of_angles`] makes a quaternion of it.
const ATT: [Field; 3] =
    [field("Roll", "roll_deg", "°"), field("Pitch", "pitch_deg", "°"), field("Yaw", "yaw_deg", "°")];

const GPS: [Field; 5] = [
    field("Lat", "lat_deg", "°"),
    Field { between: Between::Circle, ..field("Lng", "lon_deg", "°") },
    field("Alt", "gps_height_m", "m"),
    field("Spd", GROUND[0], "m/s"),
    Field { between: Between::Circle, ..field("GCrs", GROUND[1], "°") },
];

/// The accuracy of the receiver.
const GPA: [Field; 1] = [field("SAcc", GROUND[2], "m/s")];

/// A message: what is read of it, in which order it is asked, and which of its instances.
pub struct Message {
    /// The fields.
    pub fields: &'static [Field],
    /// Of two columns of one name that of the smaller place is taken.
    pub place: u8,
    /// All instances, or the first only.
    pub all: bool,
}

/// What is wanted of a message, without the number at the end of its name. Old logs number sensors in the name (`MAG2`), newer
/// ones in a field (`I`).
pub fn wanted(name: &str) -> Option<Message> {
    let (fields, place, all): (&[Field], u8, bool) = match name {
        "MAG" => (&MAG, 0, true),
        "IMU" => (&IMU, 1, false),
        "BAT" => (&BAT, 2, true),
        "CURR" => (&BAT, 3, true),
        "ESC" => (&ESC, 4, true),
        "MOTB" => (&MOTB, 5, false),
        "CTUN" => (&CTUN, 6, false),
        "RCOU" => (&RCOU, 7, false),
        "BARO" => (&BARO, 8, false),
        "GPS" => (&GPS, 9, false),
        "GPA" => (&GPA, 13, false),
        "XKQ" => (&FILTER, 10, false),
        "NKQ" => (&FILTER, 11, false),
        "ATT" => (&ATT, 12, false),
        _ => return None,
    };
    Some(Message { fields, place, all })
}
