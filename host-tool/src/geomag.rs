//! `--at LAT,LON,DATE`: the expected field from the world magnetic model.

use crate::failure::{Failure, Outcome};
use world_magnetic_model::GeomagneticField;
use world_magnetic_model::time::{Date, Month, OffsetDateTime};
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
pub const YEARS: &str = "2020-01-01 to 2029-12-31";

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
        Self::over(latitude, longitude, 0.0, date).map_err(|error| {
            Failure::usage(format!(
                "--at {text}: the world magnetic model does not answer ({error}); it covers {YEARS}"
            ))
        })
    }

    /// At a place, degrees north and east, so many metres above the ellipsoid.
    ///
    /// # Errors
    /// Why the model does not answer: a place or a day that it does not cover.
    pub fn over(latitude_deg: f64, longitude_deg: f64, height_m: f64, on: Day) -> Result<Self, String> {
        let longitude_deg = match longitude_deg {
            east if east > 180.0 => east - 360.0,
            west if west < -180.0 => west + 360.0,
            own => own,
        };
        let field = GeomagneticField::new(
            Length::new::<meter>(height_m as f32),
            Angle::new::<degree>(latitude_deg as f32),
            Angle::new::<degree>(longitude_deg as f32),
            on,
        )
        // Its other words are those of a program: the place or the day is outside.
        .map_err(|error| {
            let words = format!("{error:?}");
            let day = words.starts_with("Date");
            format!("{} is outside", if day { "the day" } else { "the place" })
        })?;
        Ok(EarthField {
            field_ut: f64::from(field.f().get::<nanotesla>()) / 1000.0,
            dip_deg: f64::from(field.inclination().get::<degree>()),
            declination_deg: f64::from(field.declination().get::<degree>()),
        })
    }
}

/// A day of the model.
pub type Day = Date;

/// The day of a time in seconds since 1970, where it is one that the model covers and no time since a start.
pub fn day_of_epoch(time_s: f64) -> Option<Day> {
    let covered = (1_577_836_800.0..1_893_456_000.0).contains(&time_s);
    covered.then(|| OffsetDateTime::from_unix_timestamp(time_s as i64).ok())?.map(OffsetDateTime::date)
}

/// `YYYY-MM-DD`.
pub fn day(text: &str) -> Option<Day> {
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
    fn a_place_has_its_field_and_a_clock_its_day() {
        let day = super::day("2026-01-01").expect("a day");
        // By another implementation of WMM2025 (pygeomag 1.1): 2026.0, 100 km, 0 N 120 E: F 39022.1 nT, I -14.969 degrees.
        let high = EarthField::over(0.0, 120.0, 100_000.0, day).expect("covered");
        assert!((high.field_ut - 39.0221).abs() < 0.01 && (high.dip_deg + 14.969).abs() < 0.02, "{high:?}");
        assert_eq!(EarthField::over(0.0, -240.0, 100_000.0, day), Ok(high));
        assert!(EarthField::over(95.0, 0.0, 0.0, day).is_err());
        assert_eq!(super::day_of_epoch(1_767_225_600.5), Some(day));
        assert_eq!(super::day_of_epoch(86.4), None);
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
