//! What a panic or a hard fault leaves behind.
//!
//! Both write a trace into memory that start-up does not touch, and restart the board: a compass that answers again
//! after some milliseconds is worth more than one that stands still, and the trace says afterwards what happened. The
//! console shows it (`version`), and so does the log at the next start. Nothing is
//! logged from inside a handler: the fault may have happened in the logger.
//!
//! A fault soon after the start, again and again, is one that restarting does not mend: after [`STUCK_AFTER`] of them the board
//! starts without touching sensor and store and answers the console, and where even that fails, after [`WAIT_AFTER`], it
//! does not restart any more and only says so.

use core::fmt::Write;
use core::panic::PanicInfo;
use heapless::String;

/// Marks a trace that was written, rather than what memory holds after power-up.
const MAGIC: u32 = 0x6661_756c;

/// Bytes of a panic's place and message that are kept.
const MESSAGE_BYTES: usize = 120;

/// A start that lived this long has not failed.
pub const STARTED_MS: u64 = 1_000;

/// Starts in a row that failed before sensor and store are left alone …
const STUCK_AFTER: u32 = 5;
/// … and before the board is not restarted any more.
const WAIT_AFTER: u32 = 8;

/// The trace in words.
type Text = String<200>;

/// The trace as it lies in memory.
#[repr(C)]
#[derive(Clone, Copy)]
struct Trace {
    magic: u32,
    /// Faults since power-up.
    count: u32,
    /// Of those, the last ones in a row that came soon after the start.
    at_start: u32,
    kind: u32,
    /// Where it happened, and the return address there.
    pc: u32,
    lr: u32,
    /// SCB's configurable fault status, and the address of a precise bus fault (0 for any other).
    cfsr: u32,
    address: u32,
    message_len: u32,
    message: [u8; MESSAGE_BYTES],
    /// Over all of the above.
    check: u32,
}

impl Trace {
    /// The same, as one fault more.
    fn counted(self) -> Self {
        let (count, at_start) = (self.count.wrapping_add(1).max(1), self.at_start.saturating_add(1));
        Self { magic: MAGIC, count, at_start, ..self }
    }
}

/// The bit of CFSR that says that BFAR holds the faulting address.
#[cfg(not(armv6m))]
const BFAR_VALID: u32 = 1 << 15;

const KIND_PANIC: u32 = 1;
const KIND_HARD_FAULT: u32 = 2;
const KIND_STACK_OVERFLOW: u32 = 3;
const KIND_HUNG: u32 = 4;

unsafe extern "C" {
    /// The start of the region that the memory map keeps for the trace.
    static mut _fault_trace: Trace;
}

// The region holds 256 bytes (build.rs).
const _: () = assert!(size_of::<Trace>() <= 256);

/// The trace in words of the processor.
const WORDS: usize = size_of::<Trace>() / 4;

/// The restarts after a fault, since power-up.
pub struct Restarts {
    /// How many there were.
    pub count: u32,
    /// What the last fault was, in words; empty if there was none.
    pub last: &'static str,
    /// Starts in a row that failed.
    at_start: u32,
}

impl Restarts {
    /// Whether restarting has not mended the fault.
    pub const fn is_stuck(&self) -> bool {
        self.at_start >= STUCK_AFTER
    }

    /// Reads the trace. To be called once: the second call has no room for the words any more.
    pub fn read() -> Self {
        let mut trace = load();
        if crate::board::was_hung() {
            trace = Trace { kind: KIND_HUNG, pc: 0, lr: 0, cfsr: 0, address: 0, message_len: 0, ..trace }
                .counted();
            store(trace);
        }
        if trace.count == 0 {
            return Self { count: 0, last: "", at_start: 0 };
        }
        let Some(last) = cortex_m::singleton!(: Text = Text::new()) else {
            return Self { count: trace.count, last: "", at_start: trace.at_start };
        };
        // A text longer than the buffer is cut; there is nothing better to do with it.
        let _ = describe(&trace, last);
        Self { count: trace.count, last: last.as_str(), at_start: trace.at_start }
    }
}

fn describe(trace: &Trace, out: &mut Text) -> core::fmt::Result {
    match trace.kind {
        KIND_PANIC => {
            let bytes = trace.message.get(..trace.message_len as usize).unwrap_or(&trace.message);
            write!(out, "panic at {}", core::str::from_utf8(bytes).unwrap_or("?"))
        }
        KIND_HUNG => write!(out, "watchdog: the firmware stopped responding"),
        KIND_STACK_OVERFLOW => write!(out, "stack overflow cfsr={:#010x}", trace.cfsr),
        _ => {
            write!(out, "hard fault pc={:#010x} lr={:#010x} cfsr={:#010x}", trace.pc, trace.lr, trace.cfsr)?;
            write!(out, " address={:#010x}", trace.address)
        }
    }
}

/// The trace in memory, or an empty one if none was written since power-up.
// Read and written word by word in a loop: all of it at once the compiler writes out, a kilobyte of code.
#[inline(never)]
fn load() -> Trace {
    let mut words = [0; WORDS];
    for (at, word) in words.iter_mut().enumerate() {
        // SAFETY: the region is there, aligned and large enough, and the only writer is a fault handler, which never returns.
        *word = unsafe { (&raw const _fault_trace).cast::<u32>().add(at).read_volatile() };
    }
    // SAFETY: of the same size, and any bytes are a valid `Trace`.
    let trace = unsafe { core::mem::transmute::<[u32; WORDS], Trace>(words) };
    if trace.magic == MAGIC && trace.check == checksum(&trace) {
        return trace;
    }
    Trace {
        magic: MAGIC,
        count: 0,
        at_start: 0,
        kind: 0,
        pc: 0,
        lr: 0,
        cfsr: 0,
        address: 0,
        message_len: 0,
        message: [0; MESSAGE_BYTES],
        check: 0,
    }
}

/// Stores the trace as one fault more, and restarts the board.
fn store_and_restart(trace: Trace) -> ! {
    let trace = trace.counted();
    store(trace);
    if trace.at_start >= WAIT_AFTER {
        crate::board::last_words(
            "err busy the firmware fails at every start and has stopped: switch the power off and on",
        );
    }
    crate::board::restart()
}

#[inline(never)]
fn store(mut trace: Trace) {
    trace.check = checksum(&trace);
    // SAFETY: of the same size, without padding.
    let words = unsafe { core::mem::transmute::<Trace, [u32; WORDS]>(trace) };
    for (at, word) in words.into_iter().enumerate() {
        // SAFETY: the region is ours, aligned and large enough. Its other writers are fault handlers, which never return, and
        // `started`, which a handler may only replace whole.
        unsafe { (&raw mut _fault_trace).cast::<u32>().add(at).write_volatile(word) };
    }
}

/// Takes note that this start has lived for [`STARTED_MS`].
pub fn started() {
    let trace = load();
    if trace.at_start > 0 {
        store(Trace { at_start: 0, ..trace });
    }
}

/// FNV-1a over everything but the checksum.
fn checksum(trace: &Trace) -> u32 {
    let words = [
        trace.magic,
        trace.count,
        trace.at_start,
        trace.kind,
        trace.pc,
        trace.lr,
        trace.cfsr,
        trace.address,
        trace.message_len,
    ];
    words
        .iter()
        .flat_map(|word| word.to_le_bytes())
        .chain(trace.message)
        .fold(0x811c_9dc5, |hash: u32, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

/// Collects text into the trace, and lets the rest go when it is full.
struct Message<'a>(&'a mut Trace);

impl Write for Message<'_> {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for byte in text.bytes() {
            let at = self.0.message_len as usize;
            let Some(slot) = self.0.message.get_mut(at) else { break };
            // The console shows the text: what it would refuse itself is not put there.
            *slot = if matches!(byte, 0x20..=0x7e) { byte } else { b'?' };
            self.0.message_len += 1;
        }
        Ok(())
    }
}

#[panic_handler]
fn on_panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    let mut trace = Trace { kind: KIND_PANIC, pc: 0, lr: 0, cfsr: 0, address: 0, message_len: 0, ..load() };
    trace.message = [0; MESSAGE_BYTES];
    let mut message = Message(&mut trace);
    if let Some(place) = info.location() {
        let _ = write!(message, "{}:{}: ", place.file(), place.line());
    }
    let _ = write!(message, "{}", info.message());
    store_and_restart(trace)
}

// The entry of the hard fault. Written by hand because the stack may be what failed: on an overflow the stack pointer is
// below the stack, where a compiled function's first push would lock the core up. The pointer at the time of the fault is
// handed over, and the handler gets a fresh stack in place of one with less than 1 KiB left.
core::arch::global_asm!(
    ".section .HardFault.entry, \"ax\"
     .global HardFault
     .type HardFault,%function
     .thumb_func
     HardFault:
     mov r0, sp
     ldr r1, =_stack_end + 1024
     cmp r0, r1
     bhs 1f
     ldr r1, =_stack_start
     msr msp, r1
     1:
     ldr r1, ={handler}
     bx r1
     .size HardFault, . - HardFault
     .pool
     .previous",
    handler = sym on_hard_fault,
);

/// The second half of the handler: `stack` is the stack pointer at the fault's entry.
extern "C" fn on_hard_fault(stack: u32) -> ! {
    unsafe extern "C" {
        static _stack_start: u32;
        static _stack_end: u32;
    }
    let (bottom, top) = ((&raw const _stack_end) as u32, (&raw const _stack_start) as u32);
    // The exception frame: r0–r3, r12, lr, pc, xPSR. It is there only if the pointer lies in the stack.
    let frame = |word: u32| {
        let address = stack.wrapping_add(4 * word);
        if address < bottom || address >= top {
            return 0;
        }
        // SAFETY: an aligned word inside the stack.
        unsafe { (address as *const u32).read_volatile() }
    };
    let (cfsr, address) = fault_status();
    let trace = Trace {
        kind: if stack < bottom { KIND_STACK_OVERFLOW } else { KIND_HARD_FAULT },
        pc: frame(6),
        lr: frame(5),
        cfsr,
        address,
        message_len: 0,
        message: [0; MESSAGE_BYTES],
        ..load()
    };
    store_and_restart(trace)
}

/// The configurable fault status, and the address of a precise bus fault.
#[cfg(not(armv6m))]
fn fault_status() -> (u32, u32) {
    // SAFETY: reading the fault registers has no side effect, and nothing else runs.
    let scb = unsafe { &*cortex_m::peripheral::SCB::PTR };
    let cfsr = scb.cfsr.read();
    (cfsr, if cfsr & BFAR_VALID != 0 { scb.bfar.read() } else { 0 })
}

/// The ARMv6-M has no such registers.
#[cfg(armv6m)]
const fn fault_status() -> (u32, u32) {
    (0, 0)
}

/// An interrupt or exception that nobody expects is a fault of the program.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(number: i16) {
    panic!("unexpected interrupt {}", number);
}
