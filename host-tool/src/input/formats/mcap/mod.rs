//! MCAP files of ROS 2 (messages in CDR) and of ROS 1, packed chunks unpacked.

mod cdr;
mod messages;
mod packed;
mod read;
mod records;

pub use read::read;
