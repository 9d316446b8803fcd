//! The ranges of columns that a calibration was fitted over, for the exports.

use crate::effects::Calibrated;
use ironout::effect::{Effect, Past};

/// The range of one column, or of the past of it that acts.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    /// The column.
    pub column: String,
    /// Which past of it acts.
    pub past: Past<f64>,
    /// Its least and its greatest value; where several effects follow it, those that lie in all of their ranges.
    pub ends: [f64; 2],
}

/// The ranges that the effects of a calibration say.
pub fn ranges(calibration: &Calibrated) -> Vec<Range> {
    let mut list: Vec<Range> = Vec::new();
    for fitted in calibration.effects.iter() {
        for (column, ends) in fitted.effect.columns().into_iter().zip(fitted.ranges) {
            let Some((column, ends)) = column.zip(ends) else { continue };
            let same = |known: &&mut Range| known.column == column.name && known.past == column.past;
            match list.iter_mut().find(same) {
                Some(known) => known.ends = [known.ends[0].max(ends[0]), known.ends[1].min(ends[1])],
                None => {
                    list.push(Range { column: column.name.to_string(), past: column.past, ends });
                }
            }
        }
    }
    list
}
