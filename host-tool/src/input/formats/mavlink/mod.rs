//! Telemetry logs of MAVLink (`.tlog`), as ground stations write them: packets of versions 1 and 2, each behind its time.

mod packet;
mod read;

pub use packet::is_log;
pub use read::read;
