//! Parameters for PX4, as QGroundControl loads them.
//!
//! The formula is `Magnetometer::Correct` of `src/lib/sensor_calibration/Magnetometer.hpp`, gauss, in the sensor's axes:
//! `R_ROT · S · (data + power·COMP − thermal − OFF)`; the power is the battery's current in kA, or the thrust from 0 to 1
//! (`vehicle_magnetometer/VehicleMagnetometer.cpp`); the thermal offset is a polynomial in `T − TREF`, with `T` held between
//! `TMIN` and `TMAX` (`temperature_compensation/TemperatureCompensation.cpp`).

use crate::export::error::CannotExport;
use crate::export::held::{Cause, Held, Room, Shape, Turns};
use crate::export::rotations::euler_deg;
use crate::export::words::{About, decimal, top};
use crate::frame::Program;
use nalgebra::Vector3;

/// What PX4 holds.
pub const ROOM: Room = Room {
    name: "PX4",
    shape: Shape::Symmetric,
    turns: Turns::Numbered,
    power: true,
    temperature: true,
    program: Program::Px4,
};

/// µT in a gauss.
const GAUSS: f64 = 100.0;
/// Types of MAVLink: `MAV_PARAM_TYPE_REAL32` and `MAV_PARAM_TYPE_INT32`.
const REAL32: u8 = 9;
const INT32: u8 = 6;
/// `ROTATION_CUSTOM`: by Euler angles.
const CUSTOM: usize = 100;
const AXES: [&str; 3] = ["X", "Y", "Z"];

/// The file. `number` is the n of `CAL_MAGn` (0 where absent), `device_id` that of the sensor, if it is known.
///
/// # Errors
/// A number that PX4 does not have.
pub fn text(
    held: &Held,
    number: Option<usize>,
    device_id: Option<u32>,
    about: About,
) -> Result<String, CannotExport> {
    let n = number.unwrap_or(0);
    if n > 3 {
        return Err(CannotExport::NoNumber { target: ROOM.name, number: n, least: 0, most: 3 });
    }
    let mut notes = vec![
        "corrected = ROT * SCALE * (sensor + power * COMP - thermal - OFF), gauss, sensor axes; SCALE is symmetric; ODIAG \
         is off the diagonal. Load it with QGroundControl: Vehicle Setup, Parameters, Tools, Load from file; restart."
            .to_string(),
    ];
    if device_id.is_none() {
        notes.push(format!(
            "CAL_MAG{n}_ID stays unchanged: PX4 finds a calibration by the sensor's device id. If slot {n} does not belong \
             to this sensor, export with --number, or give --device-id."
        ));
    }
    let mut rows = String::new();
    let mut put = |name: String, value: String, kind: u8| rows += &format!("1\t1\t{name}\t{value}\t{kind}\n");
    // As the parameter is signed, an id beyond its half is a negative number.
    let signed = |id: u32| id.cast_signed().to_string();
    if let Some(id) = device_id {
        put(format!("CAL_MAG{n}_ID"), signed(id), INT32);
    }
    let mut three = |name: &dyn Fn(usize) -> String, v: Vector3<f64>| {
        for axis in 0..3 {
            put(name(axis), decimal(v[axis]), REAL32);
        }
    };
    let s = &held.matrix;
    three(&|axis| format!("CAL_MAG{n}_{}OFF", AXES[axis]), held.offset_without_power_ut() / GAUSS);
    three(&|axis| format!("CAL_MAG{n}_{}SCALE", AXES[axis]), s.diagonal());
    three(&|axis| format!("CAL_MAG{n}_{}ODIAG", AXES[axis]), Vector3::new(s[(0, 1)], s[(0, 2)], s[(1, 2)]));
    let power = held.power();
    // µT an ampere are 10 G a kiloampere; it is added, where the calibration takes away.
    let compensation = match power {
        Some(effect) if effect.cause == Cause::Current => -effect.coefficient_ut * (1000.0 / GAUSS),
        Some(effect) => -effect.coefficient_ut / GAUSS,
        None => Vector3::zeros(),
    };
    three(&|axis| format!("CAL_MAG{n}_{}COMP", AXES[axis]), compensation);
    if let Some(effect) = power {
        let (kind, what) = match effect.cause {
            Cause::Current => (2, "the current of the first battery"),
            _ => (1, "the thrust"),
        };
        notes.push(format!(
            "CAL_MAG_COMP_TYP {kind} compensates for {what}: column {} of the log.",
            effect.column
        ));
        put("CAL_MAG_COMP_TYP".into(), kind.to_string(), INT32);
    }
    thermal(held, n, device_id.map(signed), &mut put, &mut notes);
    let obeyed =
        "PX4 uses CAL_MAGn_ROT for external magnetometers only. It knows the mounting of internal ones.";
    if held.room.turns == Turns::Any {
        notes.push(format!("{obeyed} The angles need PX4 1.14 or later."));
        put(format!("CAL_MAG{n}_ROT"), CUSTOM.to_string(), INT32);
        for (name, angle_deg) in ["ROLL", "PITCH", "YAW"].iter().zip(euler_deg(&held.turn)) {
            put(format!("CAL_MAG{n}_{name}"), decimal(angle_deg), REAL32);
        }
    } else if held.is_own_log() && held.mounting.is_none() {
        notes.push(format!("CAL_MAG{n}_ROT stays unchanged: the log was recorded with it."));
    } else if let Some(mounting) = held.mounting.filter(|mounting| !mounting.is_none()) {
        notes.push(obeyed.into());
        put(format!("CAL_MAG{n}_ROT"), mounting.number.to_string(), INT32);
    }
    let notes: Vec<&str> = notes.iter().map(String::as_str).collect();
    Ok(format!("{}# Vehicle-Id\tComponent-Id\tName\tValue\tType\n{rows}", top(held, about, "#", &notes)))
}

/// `TC_Mn_*`, where the target holds a temperature: `θ₁(T − r₁) + θ₂(T² − r₂)` about `TREF`.
fn thermal(
    held: &Held,
    n: usize,
    id: Option<String>,
    put: &mut dyn FnMut(String, String, u8),
    notes: &mut Vec<String>,
) {
    let warm = || held.effects.iter().filter(|effect| effect.cause == Cause::Temperature);
    let Some(first) = warm().next() else { return };
    let plain = warm().find(|effect| !effect.squared);
    let tref = plain.map_or_else(|| first.reference.max(0.0).sqrt(), |effect| effect.reference);
    let mut x = [Vector3::zeros(); 3];
    let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
    for effect in warm() {
        let theta = effect.coefficient_ut / GAUSS;
        x[0] += theta * effect.factor(tref);
        if effect.squared {
            x[1] += theta * (2.0 * tref);
            x[2] += theta;
        } else {
            x[1] += theta;
        }
        if let Some([from, to]) = effect.range {
            (least, most) = (least.max(from), most.min(to));
        }
    }
    put("TC_M_ENABLE".into(), "1".into(), INT32);
    match id {
        Some(id) => put(format!("TC_M{n}_ID"), id, INT32),
        None => notes.push(format!(
            "TC_M{n}_ID stays unchanged. Without the sensor's device id in it PX4 does not compensate for temperature. Fix: \
             give --device-id."
        )),
    }
    for (power, x) in x.iter().enumerate() {
        for axis in 0..3 {
            put(format!("TC_M{n}_X{power}_{axis}"), decimal(x[axis]), REAL32);
        }
    }
    for axis in 0..3 {
        put(format!("TC_M{n}_X3_{axis}"), decimal(0.0), REAL32);
    }
    put(format!("TC_M{n}_TREF"), decimal(tref), REAL32);
    if least < most && least.is_finite() && most.is_finite() {
        put(format!("TC_M{n}_TMIN"), decimal(least), REAL32);
        put(format!("TC_M{n}_TMAX"), decimal(most), REAL32);
        notes.push(
            "Outside TMIN and TMAX, the range of the log, PX4 keeps the thermal offset constant.".into(),
        );
    }
    notes.push(format!(
        "TC_M{n} follows the temperature that the magnetometer itself reports: column {} of the log must be that.",
        first.column
    ));
}
