//! Recordings of ROS: MCAP files of ROS 2 (messages in CDR) and of ROS 1, packed chunks unpacked; and rosbag2's SQLite files.

mod bag;
mod cdr;
mod messages;
mod packed;
mod read;
mod records;
mod sqlite;
mod topics;

pub use bag::read as read_bag;
pub use read::read;
