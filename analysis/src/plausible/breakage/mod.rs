//! Numbers that a driver, a bus or a recorder broke, each kind recognised by the repair that undoes it.
//!
//! One principle for all kinds: a sensor turns, so neighbouring rows are near each other. Each candidate repair is tried, and it is
//! the diagnosis if it removes nearly all of the path length at the rows that it touches and the readings are continuous afterwards.
//! All functions are free of units: they take the numbers as the file has them.

mod codes;
mod ellipsoid;
mod evidence;
mod find;
mod maps;
mod range;
mod repair;
mod rows;
mod series;

pub use evidence::Breakage;
pub use find::find;
pub use repair::Repair;
