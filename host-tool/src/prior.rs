//! What an earlier calibration knows, for a fit or a study on top of it.

use crate::cal_file::CalFile;
use crate::cli::LogArgs;
use crate::failure::{Failure, Outcome};

use crate::input::Log;
use ironout_analysis::base::axes::triangle_of;
use ironout_analysis::base::prior::Prior;
use ironout_analysis::effects;

use crate::registry::REGISTRY;
use ironout::effect::{Effect, Parts};
use std::path::Path;

/// Reads a calibration file as information for this log. The offsets of its effects are carried over to the log's own
/// mean of their columns, which is where a new fit puts their reference; of all other columns the reference is where they were when
/// the calibration was fitted. `arguments` are those that the log was read with.
///
/// # Errors
/// A file that is no calibration, is of another scale or mounting, holds no information, or carries effects that this log cannot be related to.
pub fn read(path: &Path, log: &Log, arguments: &LogArgs) -> Outcome<Prior> {
    let file = CalFile::read(path)?;
    if let Some(reading) = &file.reading {
        reading.must_fit(path, log, arguments)?;
    }
    let calibration = file.calibration()?;
    let missing = |what: &str| {
        Failure::usage(format!("this calibration has no {what}: fit it again with this program"))
            .in_file(path)
    };
    let triangle = triangle_of(&calibration.matrix).ok_or_else(|| missing("invertible matrix"))?;
    let known = file.information.as_ref().ok_or_else(|| missing("information"))?;
    let rows = known.matrix.iter().take(9).filter(|row| row.len() >= 9);
    if rows.count() < 9 {
        return Err(missing("information about nine parameters"));
    }
    let mut offset_ut = calibration.offset_ut;
    let mut conditions = file.conditions.clone();
    for entry in &file.fit.effects {
        let cannot = |why: String| {
            Failure::usage(format!("its effect {} cannot be used with this log: {why}", entry.id))
                .in_file(path)
        };
        let fitted = effects::from_entry(entry, REGISTRY).map_err(cannot)?;
        let Parts { column, reference, .. } = *fitted.effect.parts();
        if !fitted.effect.family().is_proportional(&fitted.effect.parts().borrowed()) {
            return Err(cannot(format!(
                "only offsets proportional to a column can be ({})",
                fitted.effect.name()
            )));
        }
        let values = log.covariate(column.as_str()).map(|covariate| &covariate.values);
        let values: Vec<f64> =
            values.into_iter().flatten().copied().filter(|value| value.is_finite()).collect();
        if values.is_empty() {
            return Err(cannot(format!("the log has no column {column}")));
        }
        conditions.remove(column.as_str());
        let change = values.iter().sum::<f64>() / values.len() as f64 - reference;
        for (offset, coefficient) in offset_ut.iter_mut().zip(fitted.coefficients) {
            *offset += coefficient * change;
        }
    }
    Ok(Prior {
        offset_ut,
        triangle,
        information: std::array::from_fn(|i| std::array::from_fn(|j| known.matrix[i][j])),
        field_ut: calibration.field_ut,
        conditions,
    })
}
