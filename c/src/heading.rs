//! The heading.

use crate::error::IronoutError;
use crate::pointer;
use ironout::heading::{NoHeading, heading_deg};

/// Writes the heading of the board's front, degrees from 0 to 360 clockwise from north, tilt-compensated: from magnetic
/// north with a `declination_deg` of 0, from true north with the declination of the place (east positive). Axes are x
/// forward, y right, z down. `accel_mps2` is the specific force, m/s²: at rest level 0, 0, -9.8; while the board
/// accelerates, the heading is wrong.
///
/// IRONOUT_NOT_FINITE: a vector is zero or not finite. IRONOUT_STEEP, IRONOUT_VERTICAL_FIELD: no heading here. On an error
/// `heading` is left as it was.
/// cbindgen:ptrs-as-arrays=[[corrected_ut; 3], [accel_mps2; 3]]
#[unsafe(no_mangle)]
pub extern "C" fn ironout_heading(
    corrected_ut: *const f32,
    accel_mps2: *const f32,
    declination_deg: f32,
    heading: *mut f32,
) -> IronoutError {
    let written = pointer::vector(corrected_ut).and_then(|corrected_ut| {
        let force = pointer::vector(accel_mps2)?.map(f64::from);
        let found = heading_deg(corrected_ut.map(f64::from), force, f64::from(declination_deg));
        let found = found.map_err(|error| match error {
            NoHeading::NotMeasured => IronoutError::IRONOUT_NOT_FINITE,
            NoHeading::Steep => IronoutError::IRONOUT_STEEP,
            NoHeading::VerticalField => IronoutError::IRONOUT_VERTICAL_FIELD,
        })?;
        pointer::write(heading, found as f32)
    });
    IronoutError::of(written)
}
