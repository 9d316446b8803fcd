//! BBC micro:bit V2 (nRF52833, a Cortex-M4F at 64 MHz, 512 KiB of flash, 128 KiB of RAM), as it is sold.
//!
//! | what | where |
//! |---|---|
//! | magnetometer and accelerometer | LSM303AGR on the internal I²C bus, 400 kHz: SCL P0.08, SDA P0.16 |
//! | console | the USB cable, by the interface chip: TX P0.06, RX P1.08, 115200 8N1 |
//! | button | A (P0.14) |
//! | light | the matrix of 5×5: rows P0.21, P0.22, P0.15, P0.24, P0.19, columns P0.28, P0.11, P0.31, P1.05, P0.30 |
//! | calibration | the last two pages (4 KiB each) of the flash |
//!
//! The sensor is read in an interrupt of its own, so that no sample is lost while the loop solves. defmt logs leave over RTT.

mod bus;
mod columns;
mod matrix;
mod sampling;
mod time;
mod uart;
mod watchdog;

use super::motion::{Motion, NoGyro};
use super::sampler;
use defmt_rtt as _;
use embassy_nrf::config::{Config, HfclkSource};
use embassy_nrf::gpio::{Input, Pull};
use embassy_nrf::interrupt;
use embassy_nrf::interrupt::{InterruptExt, Priority};
use embassy_nrf::nvmc::Nvmc;
use ironout::device::Pace;
use ironout::sensor::AxisMap;
use ironout::store::FlashSlots;
use ironout_drivers::lis2mdl::{self, Lis2mdl, Model};
use ironout_drivers::lsm303_accelerometer::{self, Lsm303Accelerometer};

pub use super::sampler::Samples;
pub use columns::Columns;
pub use matrix::Panel;
pub use time::Clock;
pub use uart::{Uart as Console, last_words};
pub use watchdog::{Watchdog, restart, was_hung};

/// The board's name, for the console.
pub const NAME: &str = "microbit-v2";

/// The sensor's axes are taken for the board's; its accelerometer has the same.
pub const MOUNTING: AxisMap = AxisMap::IDENTITY;

/// The sampler's interrupt reads each conversion.
pub const PACE: Pace = Pace::Pushed;

/// Where the memory map (build.rs) keeps the two pages.
const SLOTS: u32 = 512 * 1024 - 2 * 4096;

/// Whether its lights show more than a state: directions seen, north.
pub const SHOWS_COVERAGE: bool = true;

/// Everything the firmware uses of the board.
pub struct Board {
    /// The magnetometer, by the sampler that reads it.
    pub sensor: sampler::Proxy<sampling::Sampling>,
    /// What the sampler has read.
    pub sampled: Samples,
    /// The processor's temperature.
    pub columns: Columns,
    /// Where the calibration is kept.
    pub store: FlashSlots<Nvmc<'static>>,
    /// The serial console.
    pub console: Console,
    /// The clock.
    pub clock: Clock,
    /// Matrix and button.
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
        // The crystal: the clock of the samples is right to some tens of parts in a million.
        config.hfclk_source = HfclkSource::ExternalXtal;
        let p = embassy_nrf::init(config);
        // Bytes first, they wait shortest; then the sensor, whose reading takes half a millisecond; the matrix last.
        interrupt::UARTE0.set_priority(Priority::P1);
        interrupt::TIMER1.set_priority(Priority::P2);
        interrupt::TIMER2.set_priority(Priority::P3);
        time::start(p.TIMER1);
        let console = uart::new(p.UARTE0, p.P0_06, p.P1_08)?;
        let bus = sampling::BUS.put(bus::Bus::new(p.TWISPI0, p.P0_08, p.P0_16));
        let accelerometer = lsm303_accelerometer::Config {
            model: lsm303_accelerometer::Model::Lsm303agr,
            ..lsm303_accelerometer::Config::default()
        };
        let motion = Motion::new(Lsm303Accelerometer::new(bus.clone(), accelerometer), NoGyro, MOUNTING);
        let magnetometer = Lis2mdl::new(bus, lis2mdl::Config::of(Model::Lsm303agr));
        let queue = cortex_m::singleton!(: sampler::Waiting = sampler::Waiting::new())?;
        let (sensor, sampled) = sampling::SEAT.take_in(magnetometer, motion, queue);
        // SAFETY: its handler is in `sampling`, and no critical section relies on masks.
        unsafe { interrupt::TIMER1.enable() };
        Some(Self {
            sensor,
            sampled,
            columns: Columns::new(),
            store: FlashSlots::new(Nvmc::new(p.NVMC), SLOTS).ok()?,
            console,
            clock: Clock::new(),
            panel: Panel::new(
                p.TIMER2,
                [p.P0_21.into(), p.P0_22.into(), p.P0_15.into(), p.P0_24.into(), p.P0_19.into()],
                [p.P0_28.into(), p.P0_11.into(), p.P0_31.into(), p.P1_05.into(), p.P0_30.into()],
                Input::new(p.P0_14, Pull::None),
            ),
            watchdog: Watchdog::start(p.WDT)?,
        })
    }
}
