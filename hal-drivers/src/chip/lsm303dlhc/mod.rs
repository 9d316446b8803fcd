//! ST LSM303DLHC, the magnetic half (address 0x1e): 12-bit counts, ±1.3 to ±8.1 G, 0.75 to 220 Hz.

mod map;
pub mod register;
mod types;

pub use types::{Config, DataRate, Range, TemperatureFormat};
