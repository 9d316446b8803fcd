//! Chips for the simulated bus, at the level of their registers.

mod at24c;
mod lsm303dlhc;

pub use at24c::{At24cChip, TornPage};
pub use lsm303dlhc::{FieldSource, Lsm303dlhcChip};
