//! From the bytes of a CSV file to a [`Log`].

use crate::failure::{Failure, Outcome};
use crate::formats;
use crate::input::columns::{self, Column, Role};
use crate::input::lines::{Cutter, Lines};
use crate::input::log::{Covariate, Log, ReadOptions};
use crate::input::mount::rotate;
use crate::input::read_as::ReadAs;
use crate::input::store::Store;
use crate::progress::Progress;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Reads the log at `path`. Every error names the file, and line and column where there are any.
pub fn read_log(path: &Path, options: &ReadOptions) -> Outcome<Log> {
    let file = File::open(path).map_err(|error| Failure::io("open", path, &error))?;
    let metadata = file.metadata().map_err(|error| Failure::io("open", path, &error))?;
    if metadata.is_dir() {
        return Err(Failure::usage("this is a folder: name a log file").in_file(path));
    }
    let mut log = read_any(file, metadata.len(), options).map_err(|failure| {
        // Usage errors of an option have no file; those of the log have a line.
        if failure.file.is_none() { failure.in_file(path) } else { failure }
    })?;
    log.path = path.to_path_buf();
    Ok(log)
}

/// Reads a log of any format from any source of bytes: a binary one is told by its first bytes, the rest is CSV.
pub fn read_any(mut source: impl Read, size_bytes: u64, options: &ReadOptions) -> Outcome<Log> {
    let mut first = Vec::new();
    source
        .by_ref()
        .take(formats::FIRST_BYTES as u64)
        .read_to_end(&mut first)
        .map_err(|error| Failure::usage(format!("cannot read: {error}")))?;
    let whole = first.as_slice().chain(source);
    match formats::told(&first) {
        Some(format) => formats::read(format, whole, size_bytes, options),
        None => read_stream(whole, size_bytes, options),
    }
}

/// Reads a log from any source of bytes; `size_bytes` (0: unknown) only sizes buffers and the progress bar.
pub fn read_stream(source: impl Read, size_bytes: u64, options: &ReadOptions) -> Outcome<Log> {
    let mut lines = Lines::new(source);
    let mut cutter = Cutter::new();
    let Some(first) = lines.next_row()? else {
        return Err(Failure::usage(
            "the file is empty: expected a header line such as t_s,mx_ut,my_ut,mz_ut and one row a sample",
        ));
    };
    let header_line = first.number;
    let rows_guess = (size_bytes / (first.text.len().max(16) as u64)).min(4_000_000) as usize;
    let cells = cutter.cut(first.text);
    let header: Vec<String> = (0..cells)
        .map(|i| String::from_utf8_lossy(cutter.cell(first.text, i).trim_ascii()).into_owned())
        .collect();
    let columns = columns::interpret(&header, &options.map, header_line)?;
    let plan = Plan::new(&header, &columns, options, header_line)?;

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
                return Err(Failure::usage(format!(
                    "time runs backward, {time} after {last_time}: sort the log, or split it where the recorder \
                     started again"
                ))
                .at_line(line)
                .at_column(store.header.clone()));
            }
            last_time = time;
        }
        rows += 1;
        if rows.is_multiple_of(4096) {
            progress.at(lines.bytes());
        }
    }
    drop(progress);
    if rows == 0 {
        return Err(
            Failure::usage("the log has a header and no rows: nothing was recorded").at_line(header_line)
        );
    }
    plan.finish(stores.into_iter().map(|(store, _)| store).collect(), rows, options)
}

fn ragged(found: usize, expected: usize, line: u64, at_end: bool) -> Failure {
    let remedy = if at_end && found < expected {
        "the recording seems to have been cut off here: remove the last line"
    } else {
        "correct or remove the line; a text with a comma needs quotes"
    };
    Failure::usage(format!("{found} cells where the header has {expected}: {remedy}")).at_line(line)
}

/// Where everything is, once the header is understood.
struct Plan {
    time: Option<usize>,
    microseconds: bool,
    field: [usize; 3],
    scale: Option<[f64; 3]>,
    accel: Option<[usize; 3]>,
    gyro: Option<[usize; 3]>,
    heading: Option<usize>,
    /// Columns in which only finite numbers are allowed.
    strict: Vec<usize>,
    notices: Vec<String>,
}

impl Plan {
    fn new(header: &[String], columns: &[Column], options: &ReadOptions, line: u64) -> Outcome<Self> {
        let covariate = |name: &str| columns.iter().any(|c| c.name == name && c.role == Role::Covariate);
        let mut notices: Vec<String> = options
            .map
            .iter()
            .filter(|(name, _)| covariate(name))
            .map(|(name, from)| {
                format!("{from} is read as {name}: no sensor of the log format has that name, so it is a covariate")
            })
            .collect();
        let find = |role: Role| columns.iter().position(|column| column.role == role);
        let (seconds, microseconds) = (find(Role::Seconds), find(Role::Microseconds));
        if seconds.is_some() && microseconds.is_some() {
            return Err(
                Failure::usage("both t_s and t_us: name one of them otherwise with --map").at_line(line)
            );
        }
        let whole = |make: fn(usize) -> Role| -> Option<[usize; 3]> {
            let [x, y, z] = columns::triple(columns, make);
            Some([x?, y?, z?])
        };
        let (ut, counts) = (whole(Role::FieldUt), whole(Role::FieldCounts));
        let (field, scale) = match (ut, counts, options.ut_per_count) {
            (Some(_), Some(counts), Some(scale)) => {
                notices.push(
                    "the log has mx_ut and mx_counts; the counts are used (--ut-per-count is given)".into(),
                );
                (counts, Some(scale))
            }
            (Some(ut), both, scale) => {
                if both.is_some() {
                    notices.push("the log has mx_ut and mx_counts; mx_ut is used".into());
                }
                if scale.is_some() {
                    notices.push("--ut-per-count is not used: the log is in microtesla".into());
                }
                (ut, None)
            }
            (None, Some(counts), Some(scale)) => (counts, Some(scale)),
            (None, Some(counts), None) if options.default_ut_per_count.is_some() => {
                (counts, options.default_ut_per_count)
            }
            (None, Some(_), None) => {
                return Err(Failure::usage(
                    "the magnetometer is in counts: give its scale with --ut-per-count UT, one number or three \
                     comma-separated for x,y,z (see the data sheet; 0.1 for values in milligauss)",
                )
                .at_line(line)
                .at_column("mx_counts"));
            }
            (None, None, _) => return Err(columns::no_field(header, columns, line)),
        };
        let mut optional = |make: fn(usize) -> Role, what: &str, names: &str| {
            let found = columns::triple(columns, make);
            if found.iter().any(Option::is_some) && found.iter().any(Option::is_none) {
                notices.push(format!("{what} ignored: it needs all of {names}"));
            }
            whole(make)
        };
        let accel = optional(Role::Accel, "the accelerometer is", "ax_mps2,ay_mps2,az_mps2");
        let gyro = optional(Role::Gyro, "the gyroscope is", "gx_radps,gy_radps,gz_radps");
        notices.extend(options.mounting.notices(accel.is_some(), gyro.is_some()));
        let heading = find(Role::Heading);
        let time = seconds.or(microseconds);
        let strict = time.into_iter().chain(field).collect();
        Ok(Plan {
            time,
            microseconds: microseconds.is_some(),
            field,
            scale,
            accel,
            gyro,
            heading,
            strict,
            notices,
        })
    }

    fn finish(self, mut stores: Vec<Store>, rows: usize, options: &ReadOptions) -> Outcome<Log> {
        let mut notices = self.notices;
        for (index, store) in stores.iter().enumerate() {
            if let Some((line, cell)) = &store.text {
                notices.push(format!(
                    "column {} is ignored: it holds text (\"{cell}\" on line {line})",
                    columns::shorten(&store.header)
                ));
            } else if store.column.role == Role::Unnamed {
                notices.push(format!("column {} is ignored: it has no name", index + 1));
            }
        }
        let mut take = |index: usize| std::mem::take(&mut stores[index].values);
        let mut take3 = |indices: [usize; 3]| -> Option<[Vec<f64>; 3]> {
            let columns = indices.map(&mut take);
            // A text column has lost its values.
            columns.iter().all(|column| column.len() == rows).then_some(columns)
        };
        let raw = take3(self.field).unwrap_or_default();
        let mut accel_mps2 = self.accel.and_then(&mut take3);
        let mut gyro_radps = self.gyro.and_then(&mut take3);
        let mut time_s = self.time.map(&mut take);
        if let (Some(time), true) = (&mut time_s, self.microseconds) {
            time.iter_mut().for_each(|t| *t /= 1e6);
        }
        let heading_deg = self.heading.map(&mut take).filter(|column| column.len() == rows);

        let counts = match (self.scale, options.mounting.magnetometer) {
            (Some(_), None) => integers(&raw),
            _ => None,
        };
        let mut field_ut = raw;
        if let Some(scale) = self.scale {
            for (column, scale) in field_ut.iter_mut().zip(scale) {
                column.iter_mut().for_each(|value| *value *= scale);
            }
        }
        turn(&mut field_ut, options.mounting.magnetometer);
        if let Some(columns) = &mut accel_mps2 {
            turn(columns, options.mounting.accelerometer);
        }
        if let Some(columns) = &mut gyro_radps {
            turn(columns, options.mounting.gyroscope);
        }
        let covariates = stores
            .into_iter()
            .filter(|store| store.column.role == Role::Covariate && store.text.is_none())
            .filter(|store| store.values.len() == rows)
            .map(|store| Covariate {
                name: store.column.name,
                values: store.values,
                empty: store.empty,
                not_finite: store.not_finite,
            })
            .collect();
        Ok(Log {
            path: Default::default(),
            rows,
            time_s,
            field_ut,
            ut_per_count: self.scale,
            counts,
            accel_mps2,
            gyro_radps,
            heading_deg,
            covariates,
            read_as: ReadAs::default(),
            notices,
        })
    }
}

/// The triple as 16-bit counts, if every value is one.
fn integers(raw: &[Vec<f64>; 3]) -> Option<Vec<[i16; 3]>> {
    let exact = |value: f64| {
        let count = value as i16;
        (f64::from(count) == value).then_some(count)
    };
    let [x, y, z] = raw;
    x.iter().zip(y).zip(z).map(|((&x, &y), &z)| Some([exact(x)?, exact(y)?, exact(z)?])).collect()
}

fn turn(columns: &mut [Vec<f64>; 3], matrix: Option<[[f64; 3]; 3]>) {
    let Some(matrix) = matrix else { return };
    let [x, y, z] = columns;
    for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
        [*x, *y, *z] = rotate(&matrix, [*x, *y, *z]);
    }
}
