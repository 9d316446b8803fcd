//! The fits: one file per method, one report, one error type.
//!
//! | method | file | source |
//! |---|---|---|
//! | constant | `constant.rs` | Dong, Chou, Fang 2014, eqs. (9)–(15), errata corrected |
//! | trace | `root.rs`, its first step | the same least squares, normalised by the trace: no singular position |
//! | adjusted | `root.rs` | Markovsky, Kukush, Van Huffel 2004: no bias from noise, estimates the noise |
//!
//! All start from a [`Scatter`](crate::scatter::Scatter); none sees a sample.

mod bias;
mod constant;
mod options;
pub mod precision;
mod report;
mod root;
mod solve;

pub use crate::quadric::Order;
pub use crate::refusal::{FitError, axis_letter};
pub use options::{FIELD_RANGE_UT, FitOptions, MAX_PREDICTED_ERROR, MIN_SAMPLES, MIN_THICKNESS, Method};
pub use precision::Spread;
pub use report::{FitReport, StdErrors, Termination};
pub use solve::fit;
