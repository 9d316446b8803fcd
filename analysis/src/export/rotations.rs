//! The mountings that autopilots number: those of `MAV_SENSOR_ORIENTATION` 0 to 37, which PX4 (`lib/conversion/rotation.h`) and
//! ArduPilot (`AP_Math/rotations.h`) share.

use nalgebra::{Matrix3, Vector3};

/// Roll, pitch and yaw in degrees; the place in the table is the number.
const TABLE: [[f64; 3]; 38] = [
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 45.0],
    [0.0, 0.0, 90.0],
    [0.0, 0.0, 135.0],
    [0.0, 0.0, 180.0],
    [0.0, 0.0, 225.0],
    [0.0, 0.0, 270.0],
    [0.0, 0.0, 315.0],
    [180.0, 0.0, 0.0],
    [180.0, 0.0, 45.0],
    [180.0, 0.0, 90.0],
    [180.0, 0.0, 135.0],
    [0.0, 180.0, 0.0],
    [180.0, 0.0, 225.0],
    [180.0, 0.0, 270.0],
    [180.0, 0.0, 315.0],
    [90.0, 0.0, 0.0],
    [90.0, 0.0, 45.0],
    [90.0, 0.0, 90.0],
    [90.0, 0.0, 135.0],
    [270.0, 0.0, 0.0],
    [270.0, 0.0, 45.0],
    [270.0, 0.0, 90.0],
    [270.0, 0.0, 135.0],
    [0.0, 90.0, 0.0],
    [0.0, 270.0, 0.0],
    [0.0, 180.0, 90.0],
    [0.0, 180.0, 270.0],
    [90.0, 90.0, 0.0],
    [180.0, 90.0, 0.0],
    [270.0, 90.0, 0.0],
    [90.0, 180.0, 0.0],
    [270.0, 180.0, 0.0],
    [90.0, 270.0, 0.0],
    [180.0, 270.0, 0.0],
    [270.0, 270.0, 0.0],
    [90.0, 180.0, 90.0],
    [90.0, 0.0, 270.0],
];

/// A numbered mounting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation {
    /// Its number.
    pub number: usize,
    /// `body = matrix · sensor`.
    pub matrix: Matrix3<f64>,
}

/// Sine and cosine, exact for the multiples of 90°.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let exact = |v: f64| if (v - v.round()).abs() < 1e-12 { v.round() } else { v };
    (exact(sin), exact(cos))
}

fn matrix([roll, pitch, yaw]: [f64; 3]) -> Matrix3<f64> {
    let ((sr, cr), (sp, cp), (sy, cy)) = (sin_cos(roll), sin_cos(pitch), sin_cos(yaw));
    let x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr);
    let y = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
    let z = Matrix3::new(cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0);
    z * y * x
}

/// Roll, pitch and yaw of a rotation `Rz(yaw)·Ry(pitch)·Rx(roll)`, degrees.
pub fn euler_deg(rotation: &Matrix3<f64>) -> [f64; 3] {
    let r = rotation;
    let pitch = -r[(2, 0)].clamp(-1.0, 1.0).asin();
    // With the nose up or down roll and yaw are one angle: all of it is yaw.
    let (roll, yaw) = if r[(2, 0)].abs() > 1.0 - 1e-12 {
        (0.0, f64::atan2(-r[(0, 1)], r[(1, 1)]))
    } else {
        (f64::atan2(r[(2, 1)], r[(2, 2)]), f64::atan2(r[(1, 0)], r[(0, 0)]))
    };
    [roll, pitch, yaw].map(f64::to_degrees)
}

/// Angle of a rotation, degrees; precise for small ones too.
pub fn angle_deg(rotation: &Matrix3<f64>) -> f64 {
    let r = rotation;
    let axis = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
    f64::atan2(axis.norm() / 2.0, (r.trace() - 1.0) / 2.0).to_degrees()
}

impl Rotation {
    /// No rotation.
    pub fn none() -> Self {
        Rotation { number: 0, matrix: Matrix3::identity() }
    }

    /// The numbered one; `None` beyond the table.
    pub fn numbered(number: usize) -> Option<Self> {
        TABLE.get(number).map(|angles| Rotation { number, matrix: matrix(*angles) })
    }

    /// The one that leaves the least rotation next to it; of equal ones the first.
    pub fn nearest(rotation: &Matrix3<f64>) -> Self {
        let left = |one: &Self| angle_deg(&(rotation * one.matrix.transpose()));
        let mut best = Self::none();
        for one in (0..TABLE.len()).filter_map(Self::numbered) {
            if left(&one) < left(&best) - 1e-6 {
                best = one;
            }
        }
        best
    }

    /// Whether it turns nothing.
    pub fn is_none(&self) -> bool {
        self.number == 0
    }

    /// Its name: `roll 180, yaw 90`.
    pub fn name(&self) -> String {
        let angles = TABLE.get(self.number).copied().unwrap_or_default();
        let words: Vec<String> = (["roll", "pitch", "yaw"].iter().zip(angles))
            .filter(|(_, angle)| *angle != 0.0)
            .map(|(name, angle)| format!("{name} {angle:.0}"))
            .collect();
        if words.is_empty() { "none".into() } else { words.join(", ") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::order::AxisOrder;

    #[test]
    fn every_mounting_by_right_angles_is_in_the_table() {
        for order in AxisOrder::mountings() {
            let nearest = Rotation::nearest(&order.to_board());
            assert!(angle_deg(&(order.to_board() * nearest.matrix.transpose())) < 1e-6, "{order}");
        }
        assert_eq!(Rotation::nearest(&matrix([180.0, 0.0, 0.0])).name(), "roll 180");
        assert_eq!(Rotation::nearest(&matrix([1.0, 0.0, 44.0])).number, 1);
        assert_eq!(Rotation::numbered(38), None);
    }

    #[test]
    fn euler_angles_make_the_rotation_again() {
        let own = [
            [10.0, 20.0, 30.0],
            [-170.0, 5.0, 100.0],
            [0.0, 0.0, 0.0],
            [90.0, 90.0, 0.0],
            [45.0, -90.0, 10.0],
        ];
        for angles in own.into_iter().chain(TABLE) {
            let rotation = matrix(angles);
            assert!((matrix(euler_deg(&rotation)) - rotation).norm() < 1e-9, "{angles:?}");
        }
    }

    #[test]
    fn small_angles_keep_their_digits() {
        let small = matrix([0.0, 0.0, 1e-5]);
        assert!((angle_deg(&small) - 1e-5).abs() < 1e-12);
    }
}
