//! Several recordings whose offsets differ: one matrix, an offset for each.
//!
//! The board was mounted again, a battery was exchanged, a day has passed. Where the offsets differ beyond what noise does, the
//! readings are moved to the last recording's offset, and all else is of these.

use crate::base::ground::Ground;
use crate::base::start;
use crate::outcome::request::{Options, Refusal};
use crate::table::Table;
use crate::unlogged::recordings::{Recordings, offsets};
use ironout::calibration::Calibration;

/// Largest p-value at which offsets are reported to differ: one file of a thousand.
const SIGNIFICANT: f64 = 1e-3;
/// The error that offsets of their own must leave at most, as a share of that with one for all: a difference that is certain and
/// hardly changes a correction is left alone.
const WORTH_SAYING: f64 = 0.98;

/// What `then` makes of a log; where the offsets of its recordings differ, of its readings with the offset of the last, and the
/// offsets next to it.
pub(crate) fn of_one_offset<T>(
    table: &Table,
    options: &Options,
    then: impl FnOnce(Ground) -> Result<T, Refusal>,
) -> Result<(T, Option<Recordings>), Refusal> {
    let lay = |table| Ground::of(table, options.method, options.scale_ut(), options.dip_deg);
    let ground = lay(table);
    let Some(found) = apart(&ground) else { return Ok((then(ground)?, None)) };
    let readings = moved(table, &found);
    let one = with_readings(table, &readings);
    Ok((then(lay(&one))?, Some(found)))
}

/// The offsets of the recordings, where they differ.
fn apart(ground: &Ground) -> Option<Recordings> {
    let counted = &ground.counted;
    let table = counted.table;
    if table.recordings.is_empty() || counted.rests {
        return None;
    }
    // What stands out of one offset for all may be another offset.
    let samples = counted.with_bursts.as_ref().unwrap_or(&counted.samples);
    let calibration = match &ground.base {
        Ok(base) => base.solution.calibration,
        Err(_) => {
            let (model, _) = start::start(samples, None)?;
            Calibration { offset_ut: model.offset_ut, matrix: model.matrix, field_ut: model.field_ut }
        }
    };
    let mut corrected = vec![Vec::new(); table.recordings.len() + 1];
    for row in &samples.row {
        let own = calibration.apply(table.field(*row));
        corrected[recording_of(table, *row)].push(own);
    }
    let found = offsets(&corrected, &calibration.matrix, calibration.field_ut)?;
    (found.p_value < SIGNIFICANT && found.rms_ut < WORTH_SAYING * found.common_rms_ut).then_some(found)
}

/// The recording that a row is of.
fn recording_of(table: &Table, row: usize) -> usize {
    table.recordings.partition_point(|first| *first <= row)
}

/// The readings with the offset of the last recording that has one, µT.
fn moved(table: &Table, found: &Recordings) -> [Vec<f64>; 3] {
    let last = found.recordings.last().map_or([0.0; 3], |one| one.offset_change_ut);
    let change = |row: usize| {
        // A recording that carries no offset of its own keeps that of the one before it.
        let own = recording_of(table, row);
        let known = found.recordings.iter().rev().find(|one| one.index <= own).or(found.recordings.first());
        known.map_or([0.0; 3], |one| one.offset_change_ut)
    };
    let mut out = [const { Vec::new() }; 3];
    let mut now = (usize::MAX, [0.0; 3]);
    for row in 0..table.rows() {
        let own = recording_of(table, row);
        if now.0 != own {
            now = (own, change(row));
        }
        for (axis, (column, value)) in out.iter_mut().zip(table.field(row)).enumerate() {
            column.push(value - now.1[axis] + last[axis]);
        }
    }
    out
}

/// The table with these readings, as one recording.
fn with_readings<'a>(table: &Table<'a>, readings: &'a [Vec<f64>; 3]) -> Table<'a> {
    Table {
        field_ut: readings.each_ref().map(Vec::as_slice),
        counts: None,
        recordings: Vec::new(),
        derived: Default::default(),
        ..table.clone()
    }
}
