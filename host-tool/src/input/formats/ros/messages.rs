//! The messages of ROS that are read (common_interfaces, sensor_msgs/msg/*.msg).

use crate::input::formats::ros::cdr::{Encoding, Reader};
use crate::input::formats::stream::{Between, Stream};

/// Microtesla in a tesla.
pub const TESLA_UT: f64 = 1e6;

/// A kind of message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// `sensor_msgs/MagneticField`: tesla.
    MagneticField,
    /// `sensor_msgs/Imu`: rad/s and m/s².
    Imu,
    /// `sensor_msgs/Temperature`: °C.
    Temperature,
    /// `sensor_msgs/BatteryState`: V, A.
    Battery,
    /// `sensor_msgs/NavSatFix`: degrees, m.
    Position,
}

/// What a message says: when, in which frame, and its values in the order of the stream's columns.
pub struct Message {
    /// `header.stamp`, ns; 0 where it was not set.
    pub stamp_ns: i64,
    /// `header.frame_id`.
    pub frame: String,
    /// The values.
    pub values: Vec<f64>,
}

impl Kind {
    /// By the name of its schema; `None` where it is not read.
    pub fn of(schema: &str) -> Option<Self> {
        let (package, name) = schema.split_once('/')?;
        let name = name.strip_prefix("msg/").unwrap_or(name);
        if package != "sensor_msgs" {
            return None;
        }
        Some(match name {
            "MagneticField" => Kind::MagneticField,
            "Imu" => Kind::Imu,
            "Temperature" => Kind::Temperature,
            "BatteryState" => Kind::Battery,
            "NavSatFix" => Kind::Position,
            _ => return None,
        })
    }

    /// An empty stream for topic number `number` (from 0) of the kind.
    pub fn stream(self, topic: &str, number: usize) -> Stream {
        let more = if number == 0 { String::new() } else { format!("_{}", number + 1) };
        let columns: Vec<(String, &str, &str, Between)> = match self {
            Kind::MagneticField => ["x", "y", "z"]
                .map(|axis| (format!("m{axis}_ut"), "magnetic_field", "T", Between::Line))
                .into(),
            Kind::Imu => ["gx_radps", "gy_radps", "gz_radps", "ax_mps2", "ay_mps2", "az_mps2"]
                .iter()
                .map(|name| match name.starts_with('g') {
                    true => (name.to_string(), "angular_velocity", "rad/s", Between::Line),
                    false => (name.to_string(), "linear_acceleration", "m/s²", Between::Line),
                })
                .collect(),
            Kind::Temperature => vec![(format!("temp{more}_c"), "temperature", "°C", Between::Line)],
            Kind::Battery => vec![
                (format!("voltage{more}_v"), "voltage", "V", Between::Line),
                (format!("current{more}_a"), "current", "A, negative while discharging", Between::Line),
            ],
            Kind::Position => vec![
                ("lat_deg".into(), "latitude", "°", Between::Line),
                ("lon_deg".into(), "longitude", "°", Between::Circle),
                ("gps_height_m".into(), "altitude", "m", Between::Line),
            ],
        };
        columns.into_iter().fold(Stream::new(topic), |stream, (name, field, unit, between)| {
            let axis = match name.as_bytes() {
                [b'm' | b'g' | b'a', axis @ (b'x' | b'y' | b'z'), b'_', ..] => {
                    format!(".{}", char::from(*axis))
                }
                _ => String::new(),
            };
            let scale = if self == Kind::MagneticField { TESLA_UT } else { 1.0 };
            stream.scaled(&name, &format!("{topic}.{field}{axis}"), unit, scale, between)
        })
    }

    /// Reads one message; `None` where it is cut off or of another form.
    pub fn decode(self, data: &[u8], encoding: Encoding) -> Option<Message> {
        let mut reader = Reader::new(data, encoding)?;
        let reader = &mut reader;
        if reader.encoding == Encoding::Ros1 {
            // Only ROS 1 counts messages in their header.
            reader.u32()?;
        }
        let (seconds, nanoseconds) = (reader.u32()?.cast_signed(), reader.u32()?);
        let stamp_ns = i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds);
        let frame = reader.text()?;
        let values = match self {
            Kind::MagneticField => reader.doubles::<3>()?.map(|tesla| tesla * TESLA_UT).into(),
            Kind::Imu => imu(reader)?,
            Kind::Temperature => vec![reader.f64()?],
            Kind::Battery => {
                let (voltage, _temperature, current) = (reader.f32()?, reader.f32()?, reader.f32()?);
                vec![voltage, current]
            }
            Kind::Position => {
                let (status, _service) = (reader.u8()?.cast_signed(), reader.u16()?);
                let position = reader.doubles::<3>()?;
                // Status −1: no fix.
                if status < 0 { vec![f64::NAN; 3] } else { position.into() }
            }
        };
        Some(Message { stamp_ns, frame, values })
    }
}

/// Orientation, angular velocity and linear acceleration, each with nine numbers of covariance; the first of them is −1 where the
/// sensor has no such value.
fn imu(reader: &mut Reader<'_>) -> Option<Vec<f64>> {
    let _orientation = reader.doubles::<4>()?;
    let _covariance = reader.doubles::<9>()?;
    let mut values = Vec::with_capacity(6);
    for _ in 0..2 {
        let vector = reader.doubles::<3>()?;
        let missing = reader.f64()? == -1.0;
        let _covariance = reader.doubles::<8>()?;
        values.extend(if missing { [f64::NAN; 3] } else { vector });
    }
    Some(values)
}
