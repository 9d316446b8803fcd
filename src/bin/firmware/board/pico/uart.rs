//! UART 0, 115200 8N1, with a ring buffer in each direction behind interrupts.

use super::time::now_us;
use crate::board::outgoing::Outgoing;
use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use embassy_rp::Peri;
use embassy_rp::interrupt;
use embassy_rp::interrupt::InterruptExt;
use embassy_rp::pac;
use embassy_rp::peripherals::{PIN_0, PIN_1, UART0};
use embassy_rp::uart;
use heapless::spsc::{Consumer, Producer, Queue};

/// What arrives at full speed in 90 ms. A solve takes longer: bytes that find no room are marked as lost, and the line they
/// belonged to is refused.
const RX_BYTES: usize = 1024;
/// Holds the longest reply and some lines of a stream.
const TX_BYTES: usize = 4096;

/// How long text may stay where it is.
pub const STALL_LIMIT_US: u32 = 200_000;

/// Stands in for bytes that were lost. The console refuses a line that holds it, so that a command with a hole in it is
/// never carried out as another one.
const LOST: u8 = 0xFF;

const REGISTERS: pac::uart::Uart = pac::UART0;

/// The handler's ends of the buffers.
struct Handler {
    received: Producer<'static, u8>,
    to_send: Consumer<'static, u8>,
}

static HANDLER: Mutex<RefCell<Option<Handler>>> = Mutex::new(RefCell::new(None));

/// Bytes were lost after those in the buffer. While it is set nothing more is buffered, so that the place of the loss
/// is known.
static RX_LOST: AtomicBool = AtomicBool::new(false);

#[interrupt]
fn UART0_IRQ() {
    move_bytes();
}

/// Empties the port into its buffer and fills it from the other, as far as either goes.
fn move_bytes() {
    critical_section::with(|section| {
        let mut handler = HANDLER.borrow_ref_mut(section);
        let Some(handler) = handler.as_mut() else { return };
        REGISTERS.uarticr().write(|w| w.set_txic(true));
        while !REGISTERS.uartfr().read().rxfe() {
            let received = REGISTERS.uartdr().read();
            // An overrun comes with the first byte after it; a break or a wrong frame is no byte.
            let is_lost = received.oe() || received.be() || received.fe() || !handler.received.ready();
            if is_lost {
                RX_LOST.store(true, Ordering::Relaxed);
            }
            if !RX_LOST.load(Ordering::Relaxed) {
                let _ = handler.received.enqueue(received.data());
            }
        }
        while !REGISTERS.uartfr().read().txff() {
            let Some(byte) = handler.to_send.dequeue() else { return };
            REGISTERS.uartdr().write(|w| w.set_data(byte));
        }
    });
}

/// The port.
pub struct Uart {
    received: Consumer<'static, u8>,
    outgoing: Outgoing,
}

impl Uart {
    /// Sets the port up. `None` if it already is.
    pub(super) fn new(
        port: Peri<'static, UART0>,
        tx: Peri<'static, PIN_0>,
        rx: Peri<'static, PIN_1>,
    ) -> Option<Self> {
        let rx_buffer = cortex_m::singleton!(: Queue<u8, RX_BYTES> = Queue::new())?;
        let tx_buffer = cortex_m::singleton!(: Queue<u8, TX_BYTES> = Queue::new())?;
        let (rx_in, rx_out) = rx_buffer.split();
        let (tx_in, tx_out) = tx_buffer.split();
        // The HAL sets pins, rate and FIFOs; the default is 115200 8N1. Its driver is forgotten: dropped it would give the pins back.
        core::mem::forget(uart::Uart::new_blocking(port, tx, rx, uart::Config::default()));
        critical_section::with(|section| {
            HANDLER.borrow(section).replace(Some(Handler { received: rx_in, to_send: tx_out }));
        });
        REGISTERS.uartimsc().write(|w| {
            w.set_rxim(true);
            w.set_rtim(true);
            w.set_txim(true);
        });
        // SAFETY: its handler is above, and no critical section relies on masks.
        unsafe { interrupt::UART0_IRQ.enable() };
        Some(Self { received: rx_out, outgoing: Outgoing::new(tx_in, STALL_LIMIT_US) })
    }

    /// The next byte received; [`LOST`] where some are missing.
    pub fn read(&mut self) -> Option<u8> {
        if let Some(byte) = self.received.dequeue() {
            return Some(byte);
        }
        // ARMv6-M cannot swap: the handler only ever sets it.
        if RX_LOST.load(Ordering::Relaxed) {
            RX_LOST.store(false, Ordering::Relaxed);
            return Some(LOST);
        }
        None
    }

    /// Whether [`Self::read`] has something to give.
    pub fn has_input(&self) -> bool {
        self.received.ready() || RX_LOST.load(Ordering::Relaxed)
    }

    /// Whether so many bytes may be put.
    pub fn takes(&self, bytes: usize) -> bool {
        self.outgoing.takes(bytes, now_us() as u32)
    }

    /// Queues text.
    pub fn put(&mut self, text: &str) {
        self.outgoing.put(text);
        move_bytes();
    }
}

/// Answers each line with `text` for ever, without interrupts and without memory.
pub fn last_words(text: &str) -> ! {
    // SAFETY: nothing else runs any more.
    let p = unsafe { embassy_rp::Peripherals::steal() };
    core::mem::forget(uart::Uart::new_blocking(p.UART0, p.PIN_0, p.PIN_1, uart::Config::default()));
    let mut is_empty = true;
    loop {
        super::watchdog::feed();
        if REGISTERS.uartfr().read().rxfe() {
            continue;
        }
        let byte = REGISTERS.uartdr().read().data();
        if byte == b'\n' && !is_empty {
            for byte in text.bytes().chain(*b"\n") {
                while REGISTERS.uartfr().read().txff() {}
                REGISTERS.uartdr().write(|w| w.set_data(byte));
            }
        }
        is_empty = byte == b'\n' || (is_empty && byte == b'\r');
    }
}
