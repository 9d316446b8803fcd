//! The board's own study on simulated traces: what `why` names, and what `effect add` leaves.

mod table;
mod trace;

pub use table::{Row, is_right, row};
pub use trace::{Kind, Said, Trace, TraceOptions};
