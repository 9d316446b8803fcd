//! What the drivers' text means where the bus is awaited: what it says.

pub use embedded_hal_async::delay::DelayNs;
pub use embedded_hal_async::i2c::I2c;
pub use embedded_hal_async::spi::SpiDevice;
pub use ironout_sensor::{
    AsyncAccelerometer as Accelerometer, AsyncGyroscope as Gyroscope, AsyncMagnetometer as Magnetometer,
};
pub use maybe_async::must_be_async as both;
