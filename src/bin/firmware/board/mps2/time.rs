//! The board's clock: a free-running 25 MHz counter, and a timer that wakes the processor when something is due.

use super::registers::Register;
use core::cell::Cell;
use critical_section::Mutex;

/// Ticks of the counter in a microsecond.
pub const TICKS_PER_US: u32 = 25;

/// The longest sleep. It bounds what a lost interrupt costs, and the counter is read far more often than it wraps.
const LONGEST_SLEEP_US: u64 = 1_000_000;

// SAFETY: the FPGA's free-running counter on the AN386 image, read only.
const COUNTER: Register = unsafe { Register::new(0x4002_8000, 0x18) };

const TIMER0: usize = 0x4000_0000;
// SAFETY: the registers of CMSDK timer 0; they touch no memory.
const CONTROL: Register = unsafe { Register::new(TIMER0, 0x0) };
// SAFETY: as above.
const VALUE: Register = unsafe { Register::new(TIMER0, 0x4) };
// SAFETY: as above.
const RELOAD: Register = unsafe { Register::new(TIMER0, 0x8) };
// SAFETY: as above.
const INTERRUPT: Register = unsafe { Register::new(TIMER0, 0xC) };
const ENABLE: u32 = 1 << 0;
const INTERRUPT_ENABLE: u32 = 1 << 3;

/// The counter's last reading and the ticks counted until then. The counter wraps after 171 s; it is read after every sleep,
/// so no wrap is ever missed.
static EXTENDED: Mutex<Cell<(u32, u64)>> = Mutex::new(Cell::new((0, 0)));

/// The counter as it stands, for short intervals.
#[inline]
pub fn counter() -> u32 {
    COUNTER.read()
}

/// Ticks since [`Clock::new`].
fn ticks() -> u64 {
    critical_section::with(|section| {
        let (last, total) = EXTENDED.borrow(section).get();
        let now = counter();
        let total = total + u64::from(now.wrapping_sub(last));
        EXTENDED.borrow(section).set((now, total));
        total
    })
}

/// The handler of timer 0's interrupt.
pub extern "C" fn on_timer0() {
    INTERRUPT.write(1);
    CONTROL.write(0);
}

/// The clock. There is one: [`super::Board::take`] makes it.
pub struct Clock(());

impl Clock {
    /// Starts the count.
    pub(super) fn new() -> Self {
        critical_section::with(|section| EXTENDED.borrow(section).set((counter(), 0)));
        CONTROL.write(0);
        INTERRUPT.write(1);
        Self(())
    }

    /// Microseconds since start.
    pub fn now_us(&self) -> u64 {
        ticks() / u64::from(TICKS_PER_US)
    }

    /// Sleeps until `deadline_ms` or any interrupt (a byte, room for one). Not at all where `awake` says so, which is asked with
    /// interrupts held back: one that comes after the question ends the sleep.
    pub fn sleep_until_ms(&mut self, deadline_ms: u64, awake: impl FnOnce() -> bool) {
        let now_us = self.now_us();
        let end_us = deadline_ms.saturating_mul(1000).min(now_us + LONGEST_SLEEP_US);
        if end_us <= now_us {
            return;
        }
        let ticks = (end_us - now_us) as u32 * TICKS_PER_US;
        RELOAD.write(ticks);
        VALUE.write(ticks);
        CONTROL.write(ENABLE | INTERRUPT_ENABLE);
        // The timer may have come and gone before this: then nothing else would end the sleep.
        critical_section::with(|_| {
            if !awake() && self.now_us() < end_us {
                cortex_m::asm::wfi();
            }
        });
        CONTROL.write(0);
        INTERRUPT.write(1);
    }
}

/// Waits by counting.
pub struct Delay;

impl embedded_hal::delay::DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        let (start, ticks) = (counter(), ns.div_ceil(1000).saturating_mul(TICKS_PER_US));
        while counter().wrapping_sub(start) < ticks {}
    }
}
