//! Arm's MPS2 board with the AN386 image (a Cortex-M4F at 25 MHz), as QEMU emulates it: `-M mps2-an386`.
//!
//! The sensor (LSM303DLHC, 0x1e) and the EEPROM (0x50) are on the "shield 1" I²C port, the console is UART 0. defmt logs
//! leave through semihosting, far from the console.

mod registers;
mod sbcon;
mod time;
mod uart;

use defmt_semihosting as _;
use registers::Register;

pub use sbcon::Sbcon as Bus;
pub use time::{Clock, Delay};
pub use uart::Uart as Console;

/// The board's name, for the console.
pub const NAME: &str = "mps2";

const FPGAIO: usize = 0x4002_8000;
// SAFETY: the FPGA's register of two LEDs on the AN386 image.
const LEDS: Register = unsafe { Register::new(FPGAIO, 0x0) };
// SAFETY: the FPGA's register of two buttons on the AN386 image.
const BUTTONS: Register = unsafe { Register::new(FPGAIO, 0x8) };

/// Everything the firmware uses of the board.
pub struct Board {
    /// The I²C bus with the sensor and the EEPROM.
    pub bus: Bus,
    /// The serial console.
    pub console: Console,
    /// The clock that says when to sample.
    pub clock: Clock,
    /// Light and button.
    pub panel: Panel,
}

impl Board {
    /// Sets the board up. `None` at the second call: its peripherals exist once.
    pub fn take() -> Option<Self> {
        let console = Console::new()?;
        let board = Self { bus: Bus::new(), console, clock: Clock::new(), panel: Panel::new() };
        for interrupt in [Interrupt::UartReceive, Interrupt::UartTransmit, Interrupt::Timer0] {
            // SAFETY: everything the handlers use is set up, and no critical section relies on masks.
            unsafe { cortex_m::peripheral::NVIC::unmask(interrupt) };
        }
        Some(board)
    }
}

/// Sleeps until an interrupt: a byte, room for one, or the sample timer.
pub fn sleep() {
    cortex_m::asm::wfi();
}

/// The light and the button.
pub struct Panel {
    /// The button's level at the last two looks.
    held: [bool; 2],
}

impl Panel {
    fn new() -> Self {
        LEDS.write(0);
        Self { held: [false; 2] }
    }

    /// Sets the two lights.
    pub fn light(&mut self, first: bool, second: bool) {
        LEDS.write(u32::from(first) | u32::from(second) << 1);
    }

    /// Whether the button went down. To be asked once a sample period: a level counts once it has stood for two of them, which
    /// no bounce does. (The emulator's buttons are never pressed.)
    pub fn button_pressed(&mut self) -> bool {
        let down = BUTTONS.read() & 1 != 0;
        let [before_last, last] = self.held;
        self.held = [last, down];
        down && last && !before_last
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
