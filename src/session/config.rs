//! What a session is told.

use crate::fit::Method;
use crate::gate::block_samples;
use crate::sensor::{AxisMap, Sensor};

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
    /// How the sensor is mounted, as the record of [`Session::accept`](super::Session::accept) says it; `None` where the samples are in
    /// the chip's own axes and nobody asks.
    pub axes: Option<AxisMap>,
}

impl SessionConfig {
    /// For a sensor whose every conversion is taken: its scale in the board's axes, its rate, its mounting; the default method, and no
    /// expected magnitude.
    pub fn of(sensor: &Sensor) -> Self {
        Self {
            ut_per_count: sensor.board_ut_per_count().map(f64::from),
            field_ut: None,
            method: Method::default(),
            samples_per_block: block_samples(f64::from(sensor.rate_hz)),
            axes: Some(sensor.axes),
        }
    }

    /// The scale in the precision of coverage, whose cells are coarse.
    pub(super) fn scale(&self) -> [f32; 3] {
        self.ut_per_count.map(|scale| scale as f32)
    }
}
