//! What an earlier calibration knows, for a fit or a study on top of it.

use crate::cal_file::CalFile;
use crate::cli::LogArgs;
use crate::failure::{Failure, Outcome};
use crate::input::Log;
use crate::plausible::Known;
use crate::reading::Reading;
use crate::registry::REGISTRY;
use crate::{refusal, source};
use ironout::effect::{Effect, Parts};
use ironout_analysis::base::axes::triangle_of;
use ironout_analysis::base::earlier::EarlierCalibration;
use ironout_analysis::outcome::request::Purpose;
use ironout_analysis::{Options, Table, effects, fit};
use nalgebra::{Matrix3, Vector3};
use std::path::Path;

/// Reads a calibration file as information for this log. The offsets of its effects are carried over to the log's own
/// mean of their columns, which is where a new fit puts their reference; of all other columns the reference is where they were when
/// the calibration was fitted. `arguments` are those that the log was read with.
///
/// # Errors
/// A file that is not a calibration, is of another scale or mounting, holds no information, or carries effects that this log cannot be related to.
pub fn read(path: &Path, log: &Log, arguments: &LogArgs) -> Outcome<EarlierCalibration> {
    of_file(&CalFile::read(path)?, path, log, arguments)
}

/// The name that stands for the calibration of the autopilot that recorded the log.
const PARAMETERS: &str = "parameters";
/// An autopilot's calibration is right to this share of the field (compasses are calibrated away from the motors and loads of a
/// flight: 5 to 10 µT), and to this in gains and axes.
const AUTOPILOT_OFFSET: f64 = 0.15;
const AUTOPILOT_GAIN: f64 = 0.05;

/// Fits another log, named in `from`, as this one is fitted, or takes the autopilot's own calibration out of this log, as information.
///
/// # Errors
/// Those of reading and of fitting; a log whose fit is refused; an autopilot that had no calibration.
pub fn from(
    from: &Path,
    log: &Log,
    arguments: &LogArgs,
    options: &Options,
    json: bool,
) -> Outcome<EarlierCalibration> {
    if from == Path::new(PARAMETERS) {
        return of_autopilot(log);
    }
    let (other, used) =
        source::read_held(&arguments.alone(from), None, &Known::given(options.field_ut), json)?;
    let options = Options { prior: None, purpose: Purpose::AsShown, ..options.clone() };
    let fitted = fit(&Table::from(&other), &options).map_err(|refused| refusal::failure(refused, from))?;
    if !fitted.accepted {
        let why = fitted.reasons.first().map(ToString::to_string).unwrap_or_default();
        return Err(Failure::usage(format!(
            "its own fit is refused, so it cannot be used as a prior: {why}"
        ))
        .in_file(from));
    }
    let mut file = CalFile::of(&fitted, options.method.name());
    file.reading = Some(Reading::of(&other, &used, &file.read_columns())?);
    of_file(&file, from, log, arguments)
}

/// The calibration that the autopilot had when it recorded the log, as the reader took it out.
fn of_autopilot(log: &Log) -> Outcome<EarlierCalibration> {
    let none = || {
        Failure::usage(
            "--prior-from parameters: this log contains no compass calibration of an autopilot. Fix: give --prior CAL.json or --prior-from LOG",
        )
    };
    let removed = log.frame.removed.last().ok_or_else(none)?;
    let [turn, matrix] =
        [&log.frame.from_source, &removed.matrix].map(|rows| Matrix3::from_fn(|i, j| rows[i][j]));
    let unit = Matrix3::from_diagonal(&log.frame.ut_per_number.into());
    let offset = turn * unit * Vector3::from(removed.offset);
    let back = (turn * unit).try_inverse().ok_or_else(none)?;
    let matrix = turn * unit * matrix * back;
    let rows: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    if offset.norm() == 0.0 {
        return Err(none());
    }
    let n = log.rows.max(1) as f64;
    let field_ut =
        (0..log.rows).map(|row| (matrix * (Vector3::from(log.field(row)) - offset)).norm()).sum::<f64>() / n;
    let spread = |i: usize| if i < 3 { AUTOPILOT_OFFSET * field_ut } else { AUTOPILOT_GAIN };
    Ok(EarlierCalibration {
        offset_ut: offset.into(),
        triangle: triangle_of(&rows).ok_or_else(none)?,
        information: std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { spread(i).powi(-2) } else { 0.0 })
        }),
        field_ut,
        conditions: Default::default(),
    })
}

/// A calibration file as information for this log.
fn of_file(file: &CalFile, path: &Path, log: &Log, arguments: &LogArgs) -> Outcome<EarlierCalibration> {
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
    Ok(EarlierCalibration {
        offset_ut,
        triangle,
        information: std::array::from_fn(|i| std::array::from_fn(|j| known.matrix[i][j])),
        field_ut: calibration.field_ut,
        conditions,
    })
}
