//! Which topics of PX4 are read, and what each becomes. Names and units are those of PX4's message definitions (msg/*.msg).

use crate::input::formats::stream::{Between, GROUND};
use crate::input::formats::ulog::collector::Want;
use ironout_analysis::table::ATTITUDE;

/// Topics in the order in which they are asked: of two columns of one name the first with values is taken.
const ORDER: [&str; 22] = [
    "sensor_mag",
    "vehicle_magnetometer",
    "sensor_combined",
    "vehicle_acceleration",
    "vehicle_angular_velocity",
    "vehicle_imu",
    "sensor_accel",
    "sensor_gyro",
    "vehicle_air_data",
    "sensor_baro",
    "battery_status",
    "actuator_motors",
    "actuator_outputs",
    "vehicle_thrust_setpoint",
    "actuator_controls_0",
    "manual_control_setpoint",
    "esc_status",
    "vehicle_gps_position",
    "sensor_gps",
    "actuator_armed",
    "vehicle_control_mode",
    "vehicle_attitude",
];

/// The place of a topic in the order; `None` where it is not read.
pub fn place(topic: &str) -> Option<usize> {
    ORDER.iter().position(|known| *known == topic)
}

fn want(path: impl Into<String>, name: impl Into<String>, unit: &'static str, scale: f64) -> Want {
    Want {
        path: path.into(),
        name: name.into(),
        unit,
        scale,
        none: None,
        over_us: None,
        between: Between::Line,
    }
}

/// Three fields, told apart by `paths`, as `mx_ut`, `my_ut`, `mz_ut` or the like.
fn three(paths: [&str; 3], first: char, after: &str, unit: &'static str, scale: f64) -> Vec<Want> {
    let names = ["x", "y", "z"].map(|axis| format!("{first}{axis}_{after}"));
    paths.iter().zip(names).map(|(path, name)| want(*path, name, unit, scale)).collect()
}

fn array(path: &str) -> [String; 3] {
    [0, 1, 2].map(|index| format!("{path}[{index}]"))
}

fn vector(path: &str, first: char, after: &str, unit: &'static str, scale: f64) -> Vec<Want> {
    three(array(path).each_ref().map(String::as_str), first, after, unit, scale)
}

/// A name for the sensor of an instance: `current_a`, then `current_2_a`, …
fn numbered(name: &str, instance: u8) -> String {
    match (instance, name.rsplit_once('_')) {
        (0, _) | (_, None) => name.to_string(),
        (_, Some((what, unit))) => format!("{what}_{}_{unit}", u16::from(instance) + 1),
    }
}

/// What is wanted of an instance of a topic; nothing where it is not read.
pub fn wants(topic: &str, instance: u8) -> Vec<Want> {
    let axes = ["x", "y", "z"];
    match (topic, instance) {
        ("sensor_mag", _) => {
            let mut wants = three(axes, 'm', "ut", "G", 100.0);
            wants.push(Want { none: Some(0.0), ..want("temperature", "temp_c", "°C", 1.0) });
            wants
        }
        ("vehicle_magnetometer", _) => vector("magnetometer_ga", 'm', "ut", "G", 100.0),
        ("sensor_combined", 0) => {
            let mut wants = vector("accelerometer_m_s2", 'a', "mps2", "m/s²", 1.0);
            wants.extend(vector("gyro_rad", 'g', "radps", "rad/s", 1.0));
            wants.extend(vector("magnetometer_ga", 'm', "ut", "G", 100.0));
            wants.push(want("baro_alt_meter", "height_m", "m", 1.0));
            wants.push(want("baro_temp_celcius", "baro_c", "°C", 1.0));
            wants
        }
        ("vehicle_acceleration", 0) => vector("xyz", 'a', "mps2", "m/s²", 1.0),
        ("vehicle_angular_velocity", 0) => vector("xyz", 'g', "radps", "rad/s", 1.0),
        ("vehicle_imu", 0) => imu(),
        ("sensor_accel", 0) => {
            let mut wants = three(axes, 'a', "mps2", "m/s²", 1.0);
            wants.push(Want { none: Some(0.0), ..want("temperature", "imu_c", "°C", 1.0) });
            wants
        }
        ("sensor_gyro", 0) => {
            let mut wants = three(axes, 'g', "radps", "rad/s", 1.0);
            wants.push(Want { none: Some(0.0), ..want("temperature", "imu_c", "°C", 1.0) });
            wants
        }
        ("vehicle_air_data", 0) => vec![
            want("baro_alt_meter", "height_m", "m", 1.0),
            want("baro_temp_celcius", "baro_c", "°C", 1.0),
            want("ambient_temperature", "ambient_c", "°C", 1.0),
        ],
        ("sensor_baro", 0) => {
            vec![want("temperature", "baro_c", "°C", 1.0), want("altitude", "height_m", "m", 1.0)]
        }
        ("battery_status", _) => vec![
            Want { none: Some(-1.0), ..want("current_a", numbered("current_a", instance), "A", 1.0) },
            want("voltage_v", numbered("voltage_v", instance), "V", 1.0),
            Want { none: Some(0.0), ..want("temperature", numbered("battery_c", instance), "°C", 1.0) },
        ],
        ("actuator_motors", 0) => {
            (0..12).map(|i| want(format!("control[{i}]"), format!("motor_{}", i + 1), "", 1.0)).collect()
        }
        ("actuator_outputs", _) => {
            let bank = if instance == 0 { String::new() } else { format!("{}_", u16::from(instance) + 1) };
            (0..16)
                .map(|i| want(format!("output[{i}]"), format!("output_{bank}{}", i + 1), "", 1.0))
                .collect()
        }
        // Thrust along down: minus is up.
        ("vehicle_thrust_setpoint", 0) => vec![want("xyz[2]", "throttle", "", -1.0)],
        ("actuator_controls_0", 0) => vec![want("control[3]", "throttle", "", 1.0)],
        ("manual_control_setpoint", 0) => {
            vec![want("throttle", "throttle_stick", "", 1.0), want("z", "throttle_stick", "", 1.0)]
        }
        ("esc_status", 0) => (0..12)
            .flat_map(|i| {
                let esc = i + 1;
                [
                    want(format!("esc[{i}].esc_current"), format!("esc_{esc}_a"), "A", 1.0),
                    want(format!("esc[{i}].esc_rpm"), format!("esc_{esc}_rpm"), "1/min", 1.0),
                    want(format!("esc[{i}].esc_temperature"), format!("esc_{esc}_c"), "°C", 1.0),
                ]
            })
            .collect(),
        ("vehicle_gps_position" | "sensor_gps", 0) => {
            let longitude =
                |path, scale| Want { between: Between::Circle, ..want(path, "lon_deg", "°", scale) };
            vec![
                Want { none: Some(0.0), ..want("latitude_deg", "lat_deg", "°", 1.0) },
                Want { none: Some(0.0), ..longitude("longitude_deg", 1.0) },
                want("altitude_msl_m", "gps_height_m", "m", 1.0),
                Want { none: Some(0.0), ..want("lat", "lat_deg", "1e-7 °", 1e-7) },
                Want { none: Some(0.0), ..longitude("lon", 1e-7) },
                want("alt", "gps_height_m", "mm", 1e-3),
                want("vel_m_s", GROUND[0], "m/s", 1.0),
                Want { between: Between::Circle, ..want("cog_rad", GROUND[1], "rad", 1f64.to_degrees()) },
                want("s_variance_m_s", GROUND[2], "m/s", 1.0),
            ]
        }
        // From the vehicle's axes (forward, right, down) to north, east, down.
        ("vehicle_attitude", 0) => ATTITUDE
            .into_iter()
            .enumerate()
            .map(|(at, name)| want(format!("q[{at}]"), name, "", 1.0))
            .collect(),
        ("actuator_armed", 0) => {
            vec![Want { between: Between::Hold, ..want("armed", "armed", "", 1.0) }]
        }
        ("vehicle_control_mode", 0) => {
            vec![Want { between: Between::Hold, ..want("flag_armed", "armed", "", 1.0) }]
        }
        _ => Vec::new(),
    }
}

/// Sums over an interval, divided by it.
fn imu() -> Vec<Want> {
    let mut wants = Vec::new();
    for (path, over_us, first, after, unit) in [
        ("delta_velocity", ["delta_velocity_dt", "dt"], 'a', "mps2", "m/s"),
        ("delta_angle", ["delta_angle_dt", "dt"], 'g', "radps", "rad"),
    ] {
        for over in over_us {
            let fields = vector(path, first, after, unit, 1.0);
            wants.extend(fields.into_iter().map(|want| Want { over_us: Some(over), ..want }));
        }
    }
    wants
}
