//! The heading of a board from its corrected field and the direction of gravity.

use crate::math;
use crate::vector::{cross, dot, minus, norm, scaled};

/// The nose has no heading where it points up or down by more than this sine: 72.5°, as where logs are compared.
const STEEPEST: f64 = 0.954;
/// The level part of the field has no direction where it is smaller than this share of the field.
const LEAST_LEVEL: f64 = 0.01;

/// Why there is no heading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NoHeading {
    /// The field or the specific force is zero or not finite.
    NotMeasured,
    /// The board's nose points straight up or down.
    Steep,
    /// The field is vertical.
    VerticalField,
}

/// The heading in degrees from 0 to 360, clockwise from north, tilt-compensated: magnetic north, or true north with the
/// declination, degrees, east positive.
///
/// Board's axes x forward, y right, z down. `specific_force_mps2` is what a resting accelerometer reads: 9.8 upwards, so that
/// down is its opposite; while the board accelerates, the heading is as wrong as that direction.
///
/// # Errors
/// [`NoHeading`].
///
/// ```
/// use ironout::heading::heading_deg;
/// // Level, nose to the east, in a field of 20 µT north and 45 µT down.
/// let heading = heading_deg([0.0, -20.0, 45.0], [0.0, 0.0, -9.81], 3.5)?;
/// assert!((heading - 93.5).abs() < 1e-9);
/// # Ok::<(), ironout::heading::NoHeading>(())
/// ```
pub fn heading_deg(
    corrected_ut: [f64; 3],
    specific_force_mps2: [f64; 3],
    declination_deg: f64,
) -> Result<f64, NoHeading> {
    let force = norm(specific_force_mps2);
    let field = norm(corrected_ut);
    // A NaN is no measurement either.
    if !(force > 0.0 && field > 0.0 && force.is_finite() && field.is_finite() && declination_deg.is_finite())
    {
        return Err(NoHeading::NotMeasured);
    }
    let down = scaled(specific_force_mps2, -1.0 / force);
    let [nose_down, ..] = down;
    if nose_down.abs() > STEEPEST {
        return Err(NoHeading::Steep);
    }
    let north = minus(corrected_ut, scaled(down, dot(corrected_ut, down)));
    if norm(north) < LEAST_LEVEL * field {
        return Err(NoHeading::VerticalField);
    }
    let east = cross(down, north);
    let ([north_ahead, ..], [east_ahead, ..]) = (north, east);
    let heading = math::atan2(east_ahead, north_ahead) * (180.0 / core::f64::consts::PI) + declination_deg;
    let turned = heading - 360.0 * math::floor(heading / 360.0);
    // Just below zero is rounded up to a full turn.
    Ok(if turned < 360.0 { turned } else { 0.0 })
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{NoHeading, heading_deg};
    use crate::vector::transposed_times;
    use std::vec::Vec;

    /// The rows of the rotation from body to world of a heading, pitch and roll, degrees (z-y-x).
    fn attitude(heading: f64, pitch: f64, roll: f64) -> [[f64; 3]; 3] {
        let ((sh, ch), (sp, cp), (sr, cr)) =
            (heading.to_radians().sin_cos(), pitch.to_radians().sin_cos(), roll.to_radians().sin_cos());
        [
            [ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr],
            [sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr],
            [-sp, cp * sr, cp * cr],
        ]
    }

    #[test]
    fn the_heading_is_that_of_the_attitude_whatever_the_tilt() {
        for heading in (0..360).step_by(15).map(f64::from) {
            for (pitch, roll) in [(0.0, 0.0), (40.0, -25.0), (-60.0, 170.0), (10.0, 90.0)] {
                let to_world = attitude(heading, pitch, roll);
                let field = transposed_times(&to_world, [22.0, 0.0, -41.0]);
                let force = transposed_times(&to_world, [0.0, 0.0, -9.81]);
                let found = heading_deg(field, force, 0.0).unwrap();
                let off = (found - heading + 540.0).rem_euclid(360.0) - 180.0;
                assert!(off.abs() < 1e-9, "{heading} {pitch} {roll}: {found}");
                assert!((0.0..360.0).contains(&found));
            }
        }
    }

    #[test]
    fn what_has_no_heading_says_why() {
        let force = [0.0, 0.0, -9.81];
        let refusals: Vec<_> = [
            heading_deg([f64::NAN, 0.0, 0.0], force, 0.0),
            heading_deg([20.0, 0.0, 40.0], [0.0; 3], 0.0),
            heading_deg([0.0, 0.0, 40.0], force, 0.0),
            heading_deg([20.0, 0.0, 40.0], [9.81, 0.0, 0.0], 0.0),
        ]
        .into_iter()
        .map(Result::unwrap_err)
        .collect();
        use NoHeading::{NotMeasured, Steep, VerticalField};
        assert_eq!(refusals, [NotMeasured, NotMeasured, VerticalField, Steep]);
    }
}
