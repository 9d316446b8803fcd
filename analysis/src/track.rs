//! The field of the Earth along the way of a log.
//!
//! Who travels some hundred kilometres reads another magnitude and another dip at the end. That is not an error of the sensor: the base
//! model takes the field of each place instead of one field for all.

use ironout::study::{Model, Residual};

/// A field that changes by less than this along the way is one field, µT: a sensor's noise hides what 15 km make of it.
const LEAST_CHANGE_UT: f64 = 0.05;

/// The known field at every row of a log, against its mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    places: Vec<Place>,
    /// Mean magnitude along the way, µT.
    pub mean_ut: f64,
    /// The least and the greatest magnitude along the way, µT.
    pub range_ut: [f64; 2],
}

/// The field at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Its magnitude over the mean one.
    pub share: f64,
    /// Its dip less the mean one, rad; counted away from the horizon.
    pub steeper_rad: f64,
}

impl Place {
    /// Where there is no track.
    pub const MEAN: Place = Place { share: 1.0, steeper_rad: 0.0 };

    /// The model, which holds at the mean of the way, at this place.
    pub fn of(&self, model: &Model<f64>, residual: Residual) -> Model<f64> {
        let mut here = *model;
        here.field_ut = model.field_ut * self.share;
        if residual == Residual::Dip {
            here.sin_dip = (model.sin_dip.asin() + self.bend_rad(model.sin_dip)).sin();
        }
        here
    }

    /// By how much the dip is another one here, rad: with the sign that the dip has in the frame of a model, which may be a
    /// mirror image's.
    pub fn bend_rad(&self, sin_dip: f64) -> f64 {
        if sin_dip < 0.0 { -self.steeper_rad } else { self.steeper_rad }
    }
}

impl Track {
    /// Of the magnitude, µT, and the dip, degrees, at every row. `None` where the field is one along the way, where the lengths
    /// differ, or where something is not a field.
    pub fn of(field_ut: &[f64], dip_deg: &[f64]) -> Option<Track> {
        let sound = field_ut.iter().all(|field| field.is_finite() && *field > 0.0)
            && dip_deg.iter().all(|dip| dip.is_finite());
        if field_ut.is_empty() || field_ut.len() != dip_deg.len() || !sound {
            return None;
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (mean_ut, mean_dip) = (mean(field_ut), mean(dip_deg));
        let range_ut = field_ut.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], field| {
            [field.min(least), field.max(most)]
        });
        if range_ut[1] - range_ut[0] < LEAST_CHANGE_UT {
            return None;
        }
        let away = if mean_dip < 0.0 { -1.0 } else { 1.0 };
        let places = field_ut
            .iter()
            .zip(dip_deg)
            .map(|(field, dip)| Place {
                share: field / mean_ut,
                steeper_rad: away * (dip - mean_dip).to_radians(),
            })
            .collect();
        Some(Track { places, mean_ut, range_ut })
    }

    /// The place of a row.
    pub fn place(&self, row: usize) -> Place {
        self.places.get(row).copied().unwrap_or(Place::MEAN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_place_has_the_mean_field() {
        let track = Track::of(&[48.0, 49.0, 50.0], &[-60.0, -62.0, -64.0]).unwrap();
        assert_eq!((track.mean_ut, track.range_ut, track.place(1)), (49.0, [48.0, 50.0], Place::MEAN));
        assert!((track.place(2).share - 50.0 / 49.0).abs() < 1e-12);
        assert!((track.place(2).steeper_rad - 2.0_f64.to_radians()).abs() < 1e-12, "steeper, in the south");
        assert!((track.place(2).bend_rad(-0.9) + 2.0_f64.to_radians()).abs() < 1e-12);
    }

    #[test]
    fn one_field_is_no_track_and_what_is_no_field_neither() {
        assert_eq!(Track::of(&[48.0, 48.04], &[60.0, 60.0]), None);
        assert_eq!(Track::of(&[48.0, f64::NAN], &[60.0, 60.0]), None);
        assert_eq!(Track::of(&[48.0, 50.0], &[60.0]), None);
        assert_eq!(Track::of(&[], &[]), None);
    }
}
