//! A text log from its bytes to a [`Log`].

use crate::failure::{Failure, Outcome};
use crate::input::columns::MAX_COLUMNS;
use crate::input::log::{Log, ReadOptions};
use crate::input::text::grid::Grid;
use crate::input::text::prefix::{Bare, bare};
use crate::input::text::{build, choose, decode, records, table, two_parts};
use crate::input::words::shorten;
use std::io::Read;

/// Fewer rows are not a log of anything.
const LEAST_ROWS: usize = 1;

/// Reads a text log of any layout.
///
/// # Errors
/// No text, no rows of numbers, no magnetometer, or two readings that are both possible.
pub fn read(source: impl Read, options: &ReadOptions) -> Outcome<Log> {
    let decoded = decode::decode(source)?;
    if decoded.text.trim().is_empty() {
        return Err(Failure::usage(
            "the file is empty. Expected a header line such as t_s,mx_ut,my_ut,mz_ut and one row per sample",
        ));
    }
    let mut grid = grid(&decoded.text)?;
    if !decoded.encoding.is_empty() {
        grid.format = format!("{}, {}", grid.format, decoded.encoding);
    }
    read_grid(grid, options)
}

/// Reads a table that has a layout.
///
/// # Errors
/// No magnetometer, or two readings that are both possible.
pub fn read_grid(mut grid: Grid, options: &ReadOptions) -> Outcome<Log> {
    two_parts::join(&mut grid, &options.map);
    let choice = choose::choose(&grid, options)?;
    build::build(grid, choice, options)
}

/// The layout that most lines have.
fn grid(text: &str) -> Outcome<Grid> {
    let lines: Vec<Bare<'_>> = text.lines().map(bare).collect();
    if let Some(prints) = records::json_array(text) {
        return checked(records::read_prints(&[], &prints));
    }
    let table = table::layout(&lines);
    let rows = table.map_or(0, |table| table.rows);
    let streams = records::streams(&lines);
    // Adafruit's sketches write each sample twice; the finer one is taken. Of raw and corrected the raw one is.
    let most = streams.iter().filter(|(_, count)| *count > 0).max_by_key(|(stream, count)| {
        let first = matches!(stream, records::Stream::Counts | records::Stream::Uni);
        (*count * 10 / streams.iter().map(|(_, count)| *count).max().unwrap_or(1).max(1), first)
    });
    let of_streams: usize = streams.iter().map(|(_, count)| count).sum();
    if let Some((stream, _)) = most
        && of_streams * 2 > rows
    {
        return checked(records::read_stream(&lines, *stream));
    }
    let prints = records::prints(&lines);
    if prints.numbers >= 3 && prints.numbers >= table.map_or(0, |table| table.rows * 3) {
        return checked(records::read_prints(&lines, &prints));
    }
    match table {
        Some(layout) => {
            let grid = checked(table::read(&lines, layout))?;
            match table::doubled(&lines, layout).filter(|_| !grid.named) {
                Some(line) => Err(Failure::usage(format!(
                    "the header has half as many names as the rows have cells ({}): are there commas between cells and in \
                     the \
                     numbers, too?\n  Export the table with semicolons or tabs, or with points in its numbers",
                    layout.cells
                ))
                .at_line(line)),
                None => Ok(grid),
            }
        }
        None => Err(no_rows(&lines)),
    }
}

fn checked(grid: Grid) -> Outcome<Grid> {
    let place = |failure: Failure| match grid.header_line.or(grid.lines.first().copied()) {
        Some(line) => failure.at_line(line),
        None => failure,
    };
    if grid.columns.len() > MAX_COLUMNS {
        return Err(place(Failure::usage(format!(
            "{} columns, at most {MAX_COLUMNS} are read: is this a log?",
            grid.columns.len()
        ))));
    }
    if grid.rows() < LEAST_ROWS {
        return Err(place(Failure::usage("the log has no rows of numbers")));
    }
    Ok(grid)
}

/// Nothing that looks like a log: what was looked for, and how the file begins.
fn no_rows(lines: &[Bare<'_>]) -> Failure {
    let first = lines.iter().enumerate().find(|(_, line)| !line.text.trim().is_empty());
    let (number, begins) = first.map_or((1, ""), |(index, line)| (index as u64 + 1, line.text.as_ref()));
    let header = begins.split([',', ';', '\t']).count() >= 3;
    let what = if header { "the log has a header but no rows" } else { "the format is unknown" };
    Failure::usage(format!(
        "{what}.\n  looked for: lines of at least three numbers (separated by commas, semicolons, tabs, bars or blanks), \
         prints like\n  \
         X: 1 Y: 2 Z: 3, JSON, Raw: lines, R, and C, lines\n  the file begins: {}",
        shorten(begins.trim())
    ))
    .at_line(number)
}
