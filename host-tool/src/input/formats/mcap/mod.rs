//! MCAP files of ROS 2 (messages in CDR) and of ROS 1, packed chunks unpacked by the crate `mcap`.

mod cdr;
mod messages;
mod read;
mod records;

pub use read::read;
