//! A log as the program's own CSV.

use crate::cli::LogArgs;
use crate::input::Log;
use crate::read_block;
use std::io::{self, Write};

/// What stands above the header: where the log is from and how it was read.
pub fn comment(log: &Log, arguments: &LogArgs) -> String {
    let mut text = format!("imported from {}\n{}", log.path.display(), read_block::text(log));
    for rotate in &arguments.rotate {
        text.push_str(&format!("rotated with --rotate={rotate}: the columns are in body axes\n"));
    }
    text
}

/// Writes every column; numbers read back to the same bits, missing ones are empty. `counts`: as they were, without a scale.
///
/// # Errors
/// Those of writing.
pub fn log(out: &mut dyn Write, log: &Log, comment: &str, counts: bool) -> io::Result<()> {
    for line in comment.lines() {
        writeln!(out, "# {line}")?;
    }
    let columns = columns(log, counts);
    let names: Vec<String> = columns.iter().map(|(name, _)| cell(name)).collect();
    writeln!(out, "{}", names.join(","))?;
    for row in 0..log.rows {
        line(out, &columns, row)?;
        writeln!(out)?;
    }
    Ok(())
}

/// The columns of a log by their names.
pub fn columns(log: &Log, counts: bool) -> Vec<(&str, &[f64])> {
    const UT: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
    const COUNTS: [&str; 3] = ["mx_counts", "my_counts", "mz_counts"];
    let mut columns: Vec<(&str, &[f64])> = Vec::new();
    columns.extend(log.time_s.iter().map(|time| ("t_s", time.as_slice())));
    let triples = [
        (if counts { COUNTS } else { UT }, Some(&log.field_ut)),
        (["ax_mps2", "ay_mps2", "az_mps2"], log.accel_mps2.as_ref()),
        (["gx_radps", "gy_radps", "gz_radps"], log.gyro_radps.as_ref()),
    ];
    for (names, triple) in triples {
        columns.extend(
            triple.into_iter().flat_map(|axes| names.into_iter().zip(axes.iter().map(Vec::as_slice))),
        );
    }
    columns.extend(log.heading_deg.iter().map(|heading| ("heading_deg", heading.as_slice())));
    columns.extend(
        log.covariates.iter().map(|covariate| (covariate.name.as_str(), covariate.values.as_slice())),
    );
    columns
}

/// The cells of one row.
///
/// # Errors
/// Those of writing.
pub fn line(out: &mut dyn Write, columns: &[(&str, &[f64])], row: usize) -> io::Result<()> {
    for (index, (_, values)) in columns.iter().enumerate() {
        if index > 0 {
            write!(out, ",")?;
        }
        if let Some(value) = values.get(row).filter(|value| value.is_finite()) {
            write!(out, "{value}")?;
        }
    }
    Ok(())
}

/// A name as a cell.
pub fn cell(name: &str) -> String {
    if name.contains([',', '"']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_string() }
}
