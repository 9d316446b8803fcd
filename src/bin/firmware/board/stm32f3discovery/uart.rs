//! The console: USART 1, to the debugger's USB.

use super::time::now_us;
use crate::board::port::{self, Port, Registers};
use embassy_stm32::Peri;
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::InterruptExt;
use embassy_stm32::pac;
use embassy_stm32::peripherals::{PC4, PC5, USART1};
use embassy_stm32::usart;

const REGISTERS: pac::usart::Usart = pac::USART1;

/// The registers of USART 1.
pub struct Usart1;

/// The port.
pub type Uart = Port<Usart1>;

#[interrupt]
fn USART1() {
    port::move_bytes::<Usart1>();
}

impl Registers for Usart1 {
    /// Its flags go with what is done about them.
    fn acknowledge() {}

    fn receive() -> Option<Result<u8, ()>> {
        let flags = REGISTERS.isr().read();
        if flags.ore() || flags.fe() || flags.ne() {
            REGISTERS.icr().write(|w| {
                w.set_ore(true);
                w.set_fe(true);
                w.set_ne(true);
            });
            return Some(Err(()));
        }
        flags.rxne().then(|| Ok(REGISTERS.rdr().read().dr() as u8))
    }

    fn has_room() -> bool {
        REGISTERS.isr().read().txe()
    }

    fn send(byte: u8) {
        REGISTERS.tdr().write(|w| w.set_dr(u16::from(byte)));
    }

    /// The flag stands as long as there is room.
    fn wants_room(wanted: bool) {
        REGISTERS.cr1().modify(|w| w.set_txeie(wanted));
    }

    fn now_us() -> u32 {
        now_us() as u32
    }
}

/// The HAL sets pins and rate; the default is 115200 8N1. Its driver is forgotten: dropped it would switch the port off.
fn set_up(port: Peri<'static, USART1>, tx: Peri<'static, PC4>, rx: Peri<'static, PC5>) -> Option<()> {
    let driver = usart::Uart::new_blocking(port, rx, tx, usart::Config::default()).ok()?;
    core::mem::forget(driver);
    Some(())
}

/// Sets the port up. `None` if it already is.
pub fn new(port: Peri<'static, USART1>, tx: Peri<'static, PC4>, rx: Peri<'static, PC5>) -> Option<Uart> {
    set_up(port, tx, rx)?;
    let port = Port::new()?;
    REGISTERS.cr1().modify(|w| w.set_rxneie(true));
    // SAFETY: its handler is above, and no critical section relies on masks.
    unsafe { interrupt::USART1.enable() };
    Some(port)
}

/// Answers each line with `text` for ever, without interrupts and without memory.
pub fn last_words(text: &str) -> ! {
    // SAFETY: nothing else runs any more.
    let p = unsafe { embassy_stm32::Peripherals::steal() };
    // Where it cannot be set up it may be so already.
    let _ = set_up(p.USART1, p.PC4, p.PC5);
    port::last_words::<Usart1>(text, super::watchdog::feed)
}
