//! The base model: hard iron, soft iron and alignment, with the noise as its residual shows it; and the linearised model
//! that everything behind it is fitted with.

pub mod alignment;
pub mod applied;
pub mod axes;
pub mod beside_gyro;
pub mod by_gyro;
pub mod counted;
pub mod dip_errors;
pub mod earlier;
pub mod engine;
pub mod folds;
pub mod ground;
pub mod heading;
pub mod hemisphere;
pub mod holdout;
pub mod level;
pub mod model;
pub mod mounting;
pub mod order;
pub mod prior;
pub mod quality;
pub mod residuals;
pub mod rest;
pub mod solution;
pub mod start;
pub mod term;
pub mod windows;
