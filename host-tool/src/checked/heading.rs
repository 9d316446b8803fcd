//! The heading that a calibration gives, against the log's reference.

use crate::corrected::Corrected;
use crate::failure::Outcome;
use crate::output::json_number;
use ironout_analysis::Table;
use ironout_analysis::base::heading::{HeadingError, difference_deg, heading_deg};
use ironout_analysis::samples::samples::Samples;

/// A heading is wrong where its error is more than this, degrees rms, ...
const WRONG_DEG: f64 = 5.0;
/// ... and more than this many times what the calibration predicts.
const TIMES: f64 = 3.0;
/// A mean error beyond this is a heading that goes backwards, degrees, ...
const BACKWARDS_DEG: f64 = 150.0;
/// ... where the errors lie together, degrees rms about it.
const SCATTERED_DEG: f64 = 45.0;

/// What the log's `heading_deg` says.
pub enum Headings {
    /// There is none.
    Absent,
    /// There is one, and nothing to level it with: why.
    Unlevelled(&'static str),
    /// The errors.
    Judged(Judged),
}

/// Errors of the heading, and how large they may be.
pub struct Judged {
    pub(crate) error: HeadingError,
    pub(crate) limit_deg: f64,
}

/// Compares headings where the accelerometer measures little besides gravity. `declination_deg` is added to the magnetic
/// heading.
pub(crate) fn headings(
    table: &Table,
    corrector: &Corrected,
    predicted_deg: Option<f64>,
    declination_deg: Option<f64>,
) -> Outcome<Headings> {
    let Some(reference) = table.heading_deg else { return Ok(Headings::Absent) };
    if table.accel_mps2.is_none() {
        return Ok(Headings::Unlevelled(
            "heading_deg is not compared: the log has no accelerometer (ax_mps2,ay_mps2,az_mps2)",
        ));
    }
    let samples = Samples::take(table, &vec![false; table.rows()], [true; 3]);
    let mut differences = Vec::new();
    for (&row, reading) in samples.row.iter().zip(&samples.readings) {
        let (Some(down), Some(truth)) = (reading.down, reference.get(row)) else { continue };
        if !truth.is_finite() {
            continue;
        }
        let heading = heading_deg(corrector.field(row)?, down);
        let magnetic = truth - declination_deg.unwrap_or(0.0);
        differences.extend(heading.map(|heading| difference_deg(heading, magnetic)));
    }
    Ok(match HeadingError::of(&differences) {
        Some(error) => {
            let limit_deg = predicted_deg.map_or(WRONG_DEG, |predicted| WRONG_DEG.max(TIMES * predicted));
            Headings::Judged(Judged { error, limit_deg })
        }
        None => Headings::Unlevelled(
            "heading_deg is not compared: too few rows with a heading and a level sensor",
        ),
    })
}

impl Judged {
    /// Whether the heading is wrong.
    pub(crate) fn is_wrong(&self) -> bool {
        self.error.rms_deg > self.limit_deg
    }

    /// What a wrong heading is, and what to do.
    fn words(&self, declination_given: bool) -> String {
        let HeadingError { rms_deg, mean_deg, spread_deg, .. } = self.error;
        if mean_deg.abs() > BACKWARDS_DEG && spread_deg < SCATTERED_DEG {
            format!(
                "every heading is reversed ({mean_deg:+.0}°): an axis is mirrored, or the sensor is mounted backwards. Run \
                 ironout diagnose to find out"
            )
        } else if spread_deg > self.limit_deg || spread_deg > mean_deg.abs() {
            format!(
                "headings are wrong by {rms_deg:.0}° rms, in both directions. Run ironout diagnose to find the cause"
            )
        } else {
            let else_where = if declination_given {
                "check the mounting (--rotate), and the declination that was given"
            } else {
                "the declination, if heading_deg counts from true north (then give --declination), else the mounting \
                 (--rotate)"
            };
            format!("every heading is wrong by {mean_deg:+.1}°: {else_where}")
        }
    }
}

impl Headings {
    /// What to know about the heading, a line each.
    pub(crate) fn words(&self, declination_given: bool) -> Vec<String> {
        match self {
            Headings::Absent => Vec::new(),
            Headings::Unlevelled(why) => vec![(*why).to_string()],
            Headings::Judged(one) if one.is_wrong() => vec![one.words(declination_given)],
            Headings::Judged(_) => Vec::new(),
        }
    }

    /// The figures; null where there are none.
    pub(crate) fn json(&self) -> serde_json::Value {
        match self {
            Headings::Judged(Judged { error, limit_deg }) => serde_json::json!({
                "samples": error.count, "rms_deg": json_number(Some(error.rms_deg)),
                "mean_deg": json_number(Some(error.mean_deg)), "spread_deg": json_number(Some(error.spread_deg)),
                "limit_deg": limit_deg,
            }),
            _ => serde_json::Value::Null,
        }
    }
}
