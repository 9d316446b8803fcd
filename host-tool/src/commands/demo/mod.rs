//! `ironout demo`: a board is turned, calibrates itself, loses power, and still knows its calibration.
//!
//! The board belongs to the project's tests, so it is there with the feature `demo` only.

#[cfg(not(feature = "demo"))]
mod absent;
#[cfg(feature = "demo")]
mod bench;
#[cfg(feature = "demo")]
mod hidden;
#[cfg(all(feature = "demo", unix))]
mod pico;
#[cfg(feature = "demo")]
mod story;
#[cfg(feature = "demo")]
mod talk;

#[cfg(not(feature = "demo"))]
pub use absent::run;
#[cfg(feature = "demo")]
pub use story::run;
