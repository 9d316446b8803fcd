//! Time: TIMER1, 32 bits at 1 MHz.

use crate::board::counter::{self, Alarm, Counter};
use core::marker::PhantomData;
use embassy_nrf::Peri;
use embassy_nrf::interrupt;
use embassy_nrf::interrupt::InterruptExt;
use embassy_nrf::pac;
use embassy_nrf::peripherals::TIMER1;

const TIMER: pac::timer::Timer = pac::TIMER1;
/// The channel that is captured into; the alarms have the next two.
const NOW: usize = 0;

/// The timer.
pub struct Timer1;

/// The clock.
pub type Clock = counter::Clock<Timer1>;

embassy_time_driver::time_driver_impl!(static TIME: counter::Time<Timer1> = counter::Time(PhantomData));

const fn channel(alarm: Alarm) -> usize {
    match alarm {
        Alarm::Sampler => 1,
        Alarm::Sleep => 2,
    }
}

impl Counter for Timer1 {
    fn count() -> u32 {
        // Nobody captures in between: the clock is read with interrupts held back.
        TIMER.tasks_capture(NOW).write_value(1);
        TIMER.cc(NOW).read()
    }

    fn set(alarm: Alarm, at: u32) {
        TIMER.cc(channel(alarm)).write_value(at);
    }

    fn acknowledge() {
        TIMER.events_compare(channel(Alarm::Sampler)).write_value(0);
        TIMER.events_compare(channel(Alarm::Sleep)).write_value(0);
        // Read back, so that the write has arrived before the interrupt ends.
        let _ = TIMER.events_compare(channel(Alarm::Sleep)).read();
    }

    fn pend() {
        interrupt::TIMER1.pend();
    }
}

/// Starts it.
pub(super) fn start(_timer: Peri<'static, TIMER1>) {
    TIMER.tasks_stop().write_value(1);
    TIMER.bitmode().write(|w| w.set_bitmode(pac::timer::vals::Bitmode::_32bit));
    // 16 MHz by two to the fourth.
    TIMER.prescaler().write(|w| w.set_prescaler(4));
    TIMER.tasks_clear().write_value(1);
    TIMER.intenset().write(|w| {
        w.set_compare(channel(Alarm::Sampler), true);
        w.set_compare(channel(Alarm::Sleep), true);
    });
    TIMER.tasks_start().write_value(1);
}

/// Microseconds since start.
pub fn now_us() -> u64 {
    counter::now_us::<Timer1>()
}

/// Makes the sampler's interrupt come then.
pub fn set_sampler(at_us: u64) {
    counter::set_sampler::<Timer1>(at_us);
}
