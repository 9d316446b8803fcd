//! Time: TIM2, 32 bits at 1 MHz.

use crate::board::counter::{self, Alarm, Counter};
use core::marker::PhantomData;
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::InterruptExt;
use embassy_stm32::pac;
use embassy_stm32::peripherals::TIM2;
use embassy_stm32::{Peri, rcc};

const TIMER: pac::timer::TimGp32 = pac::TIM2;

/// The timer.
pub struct Tim2;

/// The clock.
pub type Clock = counter::Clock<Tim2>;

embassy_time_driver::time_driver_impl!(static TIME: counter::Time<Tim2> = counter::Time(PhantomData));

const fn channel(alarm: Alarm) -> usize {
    match alarm {
        Alarm::Sampler => 0,
        Alarm::Sleep => 1,
    }
}

impl Counter for Tim2 {
    fn count() -> u32 {
        TIMER.cnt().read()
    }

    fn set(alarm: Alarm, at: u32) {
        TIMER.ccr(channel(alarm)).write_value(at);
    }

    fn acknowledge() {
        // Zeros clear, ones leave alone.
        TIMER.sr().write(|w| {
            w.0 = u32::MAX;
            w.set_ccif(channel(Alarm::Sampler), false);
            w.set_ccif(channel(Alarm::Sleep), false);
        });
        // Read back, so that the write has arrived before the interrupt ends.
        let _ = TIMER.sr().read();
    }

    fn pend() {
        interrupt::TIM2.pend();
    }
}

/// Starts it.
pub(super) fn start(_timer: Peri<'static, TIM2>) {
    rcc::enable_and_reset::<TIM2>();
    let per_us = rcc::frequency::<TIM2>().0 / 1_000_000;
    TIMER.psc().write_value(per_us.saturating_sub(1) as u16);
    TIMER.arr().write_value(u32::MAX);
    // The prescaler is taken over by an update.
    TIMER.egr().write(|w| w.set_ug(true));
    TIMER.sr().write(|w| w.0 = 0);
    TIMER.dier().write(|w| {
        w.set_ccie(channel(Alarm::Sampler), true);
        w.set_ccie(channel(Alarm::Sleep), true);
    });
    TIMER.cr1().write(|w| w.set_cen(true));
}

/// Microseconds since start.
pub fn now_us() -> u64 {
    counter::now_us::<Tim2>()
}

/// Makes the sampler's interrupt come then.
pub fn set_sampler(at_us: u64) {
    counter::set_sampler::<Tim2>(at_us);
}
