//! The sampler's place on this board: its alarm and its interrupt.

use super::probed::Probed;
use super::time::{self, Alarm};
use crate::board::sampler::{Ground, Seat};
use embassy_rp::interrupt;
use embassy_rp::interrupt::InterruptExt;

/// The timer's alarm of the sampler.
const ALARM: Alarm = Alarm(1);

/// Where the sampler works.
pub struct Sampling;

impl Ground for Sampling {
    type Sensor = Probed;
    type Motion = ();

    fn now_us() -> u64 {
        time::now_us()
    }

    fn set_alarm(at_us: u64) {
        ALARM.set(at_us);
    }

    fn pend() {
        interrupt::TIMER_IRQ_1.pend();
        // It has come when the next instruction but one is done.
        cortex_m::asm::isb();
    }
}

/// The sampler.
pub static SEAT: Seat<Sampling> = Seat::new();

#[interrupt]
fn TIMER_IRQ_1() {
    ALARM.clear();
    SEAT.interrupt();
}
