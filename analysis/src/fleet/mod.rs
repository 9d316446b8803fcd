//! Many logs of many vehicles: what most of them lack, which vehicles differ, how each sensor's offset moves over days.

pub mod apart;
pub mod entry;
pub mod history;
pub mod summary;

pub use entry::{Calibrated, FleetLog, Move};
pub use summary::{Fleet, summarize};
