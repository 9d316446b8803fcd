//! The board's own study on simulated traces: what `why` names, and what `effect add` leaves.

mod compare;
#[cfg(unix)]
pub mod emulated;
mod replay;
mod table;
mod trace;

pub use compare::{Both, One, apart, triangle};
#[cfg(unix)]
pub use emulated::{Lengths as EmulatedLengths, Samples as EmulatedSamples, Shown as EmulatedShown};
pub use replay::{Board, Recording, UT_PER_COUNT};
pub use table::{Row, is_right, row, row_of};
pub use trace::{Kind, Said, Trace, TraceOptions};
