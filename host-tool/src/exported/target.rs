//! The parameters of other programs.

use crate::cal_file::CalFile;
use crate::cli::{ExportArgs, ExportForm, scale};
use crate::failure::{Failure, Outcome};
use crate::input::Log;
use ironout_analysis::Table;
use ironout_analysis::export::error::CannotExport;
use ironout_analysis::export::held::{Held, Room, Turns};
use ironout_analysis::export::refit::{Cost, NoCost, refit};
use ironout_analysis::export::words::About;
use ironout_analysis::export::{ardupilot, betaflight, iio, px4, ros};
use ironout_analysis::frame::Frame;

/// A file, and what its target holds of the calibration.
pub struct Exported {
    /// The file.
    pub text: String,
    /// What the target holds; `None` where it holds all.
    pub held: Option<Held>,
    /// What it costs that it does not hold all; `None` without a log.
    pub cost: Option<Cost>,
}

/// The file of a target.
pub(super) fn export(
    cal: &CalFile,
    arguments: &ExportArgs,
    log: Option<&Log>,
    frame: &Frame,
    summary: &str,
) -> Outcome<Exported> {
    let room = match arguments.form {
        ExportForm::Px4 => px4::ROOM,
        ExportForm::Ardupilot => ardupilot::ROOM,
        ExportForm::Betaflight => betaflight::ROOM,
        ExportForm::Iio => iio::ROOM,
        _ => ros::ROOM,
    };
    let room = if arguments.euler { Room { turns: Turns::Any, ..room } } else { room };
    let refuse = |error: CannotExport| match error {
        CannotExport::NoNumber { .. } | CannotExport::NoCounts(_) => Failure::usage(error.to_string()),
        CannotExport::Singular => Failure::not_a_calibration(&error.to_string()).at_column("matrix"),
        other => Failure::usage(other.to_string()),
    };
    let calibration = cal.extended()?;
    let mut held = Held::of(&calibration, frame, room).map_err(refuse)?;
    let mut cost = None;
    if let Some(log) = log {
        let (fitted, found) =
            refit(&held, &calibration, &Table::from(log)).map_err(|error| match &error {
                NoCost::Column(column, why) => {
                    Failure::usage(why.clone()).in_file(&log.path).at_column(column.clone())
                }
                _ => Failure::usage(format!("--log: {error}")).in_file(&log.path),
            })?;
        (held, cost) = (fitted, Some(found));
    }
    let counts = match &arguments.ut_per_count {
        Some(text) => Some(scale(text)?),
        None => cal.reading.as_ref().and_then(|reading| reading.ut_per_count),
    };
    let about = About { summary, cost: cost.as_ref() };
    let (number, id) = (arguments.number, arguments.device_id);
    let text = match arguments.form {
        ExportForm::Px4 => px4::text(&held, number, id, about),
        ExportForm::Ardupilot => ardupilot::text(&held, number, id, about),
        ExportForm::Betaflight => betaflight::text(&held, number, counts, about),
        ExportForm::Iio => iio::text(&held, number, counts, about),
        _ => Ok(ros::text(&held, about)),
    };
    Ok(Exported { text: text.map_err(refuse)?, held: Some(held), cost })
}
