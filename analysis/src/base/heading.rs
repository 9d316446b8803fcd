//! The heading of a level board, against a reference.

use crate::base::term::Term;
use crate::samples::samples::Samples;
use ironout::study::Model;
use nalgebra::Vector3;

/// Fewer headings are none.
const FEWEST: usize = 20;
/// The nose has a heading where it is this far from the vertical: sine of the angle.
const LEVEL: f64 = 0.3;

/// Heading of the nose from magnetic north, degrees clockwise from above, of a corrected field (any unit) and the
/// direction down (unit length), both in body axes (x forward, y right, z down). `None` where the nose points up or down,
/// or the field does.
pub fn heading_deg(field: [f64; 3], down: [f64; 3]) -> Option<f64> {
    let (h, down) = (Vector3::from(field), Vector3::from(down));
    let north = h - down * h.dot(&down);
    let east = down.cross(&north);
    let level = (1.0 - down.x * down.x).max(0.0).sqrt();
    (level >= LEVEL && north.norm() > 1e-6).then(|| east.x.atan2(north.x).to_degrees())
}

/// `one − other` as an angle between −180° and 180°.
pub fn difference_deg(one: f64, other: f64) -> f64 {
    (one - other + 540.0).rem_euclid(360.0) - 180.0
}

/// Headings against their reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadingError {
    /// How many.
    pub count: usize,
    /// Rms of the difference, degrees.
    pub rms_deg: f64,
    /// Its mean on the circle, degrees.
    pub mean_deg: f64,
    /// Its rms about that mean, degrees.
    pub spread_deg: f64,
}

impl HeadingError {
    /// Of differences in degrees; `None` of fewer than twenty.
    pub fn of(differences_deg: &[f64]) -> Option<Self> {
        let n = differences_deg.len() as f64;
        if differences_deg.len() < FEWEST {
            return None;
        }
        let rms = |about: f64| {
            let squares: f64 = differences_deg.iter().map(|d| difference_deg(*d, about).powi(2)).sum();
            (squares / n).sqrt()
        };
        let (sin, cos) = differences_deg.iter().fold((0.0, 0.0), |(sin, cos), d| {
            let (s, c) = d.to_radians().sin_cos();
            (sin + s, cos + c)
        });
        let mean_deg = f64::atan2(sin, cos).to_degrees();
        Some(HeadingError {
            count: differences_deg.len(),
            rms_deg: rms(0.0),
            mean_deg,
            spread_deg: rms(mean_deg),
        })
    }
}

/// Rms of the heading's error against the reference, degrees.
pub(crate) fn heading_error(
    samples: &Samples,
    model: &Model<f64>,
    terms: &[Term],
    reference: &[f64],
) -> Option<f64> {
    let mut differences = Vec::with_capacity(samples.len());
    for (index, reading) in samples.readings.iter().enumerate() {
        let (Some(down), Some(truth)) = (reading.down, reference.get(samples.row[index])) else { continue };
        if !truth.is_finite() {
            continue;
        }
        let at_sample: Vec<_> = terms.iter().map(|term| term.at_sample(index)).collect();
        let Ok(h) = model.correct(reading, &at_sample) else { continue };
        differences.extend(heading_deg(h, down).map(|heading| difference_deg(heading, *truth)));
    }
    HeadingError::of(&differences).map(|error| error.rms_deg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_board_reads_its_heading_and_a_steep_one_none() {
        // Looking east: north is to the left.
        assert!((heading_deg([0.0, -20.0, 40.0], [0.0, 0.0, 1.0]).expect("level") - 90.0).abs() < 1e-9);
        assert_eq!(heading_deg([20.0, 0.0, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(heading_deg([0.0, 0.0, 40.0], [0.0, 0.0, 1.0]), None);
    }

    #[test]
    fn differences_go_round_the_circle() {
        assert_eq!((difference_deg(359.0, 1.0), difference_deg(1.0, 359.0)), (-2.0, 2.0));
        let error = HeadingError::of(&[[179.0, -179.0]; 10].concat()).expect("twenty");
        assert!((error.rms_deg - 179.0).abs() < 1e-9 && error.mean_deg.abs() > 179.9, "{error:?}");
        assert!((error.spread_deg - 1.0).abs() < 1e-9, "{error:?}");
        assert_eq!(HeadingError::of(&[0.0; 19]), None);
    }
}
