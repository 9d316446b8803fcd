//! A serial port, 115200 8N1, with a ring buffer in each direction behind its interrupt: what is the same on every chip.

use super::outgoing::Outgoing;
use core::cell::RefCell;
use core::fmt;
use core::marker::PhantomData;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use heapless::spsc::{Consumer, Producer, Queue};
use ironout::device::{MAX_REPLY_BYTES, Output};

/// What arrives at full speed in 90 ms. A solve may take longer: bytes that find no room are marked as lost, and the line they
/// belonged to is refused.
const RX_BYTES: usize = 1024;
/// Holds the longest reply and some lines of a stream.
const TX_BYTES: usize = MAX_REPLY_BYTES + 256;

/// How long text may stay where it is, µs. A terminal that stopped reading for longer must not keep commands waiting.
pub const STALL_LIMIT_US: u32 = 200_000;

/// Stands in for bytes that were lost. The console refuses a line that holds it, so that a command with a hole in it is
/// never carried out as another one.
const LOST: u8 = 0xFF;

/// The port's registers, and the clock.
pub trait Registers: 'static {
    /// Takes note of the interrupt.
    fn acknowledge();
    /// The next byte that came, if one did: `Err` for one that is none, or behind which some were lost.
    fn receive() -> Option<Result<u8, ()>>;
    /// Whether the port takes a byte now.
    fn has_room() -> bool;
    /// Sends one; it has room.
    fn send(byte: u8);
    /// Whether an interrupt is wanted when there is room: there is something to send. Nothing on a port whose interrupt comes once.
    fn wants_room(_wanted: bool) {}
    /// Microseconds since start, wrapping.
    fn now_us() -> u32;
}

/// The handler's ends of the buffers.
struct Handler {
    received: Producer<'static, u8>,
    to_send: Consumer<'static, u8>,
}

static HANDLER: Mutex<RefCell<Option<Handler>>> = Mutex::new(RefCell::new(None));

/// Bytes were lost after those in the buffer. While it is set nothing more is buffered, so that the place of the loss
/// is known.
static RX_LOST: AtomicBool = AtomicBool::new(false);

/// The interrupt's handler, and what starts a transmission: empties the port into its buffer and fills it from the other, as far as
/// either goes.
pub fn move_bytes<R: Registers>() {
    critical_section::with(|section| {
        let mut handler = HANDLER.borrow_ref_mut(section);
        let Some(handler) = handler.as_mut() else { return };
        R::acknowledge();
        while let Some(received) = R::receive() {
            let Ok(byte) = received else {
                RX_LOST.store(true, Ordering::Relaxed);
                continue;
            };
            if !handler.received.ready() {
                RX_LOST.store(true, Ordering::Relaxed);
            }
            if !RX_LOST.load(Ordering::Relaxed) {
                let _ = handler.received.enqueue(byte);
            }
        }
        while R::has_room() {
            let Some(byte) = handler.to_send.dequeue() else { return R::wants_room(false) };
            R::send(byte);
        }
        R::wants_room(true);
    });
}

/// The port.
pub struct Port<R> {
    received: Consumer<'static, u8>,
    outgoing: Outgoing,
    registers: PhantomData<R>,
}

impl<R: Registers> Port<R> {
    /// The buffers of a port that is set up; its interrupt may come from now on. `None` at the second call.
    pub fn new() -> Option<Self> {
        let rx_buffer = cortex_m::singleton!(: Queue<u8, RX_BYTES> = Queue::new())?;
        let tx_buffer = cortex_m::singleton!(: Queue<u8, TX_BYTES> = Queue::new())?;
        let (rx_in, rx_out) = rx_buffer.split();
        let (tx_in, tx_out) = tx_buffer.split();
        critical_section::with(|section| {
            HANDLER.borrow(section).replace(Some(Handler { received: rx_in, to_send: tx_out }));
        });
        let outgoing = Outgoing::new(tx_in, STALL_LIMIT_US);
        Some(Self { received: rx_out, outgoing, registers: PhantomData })
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
}

impl<R: Registers> fmt::Write for Port<R> {
    /// Queues the text. It never fails and never waits: text that the other end does not take is lost, whole lines of it.
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.outgoing.put(text);
        move_bytes::<R>();
        Ok(())
    }
}

impl<R: Registers> Output for Port<R> {
    fn takes(&self, bytes: usize) -> bool {
        self.outgoing.takes(bytes, R::now_us())
    }
}

/// Answers each line with `text` for ever, on a port that is set up, without interrupts and without memory; `feed` keeps a watchdog
/// quiet.
pub fn last_words<R: Registers>(text: &str, feed: fn()) -> ! {
    let mut is_empty = true;
    loop {
        feed();
        R::acknowledge();
        let Some(Ok(byte)) = R::receive() else { continue };
        if byte == b'\n' && !is_empty {
            for byte in text.bytes().chain(*b"\n") {
                while !R::has_room() {
                    R::acknowledge();
                }
                R::send(byte);
            }
        }
        is_empty = byte == b'\n' || (is_empty && byte == b'\r');
    }
}
