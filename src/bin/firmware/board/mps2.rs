//! Arm's MPS2 board with the AN386 image (a Cortex-M4F at 25 MHz), as QEMU emulates it: `-M mps2-an386`.
//!
//! The sensor (LSM303DLHC, 0x1e) and the EEPROM (0x50) are on the "shield 1" I²C port, the console is UART 0. defmt logs
//! leave through semihosting, far from the console.

mod registers;
mod sbcon;
mod time;
mod uart;

use super::sampled::{NoColumns, Polled, Unwatched};
use core::cell::RefCell;
use defmt_semihosting as _;
use eeprom24x::{Eeprom24x, SlaveAddr, addr_size::TwoBytes, page_size::B32, unique_serial};
use embedded_hal_bus::i2c::RefCellDevice;
use ironout::device::{Pace, Shown};
use ironout::sensor::AxisMap;
use ironout::store::StorageSlots;
use ironout_drivers::lsm303dlhc::{Config, DataRate, Lsm303dlhc, Range, TemperatureFormat};
use registers::Register;
use sbcon::Sbcon;

pub use time::Clock;
pub use uart::{Uart as Console, last_words};

/// One user's share of the I²C bus.
type Bus = RefCellDevice<'static, Sbcon>;

/// An AT24C32: pages of 32 bytes, two bytes of address.
type Eeprom = eeprom24x::Storage<Bus, B32, TwoBytes, unique_serial::No, time::Delay>;

/// The bytes of a page of it.
const PAGE_BYTES: u32 = 32;

/// The board's name, for the console.
pub const NAME: &str = "mps2";

/// The sensor's axes are taken for the board's.
pub const MOUNTING: AxisMap = AxisMap::IDENTITY;

/// 50 samples a second of the board's own clock: the emulated chip is always ready and has no rate of its own.
pub const PACE: Pace = Pace::Every(20);

const FPGAIO: usize = 0x4002_8000;
// SAFETY: the FPGA's register of two LEDs on the AN386 image.
const LEDS: Register = unsafe { Register::new(FPGAIO, 0x0) };
// SAFETY: the FPGA's register of two buttons on the AN386 image.
const BUTTONS: Register = unsafe { Register::new(FPGAIO, 0x8) };

/// How the sensor is set up. ±1.9 G: the emulated sensor takes fields from zero up only, so that every axis carries a bias
/// of some 93 µT, and with the field on top ±1.3 G would be exceeded. The temperature stands where QEMU puts it.
const SENSOR: Config = Config {
    range: Range::Gauss1_9,
    rate: DataRate::Hz75,
    temperature: true,
    temperature_format: TemperatureFormat::RightJustified,
};

/// Whether its lights show more than a state: directions seen, north.
pub const SHOWS_COVERAGE: bool = false;

/// Everything the firmware uses of the board.
pub struct Board {
    /// The magnetometer.
    pub sensor: Lsm303dlhc<Bus>,
    /// Nothing: the sensor is read in the loop.
    pub sampled: Polled,
    /// Nothing else is measured.
    pub columns: NoColumns,
    /// Where the calibration is kept: the first KiB of the EEPROM.
    pub store: StorageSlots<Eeprom>,
    /// The serial console.
    pub console: Console,
    /// The clock.
    pub clock: Clock,
    /// Light and button.
    pub panel: Panel,
    /// None: the emulated machine's is not used.
    pub watchdog: Unwatched,
}

impl Board {
    /// Sets the board up. `None` at the second call: its peripherals exist once.
    pub fn take() -> Option<Self> {
        let console = Console::new()?;
        let bus = cortex_m::singleton!(: RefCell<Sbcon> = RefCell::new(Sbcon::new()))?;
        let bus: &'static RefCell<Sbcon> = bus;
        let eeprom = Eeprom24x::new_24x32(RefCellDevice::new(bus), SlaveAddr::default());
        let store = StorageSlots::new(Eeprom::new(eeprom, time::Delay), 0, PAGE_BYTES).ok()?;
        let board = Self {
            sensor: Lsm303dlhc::new(RefCellDevice::new(bus), SENSOR),
            sampled: Polled,
            columns: NoColumns,
            store,
            console,
            clock: Clock::new(),
            panel: Panel::new(),
            watchdog: Unwatched,
        };
        for interrupt in [Interrupt::UartReceive, Interrupt::UartTransmit, Interrupt::Timer0] {
            // SAFETY: everything the handlers use is set up, and no critical section relies on masks.
            unsafe { cortex_m::peripheral::NVIC::unmask(interrupt) };
        }
        Some(board)
    }
}

/// Whether the watchdog has restarted the board; there is none.
pub const fn was_hung() -> bool {
    false
}

/// Restarts the board.
pub fn restart() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}

/// The light and the button.
pub struct Panel(());

impl Panel {
    fn new() -> Self {
        LEDS.write(0);
        Self(())
    }

    /// Shows the state.
    pub fn show(&mut self, shown: &Shown) {
        LEDS.write(u32::from(shown.is_on));
    }

    /// Whether the button is down, bounces and all. (The emulator's buttons never are.)
    pub fn button_down(&self) -> bool {
        BUTTONS.read() & 1 != 0
    }
}

/// The interrupts in use, by their number on the AN386 image.
#[derive(Clone, Copy)]
#[repr(u16)]
enum Interrupt {
    UartReceive = 0,
    UartTransmit = 1,
    Timer0 = 8,
}

// SAFETY: the numbers are those of the AN386 image, and `VECTORS` below has a handler for each.
unsafe impl cortex_m::interrupt::InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

unsafe extern "C" {
    /// What cortex-m-rt calls for an interrupt that nobody expects.
    fn DefaultHandler();
}

/// The interrupt table, of the 32 lines the AN386 image has.
// SAFETY: the section and the name under which cortex-m-rt's linker script expects the table; every entry is a handler.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 32] = {
    let mut table: [unsafe extern "C" fn(); 32] = [DefaultHandler; 32];
    table[Interrupt::UartReceive as usize] = uart::on_receive;
    table[Interrupt::UartTransmit as usize] = uart::on_transmit;
    table[Interrupt::Timer0 as usize] = time::on_timer0;
    table
};
