//! A log as the analysis sees it.

use crate::input::log::Log;
use ironout_analysis::table::{ATTITUDE, Earth, OTHER};
use ironout_analysis::track::Track;
use ironout_analysis::{Named, Table};

/// Where a GPS receiver says that the vehicle went is no cause either.
const WENT: [&str; 4] = ["gps_course_deg", "gps_speed_error_mps", "course_deg", "speed_accuracy_mps"];
/// Where the board was is not a cause of what it reads beyond the field of that place.
const WHERE: [&str; 2] = ["lat_deg", "lon_deg"];

impl<'a> From<&'a Log> for Table<'a> {
    fn from(log: &'a Log) -> Self {
        let triple = |axes: &'a [Vec<f64>; 3]| axes.each_ref().map(Vec::as_slice);
        let track = log.earth.as_ref().and_then(|[field_ut, dip_deg]| Track::of(field_ut, dip_deg));
        let travels = track.is_some();
        let attitude = match ATTITUDE.map(|name| log.covariate(name)) {
            [Some(w), Some(x), Some(y), Some(z)] => Some([w, x, y, z].map(|column| column.values.as_slice())),
            _ => None,
        };
        let other_ut = match OTHER.map(|name| log.covariate(name)) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z].map(|column| column.values.as_slice())),
            _ => None,
        };
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let earth =
            log.earth.as_ref().zip(log.declination_deg).map(|([field_ut, dip_deg], declination_deg)| Earth {
                field_ut: mean(field_ut),
                dip_deg: mean(dip_deg),
                declination_deg,
            });
        Table {
            time_s: log.time_s.as_deref(),
            field_ut: triple(&log.field_ut),
            other_ut,
            counts: log.counts.as_deref().zip(log.ut_per_count),
            accel_mps2: log.accel_mps2.as_ref().map(triple),
            gyro_radps: log.gyro_radps.as_ref().map(triple),
            heading_deg: log.heading_deg.as_deref(),
            attitude,
            earth,
            track,
            recordings: log.recordings.clone(),
            axes_in_doubt: log.read_as.axes_in_doubt,
            covariates: log
                .covariates
                .iter()
                .filter(|column| attitude.is_none() || !ATTITUDE.contains(&column.name.as_str()))
                .filter(|column| other_ut.is_none() || !OTHER.contains(&column.name.as_str()))
                .filter(|column| !WENT.contains(&column.name.as_str()))
                .filter(|column| !(travels && WHERE.contains(&column.name.as_str())))
                .map(|column| Named {
                    name: &column.name,
                    values: &column.values,
                    not_finite: column.not_finite,
                })
                .collect(),
            derived: Default::default(),
        }
    }
}
