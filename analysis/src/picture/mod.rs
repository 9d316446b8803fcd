//! What a page draws: one log under one calibration, as series short enough to be sent and drawn.

pub mod bins;
pub mod look;
pub mod picture;
pub mod rows;
pub mod spectrum;
pub mod tiles;
pub mod timeline;
