//! `--at LAT,LON,DATE`: the expected field from the world magnetic model.

use crate::failure::{Failure, Outcome};
use world_magnetic_model::GeomagneticField;
use world_magnetic_model::time::{Date, Month};
use world_magnetic_model::uom::si::angle::degree;
use world_magnetic_model::uom::si::f32::{Angle, Length};
use world_magnetic_model::uom::si::length::meter;
use world_magnetic_model::uom::si::magnetic_flux_density::nanotesla;

/// The field of the Earth at a place and a day (World Magnetic Model, at the ellipsoid's height).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EarthField {
    /// Magnitude F, µT.
    pub field_ut: f64,
    /// Inclination, degrees, positive down.
    pub dip_deg: f64,
    /// Declination, degrees, positive east.
    pub declination_deg: f64,
}

/// The years the bundled models cover.
const YEARS: &str = "2020-01-01 to 2029-12-31";

impl EarthField {
    /// Reads `LAT,LON,YYYY-MM-DD`.
    pub fn parse(text: &str) -> Outcome<Self> {
        let expected = || {
            format!(
                "--at {text}: expected LAT,LON,DATE in degrees and YYYY-MM-DD, as in --at 52.52,13.40,2026-03-01"
            )
        };
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let [latitude, longitude, date] = parts.as_slice() else { return Err(Failure::usage(expected())) };
        let number = |part: &str| part.parse::<f64>().ok().filter(|value| value.is_finite());
        let (Some(latitude), Some(longitude), Some(date)) = (number(latitude), number(longitude), day(date))
        else {
            return Err(Failure::usage(expected()));
        };
        if !(-90.0..=90.0).contains(&latitude) {
            return Err(Failure::usage(format!(
                "--at {text}: the latitude {latitude} is not between -90 and 90 degrees"
            )));
        }
        if !(-180.0..=360.0).contains(&longitude) {
            return Err(Failure::usage(format!(
                "--at {text}: the longitude {longitude} is not between -180 and 360 degrees"
            )));
        }
        let longitude = if longitude > 180.0 { longitude - 360.0 } else { longitude };
        let field = GeomagneticField::new(
            Length::new::<meter>(0.0),
            Angle::new::<degree>(latitude as f32),
            Angle::new::<degree>(longitude as f32),
            date,
        )
        .map_err(|error| {
            Failure::usage(format!(
                "--at {text}: the world magnetic model does not answer ({error:?}); it covers {YEARS}"
            ))
        })?;
        Ok(EarthField {
            field_ut: f64::from(field.f().get::<nanotesla>()) / 1000.0,
            dip_deg: f64::from(field.inclination().get::<degree>()),
            declination_deg: f64::from(field.declination().get::<degree>()),
        })
    }
}

fn day(text: &str) -> Option<Date> {
    let mut parts = text.split('-');
    let year: i32 = parts.next()?.parse().ok()?;
    let month: u8 = parts.next()?.parse().ok()?;
    let day: u8 = parts.next()?.parse().ok()?;
    if parts.next().is_some() {
        return None;
    }
    Date::from_calendar_date(year, Month::try_from(month).ok()?, day).ok()
}

#[cfg(test)]
mod tests {
    use super::EarthField;

    #[test]
    fn berlin_and_the_published_test_values() {
        // WMM2025 test values (NOAA), 2025.0, height 0 km, 80 N 0 E: F 55178.5 nT, I 83.21, D 1.28 degrees.
        let north = EarthField::parse("80,0,2025-01-01").expect("valid");
        assert!((north.field_ut - 55.1785).abs() < 0.01, "{north:?}");
        assert!((north.dip_deg - 83.21).abs() < 0.02, "{north:?}");
        assert!((north.declination_deg - 1.28).abs() < 0.02, "{north:?}");
        let berlin = EarthField::parse("52.52, 13.40, 2026-03-01").expect("valid");
        assert!((49.0..51.5).contains(&berlin.field_ut), "{berlin:?}");
    }

    #[test]
    fn what_is_no_place_or_day_is_refused_with_the_form() {
        for text in [
            "",
            "52,13",
            "x,13,2026-01-01",
            "91,0,2026-01-01",
            "0,400,2026-01-01",
            "0,0,2026-13-01",
            "0,0,1900-01-01",
        ] {
            let failure = EarthField::parse(text).expect_err(text);
            assert!(failure.message.starts_with("--at"), "{failure}");
        }
    }
}
