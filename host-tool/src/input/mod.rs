//! Reading logs: CSV with a header, one row a sample, units in the names.
//!
//! The format is firm (docs/command-line.md, "Log format"): what is not understood is an error with file, line, column and
//! remedy, or a notice; nothing is guessed.

mod columns;
mod guard;
mod lines;
pub mod log;
mod mount;
pub mod number;
pub mod read_as;
mod reader;
mod store;
mod table;

pub use columns::parse_map;
pub use guard::MAX_LINE_BYTES;
pub use lines::Lines;
pub use log::{Covariate, Log, ReadOptions};
pub use mount::{FORMS as ROTATE_FORMS, Mounting};
pub use read_as::{Instance, LeftOut, ReadAs, ReadColumn};
pub use reader::{read_any, read_log, read_stream};
