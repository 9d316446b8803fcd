//! The sampler's place on this board: its bus and its interrupt.

use super::bus::Bus;
use super::time::{self, Timer1};
use crate::board::counter;
use crate::board::motion::{Motion, NoGyro};
use crate::board::sampler::{Ground, Seat};
use crate::board::shared_bus::{Place, Shared};
use embassy_nrf::interrupt;
use ironout_drivers::lis2mdl::Lis2mdl;
use ironout_drivers::lsm303_accelerometer::Lsm303Accelerometer;

/// The bus.
pub static BUS: Place<Bus> = Place::new();
/// The sampler.
pub static SEAT: Seat<Sampling> = Seat::new();

/// Where the sampler works.
pub struct Sampling;

impl Ground for Sampling {
    type Sensor = Lis2mdl<Shared<Bus>>;
    type Motion = Motion<Lsm303Accelerometer<Shared<Bus>>, NoGyro>;

    fn now_us() -> u64 {
        time::now_us()
    }

    fn set_alarm(at_us: u64) {
        time::set_sampler(at_us);
    }

    fn pend() {
        time::set_sampler(0);
        cortex_m::asm::isb();
    }
}

#[interrupt]
fn TIMER1() {
    counter::interrupt::<Timer1, _>(&SEAT);
}
