//! The board's own study on simulated traces: what `why` names, and what `effect add` leaves.

mod trace;

pub use trace::{Kind, Said, Trace, TraceOptions};
