//! The mountings that autopilots know by number.

/// Roll, pitch and yaw in degrees of `enum Rotation` of PX4 (src/lib/conversion/rotation.h) and of MAVLink's
/// MAV_SENSOR_ORIENTATION, by number: the sensor's axes are turned about x, then y, then z.
const ANGLES_DEG: [[u16; 3]; 48] = [
    [0, 0, 0],
    [0, 0, 45],
    [0, 0, 90],
    [0, 0, 135],
    [0, 0, 180],
    [0, 0, 225],
    [0, 0, 270],
    [0, 0, 315],
    [180, 0, 0],
    [180, 0, 45],
    [180, 0, 90],
    [180, 0, 135],
    [0, 180, 0],
    [180, 0, 225],
    [180, 0, 270],
    [180, 0, 315],
    [90, 0, 0],
    [90, 0, 45],
    [90, 0, 90],
    [90, 0, 135],
    [270, 0, 0],
    [270, 0, 45],
    [270, 0, 90],
    [270, 0, 135],
    [0, 90, 0],
    [0, 270, 0],
    [0, 180, 90],
    [0, 180, 270],
    [90, 90, 0],
    [180, 90, 0],
    [270, 90, 0],
    [90, 180, 0],
    [270, 180, 0],
    [90, 270, 0],
    [180, 270, 0],
    [270, 270, 0],
    [90, 180, 90],
    [90, 0, 270],
    [90, 68, 293],
    [0, 315, 0],
    [90, 315, 0],
    [270, 0, 180],
    [270, 0, 270],
    [0, 90, 180],
    [0, 9, 180],
    [0, 45, 0],
    [270, 0, 225],
    [270, 0, 315],
];

/// The angles of a numbered mounting; `None` where the number is none.
pub fn angles_deg(number: i64) -> Option<[f64; 3]> {
    ANGLES_DEG.get(usize::try_from(number).ok()?).map(|angles| angles.map(f64::from))
}

/// The matrix of a mounting by its number, from the sensor's axes to the body's.
pub fn mounting(number: i64) -> Option<[[f64; 3]; 3]> {
    angles_deg(number).map(matrix)
}

/// body = matrix · sensor, for a sensor turned by roll, pitch and yaw: Rz(yaw)·Ry(pitch)·Rx(roll).
pub fn matrix([roll, pitch, yaw]: [f64; 3]) -> [[f64; 3]; 3] {
    let ((sr, cr), (sp, cp), (sy, cy)) = (sin_cos(roll), sin_cos(pitch), sin_cos(yaw));
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

/// Quarter turns exactly: a turned axis keeps its digits.
fn sin_cos(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => other.to_radians().sin_cos(),
    }
}

/// From x forward, y left, z up (ROS REP 103, Betaflight, INAV) to x forward, y right, z down.
pub const LEFT_UP: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];

/// In words: `roll 180°, yaw 90°`.
pub fn words(angles_deg: [f64; 3]) -> String {
    let parts: Vec<String> = ["roll", "pitch", "yaw"]
        .iter()
        .zip(angles_deg)
        .filter(|(_, angle)| *angle != 0.0)
        .map(|(name, angle)| format!("{name} {angle}°"))
        .collect();
    if parts.is_empty() { "none".into() } else { parts.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_a_proper_rotation() {
        for number in 0..48 {
            let m = nalgebra::Matrix3::from_fn(|i, j| matrix(angles_deg(number).expect("known"))[i][j]);
            assert!((m.determinant() - 1.0).abs() < 1e-12, "{number}");
            assert!((m * m.transpose() - nalgebra::Matrix3::identity()).norm() < 1e-12, "{number}");
        }
        assert_eq!(angles_deg(-1), None);
        assert_eq!(angles_deg(48), None);
    }

    #[test]
    fn a_sensor_turned_right_has_its_x_axis_on_the_bodys_y() {
        let m = matrix(angles_deg(2).expect("yaw 90"));
        assert_eq!(m.map(|row| row[0]), [0.0, 1.0, 0.0]);
        assert_eq!(words([180.0, 0.0, 90.0]), "roll 180°, yaw 90°");
    }
}
