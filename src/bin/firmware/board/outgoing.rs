//! What the console sends, on its way to a port: a queue that never makes the firmware wait, whatever the other end does.

use core::cell::Cell;
use heapless::spsc::Producer;

/// Whether the other end takes what is sent.
#[derive(PartialEq, Eq)]
enum Flow {
    /// It does.
    Open,
    /// It took nothing for the stall limit: text is dropped until all that was queued has gone.
    Stalled,
    /// It takes again; the rest of the line that was cut is still dropped, so that what follows is whole.
    SkippingLine,
}

/// The near end of the queue; a port's interrupt or task has the far end.
pub struct Outgoing {
    queue: Producer<'static, u8>,
    flow: Flow,
    /// Bytes that were queued since the start, wrapping.
    queued: u32,
    /// How many of them had gone when that was last seen to change, and when that was.
    progress: Cell<(u32, u32)>,
    /// How long text may stay where it is. A terminal that stopped reading for longer must not keep commands waiting.
    stall_limit: u32,
}

impl Outgoing {
    /// Into this queue; times are counts of any clock that wraps at 32 bits.
    pub fn new(queue: Producer<'static, u8>, stall_limit: u32) -> Self {
        Self { queue, flow: Flow::Open, queued: 0, progress: Cell::new((0, 0)), stall_limit }
    }

    /// Queues the text. Where the other end does not take it, whole lines of it are lost.
    pub fn put(&mut self, text: &str) {
        for byte in text.bytes() {
            self.put_byte(byte);
        }
    }

    /// Whether so many bytes may be put. A terminal that has stopped reading takes everything: it is lost.
    pub fn takes(&self, bytes: usize, now: u32) -> bool {
        self.queue.capacity() - self.queue.len() >= bytes || self.flow != Flow::Open || self.is_stuck(now)
    }

    /// Whether nothing has gone for the stall limit, though something waits.
    fn is_stuck(&self, now: u32) -> bool {
        let waiting = self.queue.len();
        let gone = self.queued.wrapping_sub(waiting as u32);
        let (gone_before, since) = self.progress.get();
        if gone != gone_before || waiting == 0 {
            self.progress.set((gone, now));
            return false;
        }
        now.wrapping_sub(since) > self.stall_limit
    }

    fn enqueue(&mut self, byte: u8) -> bool {
        let is_queued = self.queue.enqueue(byte).is_ok();
        self.queued = self.queued.wrapping_add(u32::from(is_queued));
        is_queued
    }

    fn put_byte(&mut self, byte: u8) {
        match self.flow {
            Flow::Open => {
                if !self.enqueue(byte) {
                    self.flow = Flow::Stalled;
                }
            }
            Flow::Stalled if !self.queue.is_empty() => {}
            Flow::Stalled | Flow::SkippingLine => {
                self.flow = if byte == b'\n' { Flow::Open } else { Flow::SkippingLine };
                // The cut line gets an end of its own, so that the next one begins a line.
                if self.flow == Flow::Open {
                    let _ = self.enqueue(byte);
                }
            }
        }
    }
}
