//! Where to turn the board next, in words that a hand can follow.

/// A component of a direction that is named: the cosine of 66°, as between a face and its corners.
const NAMED: f32 = 0.4;
/// A field that dips less than this is not called steep, degrees: a hand does not hold a board truer.
const LEVEL_DEG: f64 = 20.0;
/// An axis was upright if it was this close to the vertical: the cosine of 45°, closer than to any level direction.
const UPRIGHT: f64 = 0.707;

/// What to do so that the field comes through the board along `gap`, a unit vector in the axes of the fit. `start_down` is the
/// direction to the ground when the log began, in the same axes, and `dip_deg` the angle of the field below the horizon; each
/// is `None` if no accelerometer tells it.
///
/// An accelerometer of reversed sign turns both around. The words are the same then: they say how to turn from the start of the
/// log, or name ground and sky together.
pub(crate) fn where_to_turn(gap: [f32; 3], start_down: Option<[f64; 3]>, dip_deg: Option<f64>) -> String {
    let axes: Vec<String> = (gap.iter().zip(["x", "y", "z"]))
        .filter(|(part, _)| part.abs() >= NAMED)
        .map(|(part, axis)| format!("{}{axis}", if *part > 0.0 { '+' } else { '−' }))
        .collect();
    let side = match axes.as_slice() {
        [axis] => format!("the {axis} axis of this fit"),
        axes => format!("the direction between the {} axes of this fit", axes.join(" and ")),
    };
    let upright = start_down
        .map(|down| (0..3).map(|axis| f64::from(gap[axis]) * down[axis]).sum::<f64>())
        .filter(|along| along.abs() > UPRIGHT);
    let how = match (dip_deg, upright) {
        (None, _) => {
            format!(
                "point {side} along the field (steeply down in the northern hemisphere, steeply up in the southern)"
            )
        }
        (Some(dip_deg), _) if dip_deg.abs() < LEVEL_DEG => format!("point {side} north, then south"),
        (Some(dip_deg), Some(along)) if along * dip_deg < 0.0 => {
            "hold the sensor upside down, compared with the start of the log".to_owned()
        }
        (Some(_), Some(_)) => "hold the sensor as at the start of the log".to_owned(),
        (Some(_), None) => format!("point {side} at the ground, then at the sky"),
    };
    format!("{how}. Rotate it slowly there, tilted by up to 30°")
}

#[cfg(test)]
mod tests {
    use super::where_to_turn;

    #[test]
    fn the_missing_side_is_found_whatever_the_axes_and_the_sign_of_the_accelerometer() {
        let down_z = [0.0, 0.0, 1.0];
        for (gap, down, dip_deg, words) in [
            (
                [0.0, 0.0, -1.0],
                down_z,
                64.0,
                "hold the sensor upside down, compared with the start of the log.",
            ),
            ([0.0, 0.0, 1.0], down_z, 64.0, "hold the sensor as at the start of the log."),
            (
                [0.0, 0.0, 1.0],
                down_z,
                -64.0,
                "hold the sensor upside down, compared with the start of the log.",
            ),
            ([1.0, 0.0, 0.0], down_z, 64.0, "point the +x axis of this fit at the ground, then at the sky."),
            ([0.0, -1.0, 0.0], down_z, 5.0, "point the −y axis of this fit north, then south."),
        ] {
            for sign in [1.0, -1.0] {
                let said = where_to_turn(gap, Some(down.map(|part| sign * part)), Some(sign * dip_deg));
                assert!(said.starts_with(words), "{gap:?} {sign}: {said}");
            }
        }
        let blind = where_to_turn([0.7, -0.7, 0.1], None, None);
        assert!(
            blind.starts_with("point the direction between the +x and −y axes of this fit along the field"),
            "{blind}"
        );
    }
}
