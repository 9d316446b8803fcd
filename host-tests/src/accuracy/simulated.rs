//! A simulated log as the analysis sees it.

use ironout_analysis::Table;
use ironout_simulation::Log;

/// The columns of a simulated log.
///
/// # Panics
/// Where a log lacks its magnetometer, which the simulation always writes unless it is told to leave it out.
pub fn table_of(log: &Log) -> Table<'_> {
    Table::from_columns(log.named()).expect("a simulated log has a magnetometer")
}
