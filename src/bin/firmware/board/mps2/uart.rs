//! The console: CMSDK UART 0, 115200 baud, with a ring buffer in each direction behind interrupts.

use super::registers::Register;
use super::time;
use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use heapless::spsc::{Consumer, Producer, Queue};

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
/// Holds the longest reply, so that printing it does not hold up the samples.
const TX_BYTES: usize = 2048;

/// How long text waits for room. A terminal that stopped reading must not stop the board.
const WRITE_LIMIT_US: u32 = 200_000;

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
    to_send: Producer<'static, u8>,
    flow: Flow,
}

/// Whether the other end takes what is sent.
#[derive(PartialEq, Eq)]
enum Flow {
    /// It does.
    Open,
    /// It took nothing for [`WRITE_LIMIT_US`]: text is dropped until all that was queued has gone.
    Stalled,
    /// It takes again; the rest of the line that was cut is still dropped, so that what follows is whole.
    SkippingLine,
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
        Some(Self { received: rx_out, to_send: tx_in, flow: Flow::Open })
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

    /// Queues a byte, waiting for room if need be.
    fn put(&mut self, byte: u8) {
        match self.flow {
            Flow::Open => {}
            Flow::Stalled if !self.to_send.is_empty() => return,
            Flow::Stalled | Flow::SkippingLine => {
                self.flow = if byte == b'\n' { Flow::Open } else { Flow::SkippingLine };
                // The cut line gets an end of its own, so that the next one begins a line.
                if self.flow == Flow::Open {
                    let _ = self.to_send.enqueue(byte);
                }
                return;
            }
        }
        let since = time::counter();
        while self.to_send.enqueue(byte).is_err() {
            on_transmit();
            if time::counter().wrapping_sub(since) > WRITE_LIMIT_US * time::TICKS_PER_US {
                self.flow = Flow::Stalled;
                return;
            }
        }
    }
}

impl core::fmt::Write for Uart {
    /// Queues the text. It never fails: text that the other end does not take is lost, whole lines of it.
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for byte in text.bytes() {
            self.put(byte);
        }
        on_transmit();
        Ok(())
    }
}
