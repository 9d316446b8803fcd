//! MCAP files of ROS 2 (messages in CDR) and of ROS 1, records read by the crate `mcap`.

mod cdr;
mod messages;
mod read;

pub use read::read;
