//! Accelerometer and gyro of a board, in its axes.

use super::sampled::Moved;
use super::sampler;
use ironout::sensor::AxisMap;
use ironout_drivers::{Accelerometer, Gyroscope};

/// What tells of motion, and how it is mounted.
pub struct Motion<A, G> {
    /// The accelerometer, and whether it was started.
    accelerometer: (A, bool),
    gyro: (G, bool),
    mounting: AxisMap,
}

impl<A, G> Motion<A, G> {
    pub const fn new(accelerometer: A, gyro: G, mounting: AxisMap) -> Self {
        Self { accelerometer: (accelerometer, false), gyro: (gyro, false), mounting }
    }
}

impl<A: Accelerometer, G: Gyroscope> sampler::Motion for Motion<A, G> {
    /// A chip that does not start is not there.
    fn start(&mut self) {
        let (accelerometer, works) = &mut self.accelerometer;
        *works = accelerometer.init().is_ok();
        let (gyro, works) = &mut self.gyro;
        *works = gyro.init().is_ok();
    }

    fn read(&mut self) -> Moved {
        let mounted = |chip: [f32; 3]| self.mounting.vector(chip);
        let (accelerometer, works) = &mut self.accelerometer;
        let accel_mps2 = works.then(|| accelerometer.read_mps2().ok().flatten()).flatten().map(mounted);
        let (gyro, works) = &mut self.gyro;
        let turn_radps = works.then(|| gyro.read_radps().ok().flatten()).flatten().map(mounted);
        Moved { accel_mps2, turn_radps }
    }
}

/// The gyro of a board without one.
#[cfg(feature = "board-microbit-v2")]
pub struct NoGyro;

#[cfg(feature = "board-microbit-v2")]
impl Gyroscope for NoGyro {
    type BusError = ();

    fn init(&mut self) -> Result<(), ironout::sensor::Error<()>> {
        Err(ironout::sensor::Error::Bus(()))
    }

    fn read_radps(&mut self) -> Result<Option<[f32; 3]>, ironout::sensor::Error<()>> {
        Ok(None)
    }
}
