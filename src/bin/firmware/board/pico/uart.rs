//! UART 0.

use super::time::now_us;
use crate::board::port::{self, Port, Registers};
use embassy_rp::Peri;
use embassy_rp::interrupt;
use embassy_rp::interrupt::InterruptExt;
use embassy_rp::pac;
use embassy_rp::peripherals::{PIN_0, PIN_1, UART0};
use embassy_rp::uart;

const REGISTERS: pac::uart::Uart = pac::UART0;

/// The registers of UART 0.
pub struct Uart0;

/// The port.
pub type Uart = Port<Uart0>;

#[interrupt]
fn UART0_IRQ() {
    port::move_bytes::<Uart0>();
}

impl Registers for Uart0 {
    fn acknowledge() {
        REGISTERS.uarticr().write(|w| w.set_txic(true));
    }

    fn receive() -> Option<Result<u8, ()>> {
        if REGISTERS.uartfr().read().rxfe() {
            return None;
        }
        let received = REGISTERS.uartdr().read();
        // An overrun comes with the first byte after it; a break or a wrong frame is no byte.
        let is_lost = received.oe() || received.be() || received.fe();
        Some(if is_lost { Err(()) } else { Ok(received.data()) })
    }

    fn has_room() -> bool {
        !REGISTERS.uartfr().read().txff()
    }

    fn send(byte: u8) {
        REGISTERS.uartdr().write(|w| w.set_data(byte));
    }

    fn now_us() -> u32 {
        now_us() as u32
    }
}

/// Sets the port up. `None` if it already is.
pub fn new(port: Peri<'static, UART0>, tx: Peri<'static, PIN_0>, rx: Peri<'static, PIN_1>) -> Option<Uart> {
    set_up(port, tx, rx);
    let port = Port::new()?;
    REGISTERS.uartimsc().write(|w| {
        w.set_rxim(true);
        w.set_rtim(true);
        w.set_txim(true);
    });
    // SAFETY: its handler is above, and no critical section relies on masks.
    unsafe { interrupt::UART0_IRQ.enable() };
    Some(port)
}

/// The HAL sets pins, rate and FIFOs; the default is 115200 8N1. Its driver is forgotten: dropped it would give the pins back.
fn set_up(port: Peri<'static, UART0>, tx: Peri<'static, PIN_0>, rx: Peri<'static, PIN_1>) {
    core::mem::forget(uart::Uart::new_blocking(port, tx, rx, uart::Config::default()));
}

/// Answers each line with `text` for ever, without interrupts and without memory.
pub fn last_words(text: &str) -> ! {
    // SAFETY: nothing else runs any more.
    let p = unsafe { embassy_rp::Peripherals::steal() };
    set_up(p.UART0, p.PIN_0, p.PIN_1);
    port::last_words::<Uart0>(text, super::watchdog::feed)
}
