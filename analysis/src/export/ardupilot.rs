//! Parameters for ArduPilot, as Mission Planner, MAVProxy and QGroundControl load them.
//!
//! The formula is `AP_Compass_Backend::correct_field` of `libraries/AP_Compass/AP_Compass_Backend.cpp`, milligauss, in body axes
//! after `COMPASS_ORIENT`: `SCALE · (raw + OFS)` by the matrix of `DIA` and `ODI`, then `+ MOT · current` (A) or `throttle`.

use crate::export::error::CannotExport;
use crate::export::held::{Cause, Held, Room, Shape, Turns};
use crate::export::rotations::euler_deg;
use crate::export::words::{About, decimal, top};
use crate::frame::Program;
use nalgebra::Vector3;

/// What ArduPilot holds.
pub const ROOM: Room = Room {
    name: "ArduPilot",
    shape: Shape::Symmetric,
    turns: Turns::Numbered,
    power: true,
    temperature: false,
    program: Program::Ardupilot,
};

/// Milligauss in a µT.
const MILLIGAUSS: f64 = 10.0;
/// Offsets beyond this keep the vehicle from arming (`COMPASS_OFFS_MAX`), milligauss.
const MOST_OFFSET: f64 = 1800.0;
/// `ROTATION_CUSTOM_1`: by the angles of `CUST_ROT1`.
const CUSTOM_1: usize = 101;
const AXES: [&str; 3] = ["X", "Y", "Z"];

/// The file. `number` is that of the compass, from 1 (where absent, 1), `device_id` that of the sensor, if it is known.
///
/// # Errors
/// A number that ArduPilot does not have.
pub fn text(
    held: &Held,
    number: Option<usize>,
    device_id: Option<u32>,
    about: About,
) -> Result<String, CannotExport> {
    let suffix = match number.unwrap_or(1) {
        1 => String::new(),
        n @ 2..=3 => n.to_string(),
        number => return Err(CannotExport::NoNumber { target: ROOM.name, number, least: 1, most: 3 }),
    };
    let mut notes = vec![
        "field = M * SCALE * (raw + OFS) + MOT * current, milligauss, body axes after COMPASS_ORIENT; M is symmetric: DIA \
         is the diagonal, ODI is xy, xz, yz. Load it in Mission Planner under Config, Full Parameter List, or with \
         MAVProxy's \
         `param load`; then restart."
            .to_string(),
    ];
    let mut rows = String::new();
    let mut put = |name: String, value: String| rows += &format!("{name},{value}\n");
    if let Some(id) = device_id {
        put(format!("COMPASS_DEV_ID{suffix}"), id.to_string());
    }
    let turn = &held.turn;
    let matrix = turn * held.matrix * turn.transpose();
    let offset = -(turn * held.offset_without_power_ut()) * MILLIGAUSS;
    if offset.norm() > MOST_OFFSET {
        notes.push(format!(
            "The offset is longer than {MOST_OFFSET:.0} milligauss, the default of COMPASS_OFFS_MAX. The vehicle will not \
             arm unless you raise COMPASS_OFFS_MAX or move the compass away from iron and magnets."
        ));
    }
    let mut three = |name: &str, v: Vector3<f64>| {
        for axis in 0..3 {
            put(format!("COMPASS_{name}{suffix}_{}", AXES[axis]), decimal(v[axis]));
        }
    };
    three("OFS", offset);
    three("DIA", matrix.diagonal());
    three("ODI", Vector3::new(matrix[(0, 1)], matrix[(0, 2)], matrix[(1, 2)]));
    let power = held.power();
    let compensation = power.map_or_else(Vector3::zeros, |effect| {
        // After the matrix, and added.
        -(turn * held.matrix * effect.coefficient_ut) * MILLIGAUSS
    });
    three("MOT", compensation);
    put(format!("COMPASS_SCALE{suffix}"), decimal(1.0));
    if let Some(effect) = power {
        let (kind, what) = match effect.cause {
            Cause::Current => (2, "the battery's current"),
            _ => (1, "the throttle, 0 to 1"),
        };
        notes.push(format!(
            "COMPASS_MOTCT {kind} compensates for {what}: column {} of the log.",
            effect.column
        ));
        put("COMPASS_MOTCT".into(), kind.to_string());
    }
    let obeyed = "ArduPilot uses COMPASS_ORIENT for external compasses only. ironout takes the axes of the log as the sensor's own \
         axes.";
    if held.room.turns == Turns::Any {
        notes.push(format!(
            "{obeyed} CUST_ROT1 needs ArduPilot 4.3 or later, and must not be in use for something else."
        ));
        put(format!("COMPASS_ORIENT{suffix}"), CUSTOM_1.to_string());
        put("CUST_ROT_ENABLE".into(), "1".into());
        for (name, angle_deg) in ["ROLL", "PITCH", "YAW"].iter().zip(euler_deg(turn)) {
            put(format!("CUST_ROT1_{name}"), decimal(angle_deg));
        }
    } else if let Some(mounting) = held.mounting.filter(|mounting| !mounting.is_none()) {
        notes.push(obeyed.into());
        if held.is_own_log() {
            notes.push(
                "The calibration contains another mounting than the log was recorded with, so COMPASS_ORIENT changes with \
                 these numbers."
                    .into(),
            );
        }
        put(format!("COMPASS_ORIENT{suffix}"), mounting.number.to_string());
    }
    let notes: Vec<&str> = notes.iter().map(String::as_str).collect();
    Ok(top(held, about, "#", &notes) + &rows)
}
