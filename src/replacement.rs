//! Whether an accepted calibration may take the place of the one in use.
//!
//! Both passed their verdict, so both are right within the errors that they predict. One from half a minute of turning may
//! all the same be several times worse than the one it replaces. It is refused then, unless the samples behind it say that the
//! old one is no longer right: a magnet that was added makes an old calibration wrong, however small its error was.

use crate::calibration::Calibration;
use crate::calibration::norm;
use crate::number::Num;
use crate::record::Record;
use core::fmt;

/// A calibration is clearly worse where its predicted error is this many times that of the one in use …
const CLEARLY: f64 = 2.0;
/// … and more than this share of the field: below it, who turned how long makes no difference to a heading (0.15° at a dip of
/// 60°, where the level field is half of it).
const MATTERS: f64 = 0.00125;
/// Two calibrations agree where they differ by no more than this many of their predicted errors, taken together.
const AGREE_SIGMA: f64 = 3.0;

/// The new calibration is worse than the one in use, which is still right.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Worse {
    /// Predicted error of the new one, percent of the field.
    pub new_percent: f64,
    /// Of the one in use.
    pub in_use_percent: f64,
}

impl Worse {
    /// A short word for programs.
    pub const CODE: &'static str = "worse-than-in-use";
}

impl fmt::Display for Worse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "its predicted error is {:.2} % of the field, that of the calibration in use {:.2} %, and the two agree: keep \
             the \
             old one, rotate through more directions, or use: cal accept force",
            Num(self.new_percent),
            Num(self.in_use_percent)
        )
    }
}

impl core::error::Error for Worse {}

/// Compares a calibration with the one in use. `Some` where the new one is clearly worse; `None` where it may take its place, and
/// where an error is not known, the new one is for level headings, or the sensor was mounted otherwise, so that nothing can be said.
pub fn clearly_worse(new: &Record, in_use: &Record) -> Option<Worse> {
    let (new_share, share) = (new.predicted_error.share()?, in_use.predicted_error.share()?);
    let mounted = |record: &Record| record.axes;
    if mounted(new).is_some() && mounted(in_use).is_some() && mounted(new) != mounted(in_use) {
        return None;
    }
    if new.holds_for.is_some() {
        return None;
    }
    if new_share < MATTERS || new_share < CLEARLY * share {
        return None;
    }
    let both = crate::math::sqrt(new_share * new_share + share * share);
    let differ = difference(&new.calibration, &in_use.calibration)?;
    (differ <= AGREE_SIGMA * both)
        .then_some(Worse { new_percent: 100.0 * new_share, in_use_percent: 100.0 * share })
}

/// By how much the magnitudes of two calibrations differ at most over the sphere, as a share of the field: each is scaled to
/// its own field, and a rotation between them (one was aligned to an accelerometer) makes no difference.
fn difference(new: &Calibration<f64>, in_use: &Calibration<f64>) -> Option<f64> {
    let mut most = 0.0_f64;
    for side in 0..27 {
        // The sides, edges and corners of a cube, from its middle.
        let [x, y, z] = [side % 3, side / 3 % 3, side / 9].map(|step| f64::from(step) - 1.0);
        let length = norm([x, y, z]);
        if length > 0.0 {
            let point = [x, y, z].map(|axis| axis / length * in_use.field_ut);
            let corrected = new.apply(in_use.distort(point)?);
            most = most.max((norm(corrected) / new.field_ut - 1.0).abs());
        }
    }
    most.is_finite().then_some(most)
}

#[cfg(test)]
mod tests {
    use super::{Worse, clearly_worse};
    use crate::calibration::Calibration;
    use crate::extended::Effects;
    use crate::fit::{Method, Order};
    use crate::record::{PredictedError, Record};

    fn record(offset_ut: [f64; 3], field_ut: f64, share: f64) -> Record {
        Record {
            sequence: 1,
            calibration: Calibration { offset_ut, ..Calibration::identity(field_ut) },
            effects: Effects::none(),
            method: Method::Adjusted,
            model: Order::Ellipsoid,
            samples: 500,
            noise_ut: 0.2,
            rms_ut: 0.2,
            axes: None,
            predicted_error: PredictedError::of_share(share),
            covariance: None,
            holds_for: None,
        }
    }

    #[test]
    fn a_calibration_with_thrice_the_error_does_not_replace_one_that_it_agrees_with() {
        let in_use = record([10.0, 0.0, 0.0], 50.0, 0.001);
        let worse = clearly_worse(&record([10.3, 0.1, 0.0], 50.0, 0.005), &in_use);
        let Some(Worse { new_percent, in_use_percent }) = worse else { panic!("it was let through") };
        assert!((new_percent - 0.5).abs() < 0.05 && (in_use_percent - 0.1).abs() < 0.01);
        // A better one, one as good, and one whose error matters to nobody do.
        for share in [0.0005, 0.0011, 0.0018] {
            assert_eq!(clearly_worse(&record([10.0, 0.0, 0.0], 50.0, share), &in_use), None);
        }
    }

    #[test]
    fn what_moved_is_replaced_however_well_it_was_known() {
        let in_use = record([10.0, 0.0, 0.0], 50.0, 0.0005);
        assert_eq!(clearly_worse(&record([14.0, 0.0, 0.0], 50.0, 0.008), &in_use), None);
        // The same sensor in another field, or scaled to another: only the scale differs.
        let scaled =
            Calibration { matrix: [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]], ..in_use.calibration };
        let elsewhere = Record {
            calibration: Calibration { field_ut: 25.0, ..scaled },
            ..record([10.0, 0.0, 0.0], 25.0, 0.008)
        };
        assert!(clearly_worse(&elsewhere, &in_use).is_some());
    }

    #[test]
    fn without_errors_nothing_is_said() {
        let unknown = record([0.0; 3], 50.0, f64::NAN);
        let known = record([0.0; 3], 50.0, 0.009);
        assert_eq!(clearly_worse(&known, &unknown), None);
        assert_eq!(clearly_worse(&unknown, &known), None);
    }
}
