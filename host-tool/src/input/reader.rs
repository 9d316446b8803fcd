//! From the bytes of this program's own CSV to a [`Log`]: one pass, strict, fast.

use crate::failure::{Failure, Outcome};
use crate::input::columns;
use crate::input::lines::{Cutter, Lines};
use crate::input::log::{Log, ReadOptions};
use crate::input::map::entry;
use crate::input::plan::Plan;
use crate::input::store::Store;
use crate::progress::Progress;
use std::io::Read;

/// The format, as it is said.
pub const FORMAT: &str = "CSV of this program";

/// Reads a log in the program's own format; `size_bytes` (0: unknown) only sizes buffers and the progress bar.
pub fn read_own(source: impl Read, size_bytes: u64, options: &ReadOptions) -> Outcome<Log> {
    if let Some(asked) = options.instance.filter(|asked| *asked > 0) {
        return Err(Failure::usage(format!(
            "--instance {asked}: the log has one magnetometer. Omit the option"
        )));
    }
    let mut lines = Lines::new(source);
    let mut cutter = Cutter::new();
    let Some(first) = lines.next_row()? else {
        return Err(Failure::usage(
            "the file is empty. Expected a header line such as t_s,mx_ut,my_ut,mz_ut and one row per sample",
        ));
    };
    let header_line = first.number;
    let rows_guess = (size_bytes / (first.text.len().max(16) as u64)).min(4_000_000) as usize;
    let cells = cutter.cut(first.text);
    let header: Vec<String> = (0..cells)
        .map(|i| String::from_utf8_lossy(cutter.cell(first.text, i).trim_ascii()).into_owned())
        .collect();
    let columns = columns::interpret(&header, &options.map, header_line)?;
    let plan = Plan::new(&columns, options, header_line)?;

    let mut stores: Vec<(Store, bool)> = columns
        .into_iter()
        .zip(header)
        .enumerate()
        .map(|(index, (column, header))| {
            (Store::new(column, header, rows_guess), plan.strict.contains(&index))
        })
        .collect();

    let mut progress = Progress::new("reading", size_bytes, options.progress);
    let mut rows = 0_usize;
    let mut last_time = f64::NEG_INFINITY;
    while let Some(row) = lines.next_row()? {
        let (text, line) = (row.text, row.number);
        let cells = cutter.cut(text);
        if cells != stores.len() {
            return Err(ragged(cells, stores.len(), line, !row.ended));
        }
        for (index, (store, strict)) in stores.iter_mut().enumerate() {
            store.push(cutter.cell(text, index), *strict, line)?;
        }
        if let Some((store, _)) = plan.time.and_then(|index| stores.get(index)) {
            let time = store.values.last().copied().unwrap_or(last_time);
            if time < last_time {
                return Err(backward(time, last_time, line, &store.header));
            }
            last_time = time;
        }
        rows += 1;
        if rows.is_multiple_of(4096) {
            progress.at(lines.bytes());
        }
    }
    drop(progress);
    let origin = lines.origin().clone();
    if rows == 0 {
        return Err(Failure::usage("the log has a header but no rows").at_line(header_line));
    }
    let mut log = plan.finish(stores.into_iter().map(|(store, _)| store).collect(), rows, options)?;
    log.read_as.format = FORMAT.to_string();
    log.read_as.origin = origin;
    // Rows that were taken out are not copied.
    log.read_as.own_csv = log.rows == rows;
    let pins: Vec<String> = options.map.iter().map(|(name, from)| entry(name, from, None)).collect();
    if !pins.is_empty() {
        log.read_as.pins.push(("--map".into(), pins.join(",")));
    }
    Ok(log)
}

/// The error for a time before that of the row above.
pub fn backward(time: f64, last: f64, line: u64, header: &str) -> Failure {
    Failure::usage(format!(
        "time runs backward, {time} after {last}. Sort the log, or split it at the restart of the recorder"
    ))
    .at_line(line)
    .at_column(header)
}

fn ragged(found: usize, expected: usize, line: u64, at_end: bool) -> Failure {
    let remedy = if at_end && found < expected {
        "the recording seems to have been cut off here: remove the last line"
    } else {
        "correct or remove the line; a text with a comma needs quotes"
    };
    Failure::usage(format!("{found} cells, but the header has {expected}: {remedy}")).at_line(line)
}
