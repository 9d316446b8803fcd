//! A table in memory as a log, read by the names of its columns as a file is.

use ironout_cli::cli::LogArgs;
use ironout_cli::failure::{Failure, Outcome};
use ironout_cli::input::{self, Log, ReadOptions};

/// The log of these columns.
pub fn log(names: Vec<String>, values: Vec<Vec<f64>>, arguments: &LogArgs) -> Outcome<Log> {
    let options = ReadOptions { progress: false, ..arguments.options()? };
    let in_table = |failure: Failure| match failure.file {
        Some(_) => failure,
        None => failure.in_file(&arguments.log),
    };
    let mut log = input::from_columns(names, values, &options).map_err(in_table)?;
    log.path.clone_from(&arguments.log);
    Ok(log)
}
