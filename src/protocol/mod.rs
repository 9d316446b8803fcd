//! The console's language: lines in, commands out, replies back. No I/O and no state of the board in here.
//!
//! One command a line, at most [`MAX_LINE`] characters, ended by `\n` or `\r\n`. Each line that is not empty is
//! answered by any number of lines that begin with `+ ` and then exactly one that is `ok …` or
//! `err CODE text`.

mod command;
mod cov;
mod line;
mod load;
mod motioncal;
mod reply;
#[cfg(test)]
mod tests;

pub use command::{Command, EffectId, MAX_ID, ParseError, StreamMode, parse};
pub use cov::{Assigned, Assignments, MAX_ASSIGNMENTS};
pub use line::{Line, LineSplitter, MAX_LINE};
pub use load::{LOAD_LINE_BYTES, Load, LoadBytes};
pub use motioncal::{PACKET_BYTES, Packet};
pub use reply::{Answered, Code, Opt, Reply};
