//! The board's clock: a free-running 25 MHz counter, and a timer that wakes the processor every millisecond.

use super::registers::Register;
use core::cell::Cell;
use critical_section::Mutex;

/// Ticks of the counter in a microsecond.
pub const TICKS_PER_US: u32 = 25;

/// The timer's period: the resolution with which a sample is on time.
const TICKS_PER_WAKE: u32 = TICKS_PER_US * 1_000;

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

/// The counter's last reading and the ticks counted until then. The counter wraps after 171 s; the timer's handler
/// reads it every millisecond, so no wrap is ever missed.
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
    ticks();
}

/// The clock. There is one: [`super::Board::take`] makes it.
pub struct Clock(());

impl Clock {
    /// Starts the timer.
    pub(super) fn new() -> Self {
        critical_section::with(|section| EXTENDED.borrow(section).set((counter(), 0)));
        RELOAD.write(TICKS_PER_WAKE - 1);
        VALUE.write(TICKS_PER_WAKE - 1);
        INTERRUPT.write(1);
        CONTROL.write(ENABLE | INTERRUPT_ENABLE);
        Self(())
    }

    /// Milliseconds since start.
    pub fn now_ms(&self) -> u64 {
        ticks() / u64::from(1_000 * TICKS_PER_US)
    }
}
