//! What a session is told.

use crate::fit::Method;

/// What a session needs to know of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SessionConfig {
    /// Scale of each axis, µT per count.
    pub ut_per_count: [f64; 3],
    /// The expected magnitude of the field, µT; `None` keeps the mean magnitude.
    pub field_ut: Option<f64>,
    /// The method.
    pub method: Method,
    /// Samples in a block of the rest gate; see [`crate::gate::block_samples`].
    pub samples_per_block: u16,
}

impl SessionConfig {
    /// The scale in the precision of coverage, whose cells are coarse.
    pub(super) fn scale(&self) -> [f32; 3] {
        self.ut_per_count.map(|scale| scale as f32)
    }
}
