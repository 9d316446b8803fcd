//! The internal I²C bus with a limit on every transfer, and a way out where a chip holds a line down.

use crate::board::lines;
use embassy_nrf::gpio::{Flex, OutputDrive, Pull};
use embassy_nrf::peripherals::{P0_08, P0_16, TWISPI0};
use embassy_nrf::twim::{self, Frequency, Twim};
use embassy_nrf::{Peri, bind_interrupts};
use embassy_time::Duration;
use embedded_hal::i2c::{self, ErrorKind, Operation};

/// How long a transaction may take. A sample is 0.3 ms on the wire, and a chip stretches the clock for microseconds, if at all.
const LIMIT: Duration = Duration::from_millis(3);

/// Half a bit of the clocks that free a line, at 100 kHz: some cycles of 64 MHz.
const HALF_BIT_CYCLES: u32 = 320;

/// The longest write; the port's DMA reads RAM only, and constants lie in flash.
const MOST_WRITTEN: usize = 16;

bind_interrupts!(struct Irqs {
    TWISPI0 => twim::InterruptHandler<TWISPI0>;
});

/// The bus. The driver of the HAL is made for each transfer: that takes microseconds, and nothing is left of one that hangs.
pub struct Bus {
    port: Peri<'static, TWISPI0>,
    clock: Peri<'static, P0_08>,
    data: Peri<'static, P0_16>,
    /// Whether the last transfer left the lines in doubt.
    is_in_doubt: bool,
}

impl Bus {
    pub(super) const fn new(
        port: Peri<'static, TWISPI0>,
        clock: Peri<'static, P0_08>,
        data: Peri<'static, P0_16>,
    ) -> Self {
        // A restart in mid-transfer leaves a chip waiting for clocks.
        Self { port, clock, data, is_in_doubt: true }
    }

    fn free(&mut self) -> Result<(), ErrorKind> {
        let mut clock = Flex::new(self.clock.reborrow());
        let mut data = Flex::new(self.data.reborrow());
        for line in [&mut clock, &mut data] {
            line.set_high();
            line.set_as_input_output(Pull::Up, OutputDrive::Standard0Disconnect1);
        }
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
        let mut written = [0; MOST_WRITTEN];
        let mut config = twim::Config::default();
        config.frequency = Frequency::K400;
        let (port, data, clock) = (self.port.reborrow(), self.data.reborrow(), self.clock.reborrow());
        let mut driver = Twim::new(port, Irqs, data, clock, config, &mut written);
        let done = driver.blocking_transaction_timeout(address, operations, LIMIT);
        let done = done.map_err(|error| match error {
            twim::Error::Timeout => ErrorKind::Bus,
            other => i2c::Error::kind(&other),
        });
        // After a missing acknowledgement the bus is idle; after anything else nobody knows.
        self.is_in_doubt = !matches!(done, Ok(()) | Err(ErrorKind::NoAcknowledge(_)));
        done
    }
}
