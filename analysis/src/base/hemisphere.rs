//! A field or its opposite: what the dip cannot tell, and a heading or the place can.

use crate::base::alignment::Alignment;
use crate::base::heading::heading_error;
use crate::base::mounting::{DecidedBy, Doubt, OrderStatus};
use crate::base::term::Term;
use crate::bounds::{FORWARDS_DEG, MIN_DIP_DEG, NEAR_DEG};
use crate::samples::samples::Samples;
use ironout::study::Model;

/// What is known besides the field.
#[derive(Debug, Clone, Copy, Default)]
pub struct Evidence<'t> {
    /// Reference heading of each row of the log, degrees; NaN where it is missing.
    pub heading_deg: Option<&'t [f64]>,
    /// Dip of the place below the horizon, degrees.
    pub dip_deg: Option<f64>,
}

/// The same model with the corrected field the other way.
fn opposite(model: &Model<f64>) -> Option<Model<f64>> {
    let rotation = model.rotation.map(|row| row.map(|value| -value));
    Model::new(model.offset_ut, model.matrix, model.field_ut, rotation, -model.sin_dip)
}

/// Chooses between the alignment that the dip found, whose rotation is proper, and its opposite: how the axes stand, and the
/// model that belongs to it.
pub(crate) fn settle(
    samples: &Samples,
    found: &Alignment,
    terms: &[Term],
    evidence: Evidence,
) -> (OrderStatus, Model<f64>) {
    let (model, by_gyro) = (found.model, found.by_gyro);
    let dip_deg = model.sin_dip.clamp(-1.0, 1.0).asin().to_degrees();
    let twin = opposite(&model);
    let by_heading = evidence.heading_deg.and_then(|reference| {
        let error = |model: &Model<f64>| heading_error(samples, model, terms, reference);
        Some(of_headings(error(&model)?, error(twin.as_ref()?)?))
    });
    let by_place = evidence.dip_deg.map(|expected_deg| of_dips(dip_deg, expected_deg));
    let is_opposite = match (by_heading, by_place) {
        (Some(Ok(heading)), Some(Ok(place))) if heading != place => Err(Doubt::Contradiction),
        (Some(Ok(heading)), _) => Ok((heading, DecidedBy::Heading)),
        (_, Some(Ok(place))) => Ok((place, DecidedBy::Place)),
        (Some(Err(doubt)), _) | (None, Some(Err(doubt))) => Err(doubt),
        (None, None) => Err(Doubt::NothingKnown),
    };
    match (is_opposite, twin) {
        (Ok((true, by)), Some(twin)) => {
            let order = found.order.opposite();
            (OrderStatus { order, dip_deg: -dip_deg, decided: Ok(by), by_gyro }, twin)
        }
        (decided, _) => {
            let decided = decided.map(|(_, by)| by);
            (OrderStatus { order: found.order, dip_deg, decided, by_gyro }, model)
        }
    }
}

/// Whether headings that are off by `own_deg` rms are those of the opposite field, which is off by `opposite_deg`.
fn of_headings(own_deg: f64, opposite_deg: f64) -> Result<bool, Doubt> {
    let backwards = |wrong: f64, right: f64| wrong > 180.0 - FORWARDS_DEG && right < FORWARDS_DEG;
    match (backwards(own_deg, opposite_deg), backwards(opposite_deg, own_deg)) {
        (true, _) => Ok(true),
        (_, true) => Ok(false),
        _ => Err(Doubt::OtherHeading { own_deg, opposite_deg }),
    }
}

/// Whether a field with this dip is the opposite of that of the place.
fn of_dips(dip_deg: f64, expected_deg: f64) -> Result<bool, Doubt> {
    if expected_deg.abs() < MIN_DIP_DEG || dip_deg.abs() < MIN_DIP_DEG {
        return Err(Doubt::LevelField { expected_deg });
    }
    if (dip_deg - expected_deg).abs() <= NEAR_DEG && dip_deg * expected_deg > 0.0 {
        Ok(false)
    } else if (dip_deg + expected_deg).abs() <= NEAR_DEG && dip_deg * expected_deg < 0.0 {
        Ok(true)
    } else {
        Err(Doubt::OtherDip { expected_deg })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_headings_that_are_right_the_other_way_are_backwards() {
        assert_eq!((of_headings(178.0, 2.0), of_headings(2.0, 178.0)), (Ok(true), Ok(false)));
        assert!(of_headings(104.0, 104.0).is_err());
    }

    #[test]
    fn a_dip_is_that_of_the_place_or_its_opposite_or_neither() {
        assert_eq!((of_dips(58.0, 65.0), of_dips(-58.0, 65.0)), (Ok(false), Ok(true)));
        assert_eq!((of_dips(58.0, -65.0), of_dips(-58.0, -65.0)), (Ok(true), Ok(false)));
        assert!(matches!(of_dips(20.0, 65.0), Err(Doubt::OtherDip { .. })));
        assert!(matches!(of_dips(20.0, 3.0), Err(Doubt::LevelField { .. })));
        assert!(matches!(of_dips(10.0, -9.0), Ok(true)));
    }
}
