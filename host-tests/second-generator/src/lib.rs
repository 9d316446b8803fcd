//! Simulated magnetometer logs together with the truth behind them.
//!
//! Written from the theory and the format of logs alone, so that it shares no assumption with a simulator or a
//! search that somebody else wrote. Body frame x forward, y right, z down; world frame NED; µT, m/s², rad/s, s.

mod beyond;
mod column;
mod effect;
mod kind;
/// Vectors, matrices and quaternions of plain arrays.
pub mod linalg;
mod motion;
mod noise;
mod random;
mod setting;
mod truth;
mod world;

pub use kind::Kind;
pub use truth::{Hidden, Truth};
pub use world::{Drawn, draw};
