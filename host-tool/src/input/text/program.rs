//! Programs whose tables are told by their headers, and what their documentation says of the units.

use crate::input::names::Kind;
use crate::input::text::grid::Grid;
use crate::input::unit::{Quantity, Unit};

/// A program that is known by its headers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Program {
    /// A topic of a PX4 log as `ulog2csv` writes it (units: PX4's msg/*.msg).
    Px4,
    /// The `MAG` messages of an ArduPilot log as CSV (units: the log's own, milligauss).
    ArduPilot,
    /// `blackbox_decode` of a Betaflight or INAV log.
    Blackbox,
    /// ROS messages as CSV (units: REP 103 and the definitions in sensor_msgs).
    Ros,
    /// The telephone app Physics Toolbox.
    PhysicsToolbox,
}

impl Program {
    /// Told by the headers.
    pub fn of(grid: &Grid) -> Option<Program> {
        let has = |name: &str| grid.find(name).is_some();
        let any = |part: &str| grid.columns.iter().any(|column| column.header.contains(part));
        if any("magnetometer_ga[") || is_sensor_mag(grid) {
            return Some(Program::Px4);
        }
        if has("MagX") && (has("OfsX") || has("MOfsX") || has("MOX") || has("TimeUS")) {
            return Some(Program::ArduPilot);
        }
        if has("loopIteration") && any("time (us)") {
            return Some(Program::Blackbox);
        }
        let ros = ["magnetic_field.x", "magnetic_field/x", "linear_acceleration.x", "linear_acceleration/x"];
        if ros.iter().any(|part| any(part)) {
            return Some(Program::Ros);
        }
        has("gFx").then_some(Program::PhysicsToolbox)
    }

    /// As it is said.
    pub fn name(self) -> &'static str {
        match self {
            Program::Px4 => "PX4 ulog2csv",
            Program::ArduPilot => "ArduPilot MAG messages",
            Program::Blackbox => "Betaflight or INAV blackbox_decode",
            Program::Ros => "ROS messages",
            Program::PhysicsToolbox => "Physics Toolbox",
        }
    }

    /// The unit of a column of that kind whose name has none.
    pub fn unit(self, kind: Kind, header: &str) -> Option<Unit> {
        let unit = |text: &str, quantity| Unit::of(text, quantity);
        match (self, kind) {
            (Program::Px4, Kind::Time) => unit("us", Quantity::Time),
            (Program::Px4, Kind::Field) => unit("G", Quantity::Field),
            (Program::Px4, Kind::Temperature) => unit("C", Quantity::Temperature),
            (Program::ArduPilot, Kind::Field) => unit("mG", Quantity::Field),
            (Program::Ros, Kind::Field) => unit("T", Quantity::Field),
            (Program::Ros, Kind::Accel) => unit("m/s2", Quantity::Acceleration),
            (Program::Ros, Kind::Gyro) => unit("rad/s", Quantity::Rate),
            // rostopic echo -p writes nanoseconds since 1970; bags as CSV and plots write seconds.
            (Program::Ros, Kind::Time) if header == "%time" || header.ends_with("header.stamp") => {
                unit("ns", Quantity::Time)
            }
            (Program::PhysicsToolbox, Kind::Gyro) => unit("rad/s", Quantity::Rate),
            (Program::PhysicsToolbox, Kind::Field) => unit("uT", Quantity::Field),
            _ => None,
        }
    }

    /// Columns that hold what the autopilot had added to the field already.
    pub fn added(self, grid: &Grid) -> Vec<[usize; 3]> {
        if self != Program::ArduPilot {
            return Vec::new();
        }
        [["OfsX", "OfsY", "OfsZ"], ["MOfsX", "MOfsY", "MOfsZ"], ["MOX", "MOY", "MOZ"]]
            .into_iter()
            .filter_map(|names| {
                let [x, y, z] = names.map(|name| grid.find(name));
                Some([x?, y?, z?])
            })
            .collect()
    }
}

/// `sensor_mag` has the columns x, y and z, without a word of what they are; the accelerometer's and the gyroscope's have more next to them.
pub fn is_sensor_mag(grid: &Grid) -> bool {
    ["timestamp", "device_id", "x", "y", "z"].iter().all(|name| grid.find(name).is_some())
        && (grid.find("error_count").is_some() || grid.find("is_external").is_some())
        && !grid.columns.iter().any(|column| column.header.starts_with("clip_counter"))
        && grid.find("samples").is_none()
        && grid.find("integral_dt").is_none()
}
