//! The heading against a reference, and what it alone can tell: a field from its opposite.

use crate::base::piece::Piece;
use crate::samples::samples::Samples;
use ironout::study::Model;
use nalgebra::Vector3;

/// Headings that are off by more than this, rms degrees, are backwards if their opposites ...
const BACKWARDS_DEG: f64 = 120.0;
/// ... are off by less than this.
const FORWARDS_DEG: f64 = 60.0;

/// Rms of the heading's error against the reference, degrees.
pub(crate) fn heading_error(
    samples: &Samples,
    model: &Model<f64>,
    pieces: &[Piece],
    reference: &[f64],
) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for (index, reading) in samples.readings.iter().enumerate() {
        let (Some(down), Some(truth)) = (reading.down, reference.get(samples.row[index])) else { continue };
        if !truth.is_finite() {
            continue;
        }
        let terms: Vec<_> = pieces.iter().map(|piece| piece.term(index)).collect();
        let Ok(h) = model.correct(reading, &terms) else { continue };
        let (h, down) = (Vector3::from(h), Vector3::from(down));
        let north = h - down * h.dot(&down);
        let east = down.cross(&north);
        // Near the vertical the nose has no heading.
        let level = (1.0 - down.x * down.x).sqrt();
        if level < 0.3 || north.norm() < 1e-6 {
            continue;
        }
        let heading = east.x.atan2(north.x).to_degrees();
        let error = (heading - truth + 540.0).rem_euclid(360.0) - 180.0;
        sum += error * error;
        count += 1.0;
    }
    (count >= 20.0).then(|| (sum / count).sqrt())
}

/// Whether headings with the rms error `own_deg` are backwards, where the opposite field gives `opposite_deg`.
pub(crate) fn backwards(own_deg: f64, opposite_deg: f64) -> bool {
    own_deg > BACKWARDS_DEG && opposite_deg < FORWARDS_DEG
}

/// The same model with the corrected field the other way.
pub(crate) fn mirrored(model: &Model<f64>) -> Option<Model<f64>> {
    let rotation = model.rotation.map(|row| row.map(|value| -value));
    Model::new(model.offset_ut, model.matrix, model.field_ut, rotation, -model.sin_dip)
}

/// An order of axes, as in `y,-x,z`, with every sign turned round.
pub(crate) fn negated(order: &str) -> String {
    let turned = |axis: &str| match axis.strip_prefix('-') {
        Some(axis) => axis.to_string(),
        None => format!("-{axis}"),
    };
    order.split(',').map(turned).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_turned_round_twice_is_itself() {
        assert_eq!(negated("y,-x,z"), "-y,x,-z");
        assert_eq!(negated(&negated("-z,y,x")), "-z,y,x");
    }

    #[test]
    fn only_headings_that_are_right_the_other_way_are_backwards() {
        assert!(backwards(178.0, 2.0));
        assert!(!backwards(104.0, 104.0) && !backwards(5.0, 175.0));
    }
}
