//! Readers of logs: each format is detected from the content, and becomes the same [`Log`].
//!
//! The reader of the program's own CSV is strict (docs/formats.md, "The own CSV"): a cell that it cannot read is an error with file, line,
//! column and remedy, or a notice. The reader of other text is tolerant, and [`ReadAs`] states each decision.

#[cfg(feature = "parquet")]
mod columnar;
mod columns;
mod detected;
mod followed;
pub mod formats;
mod guard;
mod lines;
mod log;
mod map;
mod memory;
mod mount;
mod names;
#[cfg(test)]
mod names_tests;
pub mod number;
mod own;
mod packed;
mod plan;
mod read_as;
mod reader;
mod repair;
mod repair_asked;
mod repair_words;
mod store;
mod table;
mod text;
mod unit;
mod vocabulary;
mod words;

pub use detected::{read_log, read_stream};
pub use guard::MAX_LINE_BYTES;
pub use lines::Lines;
pub use log::{Covariate, Log, ReadOptions};
pub use map::{entry as map_entry, parse_map};
pub use memory::from_columns;
pub use mount::{FORMS as ROTATE_FORMS, Mounting, rotate};
pub use read_as::{Instance, LeftOut, Origin, ReadAs, ReadColumn};
pub use repair::parse as parse_repair;
pub use unit::{Quantity, Unit};
