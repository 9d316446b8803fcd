//! Time: the RP2040's 64-bit count of microseconds, and its alarms.
//!
//! Alarm 0 is embassy-time's, alarm 1 the sampler's, alarm 3 ends the sleep of the loop.

use embassy_rp::interrupt;
use embassy_rp::interrupt::InterruptExt;
use embassy_rp::pac;
use embassy_time::Instant;

/// The alarm that ends a sleep.
const SLEEP_ALARM: usize = 3;

/// The longest sleep: the watchdog is told of every turn, and wants one now and then.
const LONGEST_SLEEP_US: u64 = 1_000_000;

/// Microseconds since start.
pub fn now_us() -> u64 {
    Instant::now().as_micros()
}

/// An alarm of the timer.
#[derive(Clone, Copy)]
pub struct Alarm(pub usize);

impl Alarm {
    /// Makes it interrupt at `at_us`, at once where that is past.
    pub fn set(self, at_us: u64) {
        let Self(n) = self;
        pac::TIMER.inte().modify(|w| w.set_alarm(n, true));
        // The alarm compares the lower 32 bits: enough for every deadline within 71 minutes.
        pac::TIMER.alarm(n).write_value(at_us as u32);
        if now_us() >= at_us {
            // It may have been missed.
            pac::TIMER.intf().modify(|w| w.set_alarm(n, true));
        }
    }

    /// Takes note that it has interrupted.
    pub fn clear(self) {
        let Self(n) = self;
        pac::TIMER.intf().modify(|w| w.set_alarm(n, false));
        pac::TIMER.intr().write(|w| w.set_alarm(n, true));
    }
}

#[interrupt]
fn TIMER_IRQ_3() {
    Alarm(SLEEP_ALARM).clear();
}

/// The clock. There is one: [`super::Board::take`] makes it.
pub struct Clock(());

impl Clock {
    pub(super) fn new() -> Self {
        // SAFETY: its handler is above, and no critical section relies on masks.
        unsafe { interrupt::TIMER_IRQ_3.enable() };
        Self(())
    }

    /// Microseconds since start.
    pub fn now_us(&self) -> u64 {
        now_us()
    }

    /// Sleeps until `deadline_ms` or any interrupt (a byte, room for one, a sample). Not at all where `awake` says so, which is
    /// asked with interrupts held back: one that comes after the question ends the sleep.
    pub fn sleep_until_ms(&mut self, deadline_ms: u64, awake: impl FnOnce() -> bool) {
        let now_us = now_us();
        let end_us = deadline_ms.saturating_mul(1000).min(now_us + LONGEST_SLEEP_US);
        if end_us <= now_us {
            return;
        }
        Alarm(SLEEP_ALARM).set(end_us);
        // The alarm may have come and gone before this: then nothing else would end the sleep.
        critical_section::with(|_| {
            if !awake() && self::now_us() < end_us {
                cortex_m::asm::wfi();
            }
        });
    }
}
