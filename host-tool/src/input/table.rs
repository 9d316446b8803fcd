//! A log as the analysis sees it.

use crate::input::log::Log;
use ironout_analysis::track::Track;
use ironout_analysis::{Named, Table};

/// Where the board was is no cause of what it reads beyond the field of that place.
const WHERE: [&str; 2] = ["lat_deg", "lon_deg"];

impl<'a> From<&'a Log> for Table<'a> {
    fn from(log: &'a Log) -> Self {
        let triple = |axes: &'a [Vec<f64>; 3]| axes.each_ref().map(Vec::as_slice);
        let track = log.earth.as_ref().and_then(|[field_ut, dip_deg]| Track::of(field_ut, dip_deg));
        let travels = track.is_some();
        Table {
            time_s: log.time_s.as_deref(),
            field_ut: triple(&log.field_ut),
            counts: log.counts.as_deref().zip(log.ut_per_count),
            accel_mps2: log.accel_mps2.as_ref().map(triple),
            gyro_radps: log.gyro_radps.as_ref().map(triple),
            heading_deg: log.heading_deg.as_deref(),
            track,
            recordings: log.recordings.clone(),
            axes_in_doubt: log.read_as.axes_in_doubt,
            covariates: log
                .covariates
                .iter()
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
