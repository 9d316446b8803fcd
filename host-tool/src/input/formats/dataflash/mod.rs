//! ArduPilot DataFlash, binary and as text, read from its own definitions (ardupilot.org, "Log messages"; the layout is that
//! of libraries/AP_Logger/LogStructure.h).

mod binary;
mod collect;
mod compass;
mod definition;
mod text;
mod units;
mod wanted;

pub use binary::read_binary;
pub use compass::{has_offsets, undo};
pub use text::read_text;
