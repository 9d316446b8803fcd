//! `ironout` inside somebody else's firmware: an STM32F411E-DISCO, whose LSM303DLHC sits on I²C1 (PB6, PB9).
//!
//! Nothing of ironout's own console, store or board is used: only the driver, the session and the calibration. The
//! board collects while it is turned (orange light), solves as soon as the data suffice, and then lights green while
//! the corrected magnitude is right and red where something magnetic is near.
//!
//!     cd examples/firmware && cargo build --release     # or `cargo run --release` with probe-rs and the board
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use ironout::calibration::Calibration;
use ironout::sensor::{Reading, Sensor};
use ironout::session::{Hint, Session, SessionConfig};
use ironout_drivers::lsm303dlhc::{Config, Lsm303dlhc, Range};
use ironout_drivers::{Error, Magnetometer};
use panic_halt as _;
use stm32f4xx_hal::{pac, prelude::*, rcc};

/// A magnitude further off than this is a disturbance, as a part of the field.
const DISTURBED: f32 = 0.1;

#[entry]
fn main() -> ! {
    if let Some(dp) = pac::Peripherals::take() {
        let mut rcc = dp.RCC.freeze(rcc::Config::hsi().sysclk(48.MHz()));
        let (gpiob, gpiod) = (dp.GPIOB.split(&mut rcc), dp.GPIOD.split(&mut rcc));
        let i2c = dp.I2C1.i2c((gpiob.pb6, gpiob.pb9), 400.kHz(), &mut rcc);
        let mut lights = Lights {
            green: gpiod.pd12.into_push_pull_output(),
            orange: gpiod.pd13.into_push_pull_output(),
            red: gpiod.pd14.into_push_pull_output(),
        };
        let mut delay = dp.TIM5.delay_us(&mut rcc);
        let mut sensor = Lsm303dlhc::new(i2c, Config { range: Range::Gauss1_9, ..Config::default() });
        loop {
            // Ends only when the sensor fails: configure it afresh, and calibrate again.
            let _ = run(&mut sensor, &mut delay, &mut lights);
            lights.show(false, false, true);
            delay.delay_ms(500);
        }
    }
    panic!("the peripherals were taken before");
}

/// The application, for any magnetometer, delay and lights.
fn run<M: Magnetometer>(
    sensor: &mut M,
    delay: &mut impl DelayNs,
    lights: &mut Lights<impl OutputPin, impl OutputPin, impl OutputPin>,
) -> Result<(), Error<M::BusError>> {
    sensor.init()?;
    lights.show(false, true, false);
    let description = sensor.describe();
    let calibration = calibrate(sensor, &description, delay)?;
    loop {
        let sample = description.sample(&next(sensor, delay)?);
        let corrected_ut = calibration.apply_counts(&description, sample.counts);
        let error = calibration.residual_ut(corrected_ut).abs() / calibration.field_ut;
        let good = sample.is_valid() && error < DISTURBED;
        lights.show(good, false, !good);
    }
}

/// The next conversion, each one once.
fn next<M: Magnetometer>(sensor: &mut M, delay: &mut impl DelayNs) -> Result<Reading, Error<M::BusError>> {
    while !sensor.data_ready()? {
        delay.delay_ms(1);
    }
    sensor.read()
}

/// Collects until the data carry a calibration that is accepted.
fn calibrate<M: Magnetometer>(
    sensor: &mut M,
    description: &Sensor,
    delay: &mut impl DelayNs,
) -> Result<Calibration<f32>, Error<M::BusError>> {
    let mut session = Session::new(SessionConfig::of(description));
    session.start();
    loop {
        for _ in 0..(1000 / description.period_ms()).max(1) {
            session.push(description.sample(&next(sensor, delay)?));
        }
        // Once a second: is it enough? A status while collecting solves the data so far.
        if session.status().hint == Hint::Stop && session.stop().is_ok() {
            match session.accept() {
                Ok(record) => return Ok(record.calibration.cast()),
                Err(_) => session.start(),
            }
        }
    }
}

struct Lights<G, O, R> {
    green: G,
    orange: O,
    red: R,
}

impl<G: OutputPin, O: OutputPin, R: OutputPin> Lights<G, O, R> {
    fn show(&mut self, green: bool, orange: bool, red: bool) {
        // A pin of a microcontroller cannot fail; the trait allows for expanders that can.
        let _ = self.green.set_state(green.into());
        let _ = self.orange.set_state(orange.into());
        let _ = self.red.set_state(red.into());
    }
}
