//! The console: the chip's UART without DMA, whose bytes wait in six places, to the interface chip's USB.

use super::time::now_us;
use crate::board::port::{self, Port, Registers};
use core::sync::atomic::{AtomicBool, Ordering};
use embassy_nrf::Peri;
use embassy_nrf::gpio::{Input, Level, Output, OutputDrive, Pull};
use embassy_nrf::interrupt;
use embassy_nrf::interrupt::InterruptExt;
use embassy_nrf::peripherals::{P0_06, P1_08, UARTE0};

/// The port's registers: nRF52833 product specification, 6.32 UART. The HAL knows only the one with DMA at the same place, which
/// would have to be told how many bytes will come.
const UART0: usize = 0x4000_2000;

/// A register of it.
struct Register(usize);

impl Register {
    fn write(&self, value: u32) {
        // SAFETY: a register of the port, which this module alone has; none of them touches memory.
        unsafe { ((UART0 + self.0) as *mut u32).write_volatile(value) }
    }

    fn read(&self) -> u32 {
        // SAFETY: as above.
        unsafe { ((UART0 + self.0) as *const u32).read_volatile() }
    }
}

const START_RX: Register = Register(0x000);
const START_TX: Register = Register(0x008);
const RX_READY: Register = Register(0x108);
const TX_READY: Register = Register(0x11c);
const ERROR: Register = Register(0x124);
const INTERRUPTS: Register = Register(0x304);
const ERROR_SOURCE: Register = Register(0x480);
const ENABLE: Register = Register(0x500);
const PIN_RTS: Register = Register(0x508);
const PIN_TX: Register = Register(0x50c);
const PIN_CTS: Register = Register(0x510);
const PIN_RX: Register = Register(0x514);
const RECEIVED: Register = Register(0x518);
const TO_SEND: Register = Register(0x51c);
const BAUD_RATE: Register = Register(0x524);
const FORMAT: Register = Register(0x56c);

const UNCONNECTED: u32 = u32::MAX;
const BAUD_115200: u32 = 0x01d7_e000;
const ENABLED: u32 = 4;
/// Interrupts of a byte received, a byte sent, an error.
const WANTED: u32 = 1 << 2 | 1 << 7 | 1 << 9;
/// P0.06 and P1.08, as pins are named in registers.
const TX: u32 = 6;
const RX: u32 = 32 + 8;

/// A byte is on its way.
static IS_SENDING: AtomicBool = AtomicBool::new(false);

/// The registers.
pub struct Uart0;

/// The port.
pub type Uart = Port<Uart0>;

#[interrupt]
fn UARTE0() {
    port::move_bytes::<Uart0>();
}

impl Registers for Uart0 {
    fn acknowledge() {
        if TX_READY.read() != 0 {
            TX_READY.write(0);
            IS_SENDING.store(false, Ordering::Relaxed);
        }
    }

    fn receive() -> Option<Result<u8, ()>> {
        if ERROR.read() != 0 {
            ERROR.write(0);
            // Ones clear it.
            ERROR_SOURCE.write(ERROR_SOURCE.read());
            return Some(Err(()));
        }
        if RX_READY.read() == 0 {
            return None;
        }
        // Before the byte is taken: the next one's event comes with it.
        RX_READY.write(0);
        Some(Ok(RECEIVED.read() as u8))
    }

    fn has_room() -> bool {
        !IS_SENDING.load(Ordering::Relaxed)
    }

    fn send(byte: u8) {
        IS_SENDING.store(true, Ordering::Relaxed);
        TO_SEND.write(u32::from(byte));
    }

    fn now_us() -> u32 {
        now_us() as u32
    }
}

fn set_up() {
    ENABLE.write(0);
    PIN_RTS.write(UNCONNECTED);
    PIN_CTS.write(UNCONNECTED);
    PIN_TX.write(TX);
    PIN_RX.write(RX);
    BAUD_RATE.write(BAUD_115200);
    FORMAT.write(0);
    ENABLE.write(ENABLED);
    for event in [RX_READY, TX_READY, ERROR] {
        event.write(0);
    }
    START_RX.write(1);
    START_TX.write(1);
}

/// Sets the port up. `None` if it already is.
pub fn new(_port: Peri<'static, UARTE0>, tx: Peri<'static, P0_06>, rx: Peri<'static, P1_08>) -> Option<Uart> {
    // What the pins are while the port is off; forgotten, because dropped they would be let go.
    core::mem::forget((Output::new(tx, Level::High, OutputDrive::Standard), Input::new(rx, Pull::Up)));
    set_up();
    let port = Port::new()?;
    INTERRUPTS.write(WANTED);
    // SAFETY: its handler is above, and no critical section relies on masks.
    unsafe { interrupt::UARTE0.enable() };
    Some(port)
}

/// Answers each line with `text` for ever, without interrupts and without memory.
pub fn last_words(text: &str) -> ! {
    set_up();
    IS_SENDING.store(false, Ordering::Relaxed);
    port::last_words::<Uart0>(text, super::watchdog::feed)
}
