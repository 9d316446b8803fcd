//! Text logs as people have them: any separator, any names, any unit; told by content, and said.
//!
//! Unlike the program's own CSV, a foreign table is read tolerantly: lines that are not rows are left out, counted and named. What its
//! columns are is decided by their names, by the program that wrote it, and by what their numbers rule out; where two readings are left,
//! the program asks.

mod asked;
mod bare;
mod build;
mod choice;
mod choose;
mod clock;
mod decode;
mod grid;
mod instances;
mod labels;
mod magnitude;
mod prefix;
mod program;
mod records;
mod rest;
mod shared;
mod table;
mod times;
mod two_parts;
mod vectors;
mod whole;

#[cfg(feature = "parquet")]
pub use grid::number_of;
pub use grid::{Grid, GridColumn, unique};
pub use whole::{read, read_grid};
