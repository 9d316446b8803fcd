//! What a device is told of its board.

use super::sensor::Pace;
use crate::gate::block_samples;
use crate::sensor::Sensor;
use crate::session::SessionConfig;

/// What a device needs to know of its board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceConfig {
    /// The board's name, for `version`.
    pub board: &'static str,
    /// The sensor, as configured and mounted.
    pub sensor: Sensor,
    /// When samples are taken.
    pub pace: Pace,
}

impl DeviceConfig {
    /// The session's part of it.
    pub(super) fn session(&self) -> SessionConfig {
        let mut config = SessionConfig::of(&self.sensor);
        if let Pace::Every(period_ms) = self.pace {
            config.samples_per_block = block_samples(1000.0 / f64::from(period_ms.max(1)));
        }
        config
    }
}
