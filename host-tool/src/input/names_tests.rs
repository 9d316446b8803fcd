//! The names of many programs, understood.

use super::names::{Kind, meaning, speaks_of_field};

#[test]
fn names_of_people() {
    use Kind::*;
    for (header, kind, axis, unit) in [
        ("MagX", Field, Some(0), ""),
        ("magY", Field, Some(1), ""),
        ("mag_z (uT)", Field, Some(2), "uT"),
        ("magnetometer_ga[0]", Field, Some(0), "G"),
        ("magADC[2]", Field, Some(2), ""),
        ("field.magnetic_field.x", Field, Some(0), ""),
        ("/imu/mag/magnetic_field/y", Field, Some(1), ""),
        ("X (µT)", Field, Some(0), "uT"),
        ("Magnetic Field x (µT)", Field, Some(0), "uT"),
        ("MAGNETIC FIELD X (μT)", Field, Some(0), "uT"),
        ("Magnetfeld z (µT)", Field, Some(2), "uT"),
        ("mag_uT_x", Field, Some(0), "uT"),
        ("MX_UT", Field, Some(0), "uT"),
        ("mx_nt", Field, Some(0), "nT"),
        ("Bx", Field, Some(0), ""),
        ("B_y [nT]", Field, Some(1), "nT"),
        ("mx", Field, Some(0), ""),
        ("xmag", Field, Some(0), ""),
        ("magx", Field, Some(0), ""),
        ("Mag (uT)[1]", Field, Some(1), "uT"),
        ("mag.x", Field, Some(0), ""),
        ("mag[0]", Field, Some(0), ""),
        ("magnetometerX(µT)", Field, Some(0), "uT"),
        ("magnetic_field.x", Field, Some(0), ""),
        ("Compass Z", Field, Some(2), ""),
        ("Absolute field (µT)", Derived, None, "uT"),
        ("mag_norm", Derived, None, ""),
        ("Total", Derived, None, ""),
        ("|B| (nT)", Derived, None, "nT"),
        ("total_current_a", Electric, None, "A"),
        ("field.magnetic_field_covariance0", Other, Some(0), ""),
        ("Time (s)", Time, None, "s"),
        ("time [ms]", Time, None, "ms"),
        ("time (us)", Time, None, "us"),
        ("timestamp", Time, None, ""),
        ("timestamp_ns", Time, None, "ns"),
        ("TimeUS", Time, None, "us"),
        ("t_ms", Time, None, "ms"),
        ("%time", Time, None, ""),
        ("field.header.stamp", Time, None, ""),
        ("seconds_elapsed", Time, None, "s"),
        ("Time since start in ms ", Time, None, "ms"),
        ("millis", Time, None, "ms"),
        ("AccX", Accel, Some(0), ""),
        ("accel_x (m/s²)", Accel, Some(0), "m/s2"),
        ("ACCELEROMETER X (m/s²)", Accel, Some(0), "m/s2"),
        ("accelerometer_m_s2[1]", Accel, Some(1), "m/s2"),
        ("accelerometerAccelerationX(G)", Accel, Some(0), "g"),
        ("ax_mps2", Accel, Some(0), "m/s2"),
        ("ax_mg", Accel, Some(0), "mg"),
        ("gFx", Accel, Some(0), "g"),
        ("field.linear_acceleration.x", Accel, Some(0), ""),
        ("Linear Acceleration x (m/s^2)", Other, Some(0), ""),
        ("gyro_x_dps", Gyro, Some(0), "deg/s"),
        ("gyro_rad[2]", Gyro, Some(2), "rad/s"),
        ("GYROSCOPE Z (rad/s)", Gyro, Some(2), "rad/s"),
        ("gx", Gyro, Some(0), ""),
        ("wy", Gyro, Some(1), ""),
        ("angular_velocity.z", Gyro, Some(2), ""),
        ("temperature", Temperature, None, ""),
        ("Temp (°C)", Temperature, None, "C"),
        ("temp_k", Temperature, None, "K"),
        ("T_board [°F]", Temperature, None, "F"),
        ("amperageLatest (A)", Electric, None, "A"),
        ("battery_current_a", Electric, None, "A"),
        ("Azimuth", Attitude, None, ""),
        ("roll (deg)", Attitude, None, ""),
        ("field.header.seq", Counter, None, ""),
        ("loopIteration", Counter, None, ""),
        ("I", Instance, None, ""),
        ("sensor", Instance, None, ""),
        ("OfsX", Other, Some(0), ""),
        ("throttle", Other, None, ""),
        ("motor[0]", Other, Some(0), ""),
    ] {
        let found = meaning(header);
        let name = found.unit.as_ref().map(|unit| unit.name.to_string()).unwrap_or_default();
        assert_eq!((found.kind, found.axis, name.as_str()), (kind, axis, unit), "{header}: {found:?}");
    }
}

#[test]
fn axes_of_one_vector_have_one_stem() {
    for triple in [
        ["MagX", "MagY", "MagZ"],
        ["mag1_x (uT)", "mag1_y (uT)", "mag1_z (uT)"],
        ["magnetometer_ga[0]", "magnetometer_ga[1]", "magnetometer_ga[2]"],
        ["x", "y", "z"],
        ["xmag", "ymag", "zmag"],
    ] {
        let stems = triple.map(|header| meaning(header).stem);
        assert!(stems[0] == stems[1] && stems[1] == stems[2], "{stems:?}");
        assert_eq!(triple.map(|header| meaning(header).axis), [Some(0), Some(1), Some(2)]);
    }
    assert_ne!(meaning("mag1_x").stem, meaning("mag2_x").stem);
    assert!(speaks_of_field("MagnetometerUncalibrated") && !speaks_of_field("Accelerometer"));
}

#[test]
fn any_name_is_understood_or_not_and_never_a_panic() {
    for name in [
        "", " ", "[", "]", "()", "[0]", "(x)", "_", "é", "字[1]", "µ", "a_", "_t", "%", "x[", "1", "²", "/",
        "a/", "/T", "😀_ut",
    ] {
        let _ = meaning(name);
    }
}
