//! A calibration from start to verdict: Idle → Collecting → Solved | Refused. No I/O.
//!
//! The session owns the rest gate with the sums behind it and the sketch of directions; whoever owns the sensor pushes
//! counts, whoever talks to the user asks for the status. What collects and what came of it are never needed at once, and
//! share their memory.

mod collector;
mod config;
mod machine;
#[cfg(test)]
mod memory;
mod status;

pub use config::SessionConfig;
pub use machine::Session;
pub use status::{Hint, Outcome, State, StateError, Status};
