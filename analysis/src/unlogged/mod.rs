//! Causes that no column shows: an offset for each of several recordings, an offset that switches between two values, an offset with many
//! jumps.
//!
//! Both work on corrected vectors, µT, and give back vectors in the sensor's own axes.

pub mod levels;
pub mod linear;
pub mod pair;
pub mod recordings;
pub mod switching;
