//! The board's own study on simulated traces: what `why` names, and what `effect add` leaves.

mod compare;
mod replay;
mod table;
mod trace;

pub use compare::{Both, One, apart, triangle};
pub use replay::{Board, Recording, UT_PER_COUNT};
pub use table::{Row, is_right, row, row_of};
pub use trace::{Kind, Said, Trace, TraceOptions};
