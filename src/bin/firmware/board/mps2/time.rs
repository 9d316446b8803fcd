//! The board's clock: a free-running 25 MHz counter, and a timer that says when to sample.

use super::registers::Register;
use core::cell::Cell;
use core::sync::atomic::{AtomicU32, Ordering};
use critical_section::Mutex;
use embedded_hal::delay::DelayNs;

/// Ticks of the counter in a microsecond.
pub const TICKS_PER_US: u32 = 25;

/// Samples a second.
const SAMPLE_RATE_HZ: u32 = 50;
const TICKS_PER_SAMPLE: u32 = TICKS_PER_US * 1_000_000 / SAMPLE_RATE_HZ;

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

/// Sample periods since start; wraps after 2.7 years, and only differences are used.
static PERIODS: AtomicU32 = AtomicU32::new(0);

/// The counter's last reading and the ticks counted until then. The counter wraps after 171 s; the timer's handler
/// reads it 50 times a second, so no wrap is ever missed.
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
    PERIODS.fetch_add(1, Ordering::Relaxed);
    ticks();
}

/// The clock. There is one: [`super::Board::take`] makes it.
pub struct Clock {
    sampled: u32,
}

impl Clock {
    /// Starts the sample timer.
    pub(super) fn new() -> Self {
        critical_section::with(|section| EXTENDED.borrow(section).set((counter(), 0)));
        RELOAD.write(TICKS_PER_SAMPLE - 1);
        VALUE.write(TICKS_PER_SAMPLE - 1);
        INTERRUPT.write(1);
        CONTROL.write(ENABLE | INTERRUPT_ENABLE);
        Self { sampled: 0 }
    }

    /// Milliseconds since start; wraps after 49 days.
    pub fn now_ms(&self) -> u32 {
        (ticks() / u64::from(1_000 * TICKS_PER_US)) as u32
    }

    /// Whether a sample is due. Periods that passed unseen, during a long solve, are not made up for: old samples
    /// cannot be taken any more. `missed` says how many there were.
    pub fn sample_due(&mut self) -> Option<Due> {
        let periods = PERIODS.load(Ordering::Relaxed).wrapping_sub(self.sampled);
        if periods == 0 {
            return None;
        }
        self.sampled = self.sampled.wrapping_add(periods);
        Some(Due { missed: periods - 1 })
    }
}

/// A sample is due.
pub struct Due {
    /// Sample periods that passed without a sample since the last one.
    pub missed: u32,
}

/// A busy wait on the counter.
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        let ticks = ns.div_ceil(1_000 / TICKS_PER_US);
        let start = counter();
        while counter().wrapping_sub(start) < ticks {}
    }
}
