//! Shows that no file of the workspace imports another in a circle, that arrows only run down the order of rooms that
//! `host-tests/layers/ROOMS.md` declares, and that no code file is too long.
//!
//! | what counts as an arrow | |
//! |---|---|
//! | `use` trees with groups, globs and renames, `pub use` too | from the file they stand in |
//! | inline paths, `crate::a::b(..)`, `super::x`, `child::y`, also inside macros and attributes | the same |
//! | a path | leads to the deepest module it names that has a file |
//! | `mod x;` | is no import: a facade may declare what it does not use |
//! | a test module in a file of its own | may import its parent |
//!
//! Every target is a crate of its own: libraries, programs, tests, benches, examples. Modules are followed whatever their
//! `cfg`. How the order is declared: see `order.rs`.

mod arrows;
mod check;
mod circles;
mod finding;
mod order;
mod paths;
mod tree;
mod workspace;

pub use check::check_workspace;
pub use finding::{Finding, Report};
