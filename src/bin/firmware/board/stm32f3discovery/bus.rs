//! I²C 1 with a limit on every transfer, and a way out where a chip holds a line down.

use crate::board::lines;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, OutputOpenDrain, Speed};
use embassy_stm32::i2c::{self as port, I2c};
use embassy_stm32::peripherals::{I2C1, PB6, PB7};
use embassy_stm32::time::Hertz;
use embassy_time::Duration;
use embedded_hal::i2c::{self, ErrorKind, Operation};

/// How long a transaction may take. A sample is 0.3 ms on the wire, and a chip stretches the clock for microseconds, if at all.
const LIMIT: Duration = Duration::from_millis(3);

/// Half a bit of the clocks that free a line, at 100 kHz: some cycles of 64 MHz.
const HALF_BIT_CYCLES: u32 = 320;

/// The bus. The driver of the HAL is made for each transfer: that takes microseconds, and nothing is left of one that hangs.
pub struct Bus {
    port: Peri<'static, I2C1>,
    clock: Peri<'static, PB6>,
    data: Peri<'static, PB7>,
    /// Whether the last transfer left the lines in doubt.
    is_in_doubt: bool,
}

impl Bus {
    pub(super) const fn new(
        port: Peri<'static, I2C1>,
        clock: Peri<'static, PB6>,
        data: Peri<'static, PB7>,
    ) -> Self {
        // A restart in mid-transfer leaves a chip waiting for clocks.
        Self { port, clock, data, is_in_doubt: true }
    }

    fn free(&mut self) -> Result<(), ErrorKind> {
        let mut clock = OutputOpenDrain::new(self.clock.reborrow(), Level::High, Speed::Low);
        let mut data = OutputOpenDrain::new(self.data.reborrow(), Level::High, Speed::Low);
        lines::free(&mut clock, &mut data, || cortex_m::asm::delay(HALF_BIT_CYCLES))
    }
}

impl i2c::ErrorType for Bus {
    type Error = ErrorKind;
}

impl i2c::I2c for Bus {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        if self.is_in_doubt {
            self.free()?;
        }
        let mut config = port::Config::default();
        config.frequency = Hertz::khz(400);
        config.timeout = LIMIT;
        let mut driver =
            I2c::new_blocking(self.port.reborrow(), self.clock.reborrow(), self.data.reborrow(), config);
        let done = i2c::I2c::transaction(&mut driver, address, operations);
        let done = done.map_err(|error| match error {
            port::Error::Timeout => ErrorKind::Bus,
            other => i2c::Error::kind(&other),
        });
        // After a missing acknowledgement the bus is idle; after anything else nobody knows.
        self.is_in_doubt = !matches!(done, Ok(()) | Err(ErrorKind::NoAcknowledge(_)));
        done
    }
}
