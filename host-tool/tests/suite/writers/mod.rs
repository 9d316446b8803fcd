//! Logs of other programs, written by the tests from the specifications of their formats.

pub mod blackbox;
pub mod dataflash;
pub mod fuzz;
pub mod mavlink;
pub mod ros;
pub mod sqlite;
pub mod truth;
pub mod ulog;
