//! Raspberry Pi Pico (RP2040, two Cortex-M0+ at 125 MHz, 2 MiB of flash), of which one core is used.
//!
//! | what | where |
//! |---|---|
//! | magnetometer | I²C 0, 400 kHz: SDA GP4 (pin 6), SCL GP5 (pin 7) |
//! | console | UART 0, 115200 8N1: TX GP0 (pin 1), RX GP1 (pin 2); and a serial port on USB. The one that sent the last line is answered |
//! | button | GP15 (pin 20) to ground |
//! | light | the board's LED (GP25) |
//! | columns | `cpu_temp_c`; `adc0_v`, `adc1_v`, `adc2_v`: volts at GP26, GP27, GP28 (pins 31, 32, 34) |
//! | calibration | the last two sectors of the flash |
//!
//! The sensor is read in an interrupt of its own, so that no sample is lost while the loop solves. defmt logs leave over RTT.

mod bus;
mod columns;
mod console;
mod probed;
mod sampling;
mod time;
mod uart;
mod usb;
mod watchdog;

use super::sampler;
use defmt_rtt as _;
use embassy_rp::flash::{Blocking, Flash};
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_rp::peripherals::FLASH;
use ironout::device::{Pace, Shown};
use ironout::sensor::AxisMap;
use ironout::store::FlashSlots;
// Only its critical section is asked for, by crates that need to compare and swap.
use portable_atomic as _;

pub use super::sampler::Samples;
pub use columns::Columns;
pub use console::Console;
pub use time::Clock;
pub use uart::last_words;
pub use watchdog::{Watchdog, restart, was_hung};

/// The board's name, for the console.
pub const NAME: &str = "pico";

/// The sensor's axes are taken for the board's.
pub const MOUNTING: AxisMap = AxisMap::IDENTITY;

/// The sampler's interrupt reads each conversion.
pub const PACE: Pace = Pace::Pushed;

const FLASH_BYTES: usize = 2 * 1024 * 1024;
/// Where the memory map (build.rs) keeps the two sectors.
const SLOTS: u32 = FLASH_BYTES as u32 - 2 * 4096;

/// Whether its lights show more than a state: directions seen, north.
pub const SHOWS_COVERAGE: bool = false;

/// Everything the firmware uses of the board.
pub struct Board {
    /// The magnetometer, by the sampler that reads it.
    pub sensor: sampler::Proxy<sampling::Sampling>,
    /// What the sampler has read.
    pub sampled: Samples,
    /// The processor's temperature, and the voltage at three pins.
    pub columns: Columns,
    /// Where the calibration is kept.
    pub store: FlashSlots<Flash<'static, FLASH, Blocking, FLASH_BYTES>>,
    /// The serial console, on two ports.
    pub console: Console,
    /// The clock.
    pub clock: Clock,
    /// Light and button.
    pub panel: Panel,
    /// The watchdog.
    pub watchdog: Watchdog,
}

impl Board {
    /// Sets the board up. `None` at the second call: its peripherals exist once.
    pub fn take() -> Option<Self> {
        let flash = cortex_m::singleton!(: () = ())?;
        let _once: &'static mut () = flash;
        let p = embassy_rp::init(embassy_rp::config::Config::default());
        // Bytes first, they wait shortest; then time; the sensor, whose reading takes a third of a millisecond; USB's task last.
        interrupt::UART0_IRQ.set_priority(Priority::P0);
        interrupt::TIMER_IRQ_0.set_priority(Priority::P1);
        interrupt::TIMER_IRQ_3.set_priority(Priority::P1);
        interrupt::USBCTRL_IRQ.set_priority(Priority::P1);
        interrupt::TIMER_IRQ_1.set_priority(Priority::P2);
        interrupt::SWI_IRQ_0.set_priority(Priority::P3);
        let uart = uart::new(p.UART0, p.PIN_0, p.PIN_1)?;
        let usb = usb::Usb::new(p.USB)?;
        let queue = cortex_m::singleton!(: sampler::Waiting = sampler::Waiting::new())?;
        let sensor = probed::Probed::new(bus::Bus::new(p.I2C0, p.PIN_5, p.PIN_4));
        let (sensor, sampled) = sampling::SEAT.take_in(sensor, (), queue);
        // SAFETY: its handler is in `sampling`, and no critical section relies on masks.
        unsafe { interrupt::TIMER_IRQ_1.enable() };
        Some(Self {
            sensor,
            sampled,
            columns: Columns::new(p.ADC, p.ADC_TEMP_SENSOR, p.PIN_26, p.PIN_27, p.PIN_28),
            store: FlashSlots::new(Flash::new_blocking(p.FLASH), SLOTS).ok()?,
            console: Console::new(uart, usb),
            clock: Clock::new(),
            panel: Panel { light: Output::new(p.PIN_25, Level::Low), button: Input::new(p.PIN_15, Pull::Up) },
            watchdog: Watchdog::start(p.WATCHDOG),
        })
    }
}

/// The light and the button.
pub struct Panel {
    light: Output<'static>,
    button: Input<'static>,
}

impl Panel {
    /// Shows the state.
    pub fn show(&mut self, shown: &Shown) {
        self.light.set_level(if shown.is_on { Level::High } else { Level::Low });
    }

    /// Whether the button is down, bounces and all.
    pub fn button_down(&self) -> bool {
        self.button.is_low()
    }
}
