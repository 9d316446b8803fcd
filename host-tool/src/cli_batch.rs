//! What can be asked of `batch`.

use crate::log_args::{FieldArgs, LogArgs};
use clap::Args;
use std::path::PathBuf;

/// `batch`.
#[derive(Debug, Args)]
#[command(mut_arg("log", |arg| arg.value_name("DIR|GLOB|LOG").help("Folder (searched with its subfolders), quoted pattern such as 'logs/*/*.ulg', or log")))]
#[command(mut_arg("more", |arg| arg.value_name("DIR|GLOB|LOG").help("Further folders, patterns and logs")))]
#[command(after_help = "Examples:
  ironout batch logs/ -o fleet.csv                          one row per log, and a summary
  ironout batch 'logs/*/*.ulg' -o fleet.jsonl --jobs 8
  ironout batch logs/ -o fleet.csv --page fleet.html
  ironout batch logs/ -o fleet.csv --vehicle-from '{vehicle}_*.csv'

Run the same command again after Ctrl-C or when there are new logs: only logs
that are new or changed are studied. A log that cannot be read gets one row
with its error. Exit status 1: interrupted, or no log could be studied.")]
pub struct BatchArgs {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub log: LogArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub field: FieldArgs,
    /// Write the table here: CSV, JSON Lines if the name ends in .jsonl, Parquet if it ends in .parquet
    #[arg(short, long, value_name = "TABLE.csv|.jsonl|.parquet")]
    pub output: PathBuf,
    /// Logs analysed at the same time (default: number of cores)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Vehicle and sensor from the path, if the log does not name them: a pattern of its last parts with {vehicle}, {sensor} and *
    /// (default: the folder below DIR)
    #[arg(long, value_name = "PATTERN")]
    pub vehicle_from: Option<String>,
    /// Write the summary as one page here, with the offset of each sensor over time
    #[arg(long, value_name = "FLEET.html")]
    pub page: Option<PathBuf>,
    /// Study all logs again
    #[arg(long)]
    pub again: bool,
}
