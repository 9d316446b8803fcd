//! Frozen behaviour: what a diagnosis says of some 600 logs, held in one CSV snapshot. `cargo diff-diagnose` prints what a change made
//! better or worse.

pub mod compare;
pub mod entry;
pub mod files;
pub mod generated;
pub mod row;
pub mod run;
pub mod snapshot;
