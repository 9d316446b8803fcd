//! The sampler's place on this board: its bus and its interrupt.

use super::bus::Bus;
use super::sensor::{Accelerometer, Lsm303};
use super::time::{self, Tim2};
use crate::board::counter;
use crate::board::motion::Motion;
use crate::board::sampler::{Ground, Seat};
use crate::board::shared_bus::{Place, Shared};
use embassy_stm32::gpio::Output;
use embassy_stm32::interrupt;
use embassy_stm32::mode;
use embassy_stm32::spi::Spi;
use embassy_stm32::spi::mode::Master;
use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use ironout_drivers::l3gd20::L3gd20;
use ironout_drivers::wires::SpiRegisters;

/// The gyro's wires.
type Gyro =
    L3gd20<SpiRegisters<ExclusiveDevice<Spi<'static, mode::Blocking, Master>, Output<'static>, NoDelay>>>;

/// The bus.
pub static BUS: Place<Bus> = Place::new();
/// The sampler.
pub static SEAT: Seat<Sampling> = Seat::new();

/// Where the sampler works.
pub struct Sampling;

impl Ground for Sampling {
    type Sensor = Lsm303<Shared<Bus>>;
    type Motion = Motion<Accelerometer<Shared<Bus>>, Gyro>;

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
fn TIM2() {
    counter::interrupt::<Tim2, _>(&SEAT);
}
