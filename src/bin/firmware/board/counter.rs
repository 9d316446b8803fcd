//! Time on a chip that has a counter of 32 bits: microseconds since start, and two alarms on one interrupt.

use super::sampler::{Ground, Seat};
use core::cell::Cell;
use core::marker::PhantomData;
use critical_section::Mutex;
use ironout::clock::Extended;

/// The longest sleep: the watchdog is told of every turn, and wants one now and then.
const LONGEST_SLEEP_US: u64 = 1_000_000;

/// An alarm of the counter.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Alarm {
    /// The sampler's.
    Sampler,
    /// The one that ends the sleep of the loop.
    Sleep,
}

/// The counter's registers. It runs at 1 MHz through all 32 bits.
pub trait Counter: 'static {
    /// How it stands.
    fn count() -> u32;
    /// Makes an alarm interrupt when the counter stands there.
    fn set(alarm: Alarm, at: u32);
    /// Takes note of both alarms.
    fn acknowledge();
    /// Makes the interrupt come now.
    fn pend();
}

/// The counter with its wraps. It wraps after 71 minutes, and the sampler's interrupt alone reads it ten times a second.
static EXTENDED: Mutex<Cell<Extended>> = Mutex::new(Cell::new(Extended::new()));

/// When the sampler is due.
static DUE_US: Mutex<Cell<u64>> = Mutex::new(Cell::new(u64::MAX));

/// Microseconds since start.
// Asked at two dozen places, and not in a hurry at any.
#[inline(never)]
pub fn now_us<C: Counter>() -> u64 {
    critical_section::with(|section| {
        let mut extended = EXTENDED.borrow(section).get();
        let now_us = extended.at(C::count());
        EXTENDED.borrow(section).set(extended);
        now_us
    })
}

/// Makes the sampler's interrupt come then, at once where that is past.
pub fn set_sampler<C: Counter>(at_us: u64) {
    critical_section::with(|section| DUE_US.borrow(section).set(at_us));
    C::set(Alarm::Sampler, at_us as u32);
    if now_us::<C>() >= at_us {
        // The alarm may have missed it.
        C::pend();
    }
}

/// The interrupt: of either alarm, or pended.
pub fn interrupt<C: Counter, G: Ground>(seat: &Seat<G>) {
    C::acknowledge();
    let is_due = critical_section::with(|section| {
        let due_us = DUE_US.borrow(section);
        let is_due = due_us.get() <= now_us::<C>();
        if is_due {
            due_us.set(u64::MAX);
        }
        is_due
    });
    if is_due {
        seat.interrupt();
    }
}

/// The clock.
pub struct Clock<C>(PhantomData<C>);

impl<C: Counter> Clock<C> {
    /// Of a counter that runs.
    pub const fn new() -> Self {
        Self(PhantomData)
    }

    /// Microseconds since start.
    pub fn now_us(&self) -> u64 {
        now_us::<C>()
    }

    /// Sleeps until `deadline_ms` or any interrupt (a byte, room for one, a sample). Not at all where `awake` says so, which is
    /// asked with interrupts held back: one that comes after the question ends the sleep.
    pub fn sleep_until_ms(&mut self, deadline_ms: u64, awake: impl FnOnce() -> bool) {
        let now_us = now_us::<C>();
        let end_us = deadline_ms.saturating_mul(1000).min(now_us + LONGEST_SLEEP_US);
        if end_us <= now_us {
            return;
        }
        C::set(Alarm::Sleep, end_us as u32);
        critical_section::with(|_| {
            if !awake() && self::now_us::<C>() < end_us {
                cortex_m::asm::wfi();
            }
        });
    }
}

/// embassy's time, which its buses take for their limits, is the same count. Nobody waits for it: there is no executor.
pub struct Time<C>(pub PhantomData<C>);

impl<C: Counter + Send + Sync> embassy_time_driver::Driver for Time<C> {
    fn now(&self) -> u64 {
        now_us::<C>()
    }

    /// Woken at once: whoever waits looks again.
    fn schedule_wake(&self, _at: u64, waker: &core::task::Waker) {
        waker.wake_by_ref();
    }
}
