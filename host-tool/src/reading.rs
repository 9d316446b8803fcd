//! How the log of a calibration was read: a calibration is one of a scale and of a mounting.

use crate::failure::{Failure, Outcome};
use crate::input::{Log, Mounting};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Scales that differ by less than this share are the same.
const SAME: f64 = 1e-9;

/// The options that decide what the numbers of a log mean.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Reading {
    /// Scale of a log in counts, µT a count for x, y, z; null for one in microtesla.
    pub ut_per_count: Option<[f64; 3]>,
    /// Each `--rotate`, in turn.
    pub rotate: Vec<String>,
}

impl Reading {
    /// Of a log that was read with these options.
    pub fn of(log: &Log, rotate: &[String]) -> Self {
        Reading { ut_per_count: log.ut_per_count, rotate: rotate.to_vec() }
    }

    /// Whether the numbers can be meant.
    ///
    /// # Errors
    /// A scale that is not positive, or a rotation that is none.
    pub fn check(&self) -> Outcome<()> {
        if self
            .ut_per_count
            .is_some_and(|scale| scale.iter().any(|value| !(value.is_finite() && *value > 0.0)))
        {
            return Err(Failure::not_a_calibration("ut_per_count is not positive").at_column("reading"));
        }
        Mounting::parse(&self.rotate)
            .map(|_| ())
            .map_err(|failure| Failure::not_a_calibration(&failure.message).at_column("reading"))
    }

    /// Whether a log was read as that of the calibration in `file` was.
    ///
    /// # Errors
    /// Another scale or another mounting of the magnetometer: its corrected vectors would be wrong.
    pub fn must_fit(&self, file: &Path, log: &Log, rotate: &[String]) -> Outcome<()> {
        let words = |scale: [f64; 3]| scale.map(|value| value.to_string()).join(",");
        if let (Some(own), Some(given)) = (self.ut_per_count, log.ut_per_count)
            && own.iter().zip(given).any(|(own, given)| (own - given).abs() > SAME * own)
        {
            return Err(Failure::usage(format!(
                "this calibration is of a log read with --ut-per-count {}, and {} is given: leave the option out, or fit again",
                words(own),
                words(given)
            ))
            .in_file(file)
            .at_column("reading"));
        }
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let turned = |rotate: &[String]| Ok(Mounting::parse(rotate)?.magnetometer.unwrap_or(identity));
        let (own, given) = (turned(&self.rotate)?, turned(rotate)?);
        if own.iter().flatten().zip(given.iter().flatten()).any(|(own, given)| (own - given).abs() > 1e-6) {
            let typed = |rotate: &[String]| match rotate {
                [] => "no --rotate".to_string(),
                all => all.iter().map(|form| format!("--rotate={form}")).collect::<Vec<_>>().join(" "),
            };
            return Err(Failure::usage(format!(
                "this calibration is of a log read with {}, and this one is read with {}: in another mounting it turns the \
                 field elsewhere; read the log in the same way, or fit again",
                typed(&self.rotate),
                typed(rotate)
            ))
            .in_file(file)
            .at_column("reading"));
        }
        Ok(())
    }
}
