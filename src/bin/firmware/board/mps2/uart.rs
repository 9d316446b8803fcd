//! The console: CMSDK UART 0, 115200 baud, with a ring buffer in each direction behind interrupts.

use super::registers::Register;
use super::time;
use crate::board::outgoing::Outgoing;
use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use heapless::spsc::{Consumer, Producer, Queue};
use ironout::device::Output;

const UART0: usize = 0x4000_4000;
// SAFETY: the registers of CMSDK UART 0; they touch no memory.
const DATA: Register = unsafe { Register::new(UART0, 0x0) };
// SAFETY: as above.
const STATE: Register = unsafe { Register::new(UART0, 0x4) };
// SAFETY: as above.
const CONTROL: Register = unsafe { Register::new(UART0, 0x8) };
// SAFETY: as above.
const INTERRUPT: Register = unsafe { Register::new(UART0, 0xC) };
// SAFETY: as above.
const BAUD_DIVIDER: Register = unsafe { Register::new(UART0, 0x10) };

const TX_FULL: u32 = 1 << 0;
const RX_FULL: u32 = 1 << 1;
const RX_OVERRUN: u32 = 1 << 3;
/// Transmit and receive, each with its interrupt.
const ENABLE_ALL: u32 = 0b1111;
const RECEIVE_INTERRUPT: u32 = 1 << 3;
const INTERRUPT_TX: u32 = 1 << 0;
const INTERRUPT_RX: u32 = 1 << 1;

/// Holds what arrives at full speed during the longest turn of the loop: a stop that solves over limited attitude, where lower
/// orders are tried too, takes 1.7 million instructions (0.65 million over the whole sphere). That is some 70 ms, 800 bytes.
const RX_BYTES: usize = 1024;
/// Holds the longest reply and some lines of a stream.
const TX_BYTES: usize = 4096;

/// How long text may stay where it is. A terminal that stopped reading for longer must not keep commands waiting.
const STALL_LIMIT_US: u32 = 200_000;

/// Stands in for bytes that were lost. The console refuses a line that holds it, so that a command with a hole in it is
/// never carried out as another one.
const LOST: u8 = 0xFF;

/// The handlers' ends of the buffers.
struct Handlers {
    received: Producer<'static, u8>,
    to_send: Consumer<'static, u8>,
}

static HANDLERS: Mutex<RefCell<Option<Handlers>>> = Mutex::new(RefCell::new(None));

/// Bytes were lost after those in the buffer. While it is set nothing more is buffered, so that the place of the loss
/// is known.
static RX_LOST: AtomicBool = AtomicBool::new(false);

/// The handler of the receive interrupt, and what goes on receiving after a pause.
///
/// A full buffer pauses it: the byte stays in the port, where it holds up a sender with flow control (the emulator's
/// socket), and where a real line runs it over, which the port tells.
pub extern "C" fn on_receive() {
    INTERRUPT.write(INTERRUPT_RX);
    critical_section::with(|section| {
        let mut handlers = HANDLERS.borrow_ref_mut(section);
        let Some(handlers) = handlers.as_mut() else { return };
        CONTROL.write(ENABLE_ALL);
        while STATE.read() & RX_FULL != 0 {
            if RX_LOST.load(Ordering::Relaxed) {
                DATA.read();
            } else if handlers.received.ready() {
                let _ = handlers.received.enqueue(DATA.read() as u8);
            } else {
                CONTROL.write(ENABLE_ALL & !RECEIVE_INTERRUPT);
                break;
            }
        }
        if STATE.read() & RX_OVERRUN != 0 {
            STATE.write(RX_OVERRUN);
            RX_LOST.store(true, Ordering::Relaxed);
        }
    });
}

/// The handler of the transmit interrupt, and what starts a transmission.
pub extern "C" fn on_transmit() {
    INTERRUPT.write(INTERRUPT_TX);
    critical_section::with(|section| {
        let mut handlers = HANDLERS.borrow_ref_mut(section);
        let Some(handlers) = handlers.as_mut() else { return };
        while STATE.read() & TX_FULL == 0 {
            let Some(byte) = handlers.to_send.dequeue() else { return };
            DATA.write(u32::from(byte));
        }
    });
}

/// The console. There is one: [`super::Board::take`] makes it.
pub struct Uart {
    received: Consumer<'static, u8>,
    outgoing: Outgoing,
}

impl Uart {
    /// Sets the port up. `None` if it already is.
    pub(super) fn new() -> Option<Self> {
        let rx = cortex_m::singleton!(: Queue<u8, RX_BYTES> = Queue::new())?;
        let tx = cortex_m::singleton!(: Queue<u8, TX_BYTES> = Queue::new())?;
        let (rx_in, rx_out) = rx.split();
        let (tx_in, tx_out) = tx.split();
        critical_section::with(|section| {
            HANDLERS.borrow(section).replace(Some(Handlers { received: rx_in, to_send: tx_out }));
        });
        BAUD_DIVIDER.write(25_000_000 / 115_200);
        CONTROL.write(ENABLE_ALL);
        let outgoing = Outgoing::new(tx_in, STALL_LIMIT_US * time::TICKS_PER_US);
        Some(Self { received: rx_out, outgoing })
    }

    /// The next byte received; [`LOST`] where some are missing.
    pub fn read(&mut self) -> Option<u8> {
        if let Some(byte) = self.received.dequeue() {
            return Some(byte);
        }
        if RX_LOST.swap(false, Ordering::Relaxed) {
            return Some(LOST);
        }
        on_receive();
        self.received.dequeue()
    }

    /// Whether [`Self::read`] has something to give.
    pub fn has_input(&self) -> bool {
        self.received.ready() || RX_LOST.load(Ordering::Relaxed) || STATE.read() & RX_FULL != 0
    }
}

impl core::fmt::Write for Uart {
    /// Queues the text. It never fails and never waits: text that the other end does not take is lost, whole lines of it.
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        self.outgoing.put(text);
        on_transmit();
        Ok(())
    }
}

impl Output for Uart {
    fn takes(&self, bytes: usize) -> bool {
        self.outgoing.takes(bytes, time::counter())
    }
}

/// Answers each line with `text` for ever, without interrupts and without memory.
pub fn last_words(text: &str) -> ! {
    BAUD_DIVIDER.write(25_000_000 / 115_200);
    CONTROL.write(0b11);
    let mut is_empty = true;
    loop {
        if STATE.read() & RX_FULL == 0 {
            continue;
        }
        let byte = DATA.read() as u8;
        if byte == b'\n' && !is_empty {
            for byte in text.bytes().chain(*b"\n") {
                while STATE.read() & TX_FULL != 0 {}
                DATA.write(u32::from(byte));
            }
        }
        is_empty = byte == b'\n' || (is_empty && byte == b'\r');
    }
}
