//! A table in memory as a log: by the names of the program's own CSV, or as text that the tolerant reader takes.

use ironout_cli::cli::LogArgs;
use ironout_cli::failure::Outcome;
use ironout_cli::input::{self, Log, ReadOptions};
use std::fmt::Write;

/// The log of these columns.
pub fn log(names: Vec<String>, values: Vec<Vec<f64>>, arguments: &LogArgs) -> Outcome<Log> {
    let options = ReadOptions { progress: false, ..arguments.options()? };
    let in_table = |failure: ironout_cli::failure::Failure| match failure.file {
        Some(_) => failure,
        None => failure.in_file(&arguments.log),
    };
    let mut log = if input::is_own(&names, &options, 1) {
        input::from_columns(names, values, &options).map_err(in_table)?
    } else {
        let text = text(&names, &values);
        input::read_stream(text.as_bytes(), text.len() as u64, &options).map_err(in_table)?
    };
    log.path.clone_from(&arguments.log);
    // Its lines cannot be copied from a file.
    log.read_as.own_csv = false;
    Ok(log)
}

/// CSV whose numbers come back to the last bit.
fn text(names: &[String], values: &[Vec<f64>]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{}\"", name.replace('"', "\"\""))).collect();
    let mut out = quoted.join(",");
    let rows = values.iter().map(Vec::len).max().unwrap_or(0);
    for row in 0..rows {
        out.push('\n');
        for (index, column) in values.iter().enumerate() {
            if index > 0 {
                out.push(',');
            }
            if let Some(value) = column.get(row).filter(|value| !value.is_nan()) {
                // Into a string nothing fails.
                let _ = write!(out, "{value}");
            }
        }
    }
    out.push('\n');
    out
}
