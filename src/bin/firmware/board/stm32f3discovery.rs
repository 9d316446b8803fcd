//! STM32F3DISCOVERY (STM32F303VC, a Cortex-M4F at 64 MHz, 256 KiB of flash, 40 KiB of RAM), as it is sold.
//!
//! | what | where |
//! |---|---|
//! | magnetometer and accelerometer | LSM303AGR or LSM303DLHC, by the board's revision, on I²C 1, 400 kHz: SCL PB6, SDA PB7 |
//! | gyro | L3GD20 or I3G4250D on SPI 1: SCK PA5, MISO PA6, MOSI PA7, CS PE3 |
//! | console | USART 1, 115200 8N1: TX PC4, RX PC5, from revision C on the debugger's USB |
//! | button | the blue one (PA0) |
//! | light | the ring of eight: PE9 (north), PE10, PE11, PE12, PE13, PE14, PE15, PE8 |
//! | calibration | the last two pages (2 KiB each) of the flash |
//!
//! The sensor is read in an interrupt of its own, so that no sample is lost while the loop solves. defmt logs leave over RTT.

mod bus;
mod ring;
mod sampling;
mod sensor;
mod time;
mod uart;
mod watchdog;

use super::motion::Motion;
use super::sampled::NoColumns;
use super::sampler;
use defmt_rtt as _;
use embassy_stm32::Config;
use embassy_stm32::flash::{Blocking, Flash};
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::rcc::{APBPrescaler, Pll, PllMul, PllPreDiv, PllSource, Sysclk};
use embassy_stm32::spi::{self, Spi};
use embassy_stm32::time::Hertz;
use embedded_hal_bus::spi::ExclusiveDevice;
use ironout::device::Pace;
use ironout::sensor::AxisMap;
use ironout::store::FlashSlots;
use ironout_drivers::l3gd20::{self, L3gd20};

pub use super::sampler::Samples;
pub use ring::Panel;
pub use time::Clock;
pub use uart::{Uart as Console, last_words};
pub use watchdog::{Watchdog, restart, was_hung};

/// The board's name, for the console.
pub const NAME: &str = "stm32f3discovery";

/// The sensor's axes are taken for the board's, and so are those of accelerometer and gyro.
pub const MOUNTING: AxisMap = AxisMap::IDENTITY;

/// The sampler's interrupt reads each conversion.
pub const PACE: Pace = Pace::Pushed;

/// Where the memory map (build.rs) keeps the two pages.
const SLOTS: u32 = 256 * 1024 - 2 * 2048;

/// Whether its lights show more than a state: directions seen, north.
pub const SHOWS_COVERAGE: bool = true;

/// Everything the firmware uses of the board.
pub struct Board {
    /// The magnetometer, by the sampler that reads it.
    pub sensor: sampler::Proxy<sampling::Sampling>,
    /// What the sampler has read.
    pub sampled: Samples,
    /// Nothing else is measured.
    pub columns: NoColumns,
    /// Where the calibration is kept.
    pub store: FlashSlots<Flash<'static, Blocking>>,
    /// The serial console.
    pub console: Console,
    /// The clock.
    pub clock: Clock,
    /// Ring and button.
    pub panel: Panel,
    /// The watchdog.
    pub watchdog: Watchdog,
}

impl Board {
    /// Sets the board up. `None` at the second call: its peripherals exist once.
    pub fn take() -> Option<Self> {
        let once = cortex_m::singleton!(: () = ())?;
        let _once: &'static mut () = once;
        let mut config = Config::default();
        // The chip's own oscillator, right to a percent: the crystal's place on the board is empty, and the debugger's clock is
        // not there where the debugger is cut off.
        config.rcc.pll = Some(Pll { src: PllSource::HSI, prediv: PllPreDiv::DIV2, mul: PllMul::MUL16 });
        config.rcc.sys = Sysclk::PLL1_P;
        config.rcc.apb1_pre = APBPrescaler::DIV2;
        let p = embassy_stm32::init(config);
        // Bytes first, they wait shortest; then the sensor, whose reading takes half a millisecond.
        interrupt::USART1.set_priority(Priority::P1);
        interrupt::TIM2.set_priority(Priority::P2);
        time::start(p.TIM2);
        let console = uart::new(p.USART1, p.PC4, p.PC5)?;
        let bus = sampling::BUS.put(bus::Bus::new(p.I2C1, p.PB6, p.PB7));
        let mut wires = spi::Config::default();
        wires.frequency = Hertz(4_000_000);
        let wires = Spi::new_blocking(p.SPI1, p.PA5, p.PA7, p.PA6, wires);
        let select = Output::new(p.PE3, Level::High, Speed::Low);
        let wires = ExclusiveDevice::new_no_delay(wires, select).ok()?;
        let gyro = L3gd20::new_spi(wires, l3gd20::Config::default());
        let motion = Motion::new(sensor::Accelerometer::new(bus.clone()), gyro, MOUNTING);
        let queue = cortex_m::singleton!(: sampler::Waiting = sampler::Waiting::new())?;
        let (sensor, sampled) = sampling::SEAT.take_in(sensor::Lsm303::new(bus), motion, queue);
        // SAFETY: its handler is in `sampling`, and no critical section relies on masks.
        unsafe { interrupt::TIM2.enable() };
        Some(Self {
            sensor,
            sampled,
            columns: NoColumns,
            store: FlashSlots::new(Flash::new_blocking(p.FLASH), SLOTS).ok()?,
            console,
            clock: Clock::new(),
            panel: Panel::new(
                [
                    p.PE9.into(),
                    p.PE10.into(),
                    p.PE11.into(),
                    p.PE12.into(),
                    p.PE13.into(),
                    p.PE14.into(),
                    p.PE15.into(),
                    p.PE8.into(),
                ],
                Input::new(p.PA0, Pull::Down),
            ),
            watchdog: Watchdog::start(p.IWDG),
        })
    }
}
