//! Where to turn the board next, as a hand can do it: an axis of the sensor, and whether it belongs towards the ground or the sky.

/// A component of a direction that is named: the cosine of 66°, as between a face and its corners.
const NAMED: f32 = 0.4;
/// A field that dips less than this is not called up or down, degrees: a hand does not hold a board truer.
const LEVEL_DEG: f64 = 20.0;
/// An axis pointed to the ground if it was this close to it: the cosine of 45°, closer than to any level direction.
const TO_THE_GROUND: f64 = 0.707;

/// What to do so that the field comes through the board along `gap`, a unit vector in the sensor's axes. `start_down` is the
/// direction to the ground when the log began, in the same axes, and `dip_deg` the angle of the field below the horizon; each
/// is left out of the words if no accelerometer tells it.
pub(crate) fn where_to_turn(gap: [f32; 3], start_down: Option<[f64; 3]>, dip_deg: Option<f64>) -> String {
    let axes: Vec<String> = (gap.iter().zip(["x", "y", "z"]))
        .filter(|(part, _)| part.abs() >= NAMED)
        .map(|(part, axis)| format!("{}{axis}", if *part > 0.0 { '+' } else { '−' }))
        .collect();
    let side = match axes.as_slice() {
        [axis] => format!("the sensor's {axis} axis"),
        axes => format!("the direction between the sensor's {} axes", axes.join(" and ")),
    };
    let was = start_down.map_or("", |down| {
        match (0..3).map(|axis| f64::from(gap[axis]) * down[axis]).sum::<f64>() {
            along if along > TO_THE_GROUND => " (at the start of the log it pointed to the ground)",
            along if along < -TO_THE_GROUND => " (at the start of the log it pointed to the sky)",
            _ => "",
        }
    });
    let place = match dip_deg {
        Some(dip_deg) if dip_deg > LEVEL_DEG => "at the ground",
        Some(dip_deg) if dip_deg < -LEVEL_DEG => "at the sky",
        Some(_) => "north",
        None => "along the field (in the north steeply down, in the south steeply up)",
    };
    format!("point {side}{was} {place}, and turn the board slowly about that line")
}

#[cfg(test)]
mod tests {
    use super::where_to_turn;

    #[test]
    fn the_missing_side_is_named_by_the_accelerometer_whatever_the_axes() {
        // Two boards that lay flat at the start: z of one pointed down, z of the other up. In the north the field goes down.
        for (z, was) in [(1.0, "sky"), (-1.0, "ground")] {
            let words = where_to_turn([0.0, 0.0, -1.0], Some([0.0, 0.0, z]), Some(64.0));
            let expected = format!(
                "point the sensor's −z axis (at the start of the log it pointed to the {was}) at the ground, and turn the board \
                 slowly about that line"
            );
            assert_eq!(words, expected);
        }
        let south = where_to_turn([0.0, 0.0, -1.0], Some([1.0, 0.0, 0.0]), Some(-64.0));
        assert!(south.starts_with("point the sensor's −z axis at the sky,"), "{south}");
        let blind = where_to_turn([0.7, -0.7, 0.1], None, None);
        assert!(blind.contains("between the sensor's +x and −y axes along the field"), "{blind}");
        assert!(where_to_turn([1.0, 0.0, 0.0], None, Some(5.0)).contains("+x axis north"));
    }
}
