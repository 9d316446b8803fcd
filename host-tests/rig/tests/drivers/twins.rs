//! The awaited drivers do on the bus what the others do, transaction by transaction.

use std::cell::RefCell;
use std::rc::Rc;

use embassy_futures::block_on;
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, Operation};
use ironout_drivers::{
    AnyMagnetometer, AsyncMagnetometer, Driver, Error, Found, Kind, Magnetometer, Outcome, Reading, SelfTest,
    Sensor, ak09916, asynch, bmm150, hmc5883l, icm20948, ist8310, lis2mdl, lis3mdl, rm3100,
};
use ironout_rig::board::SimDelay;
use ironout_rig::bus::{Clock, SimBus};

use crate::bench::{KINDS, attach};

/// What is waited for, as something awaited that is there at once.
pub struct Awaited<T>(pub T);

impl<B: I2c<Error = ErrorKind>> ErrorType for Awaited<B> {
    type Error = ErrorKind;
}

impl<B: I2c<Error = ErrorKind>> embedded_hal_async::i2c::I2c for Awaited<B> {
    async fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        self.0.transaction(address, operations)
    }
}

impl<D: DelayNs> embedded_hal_async::delay::DelayNs for Awaited<D> {
    async fn delay_ns(&mut self, ns: u32) {
        self.0.delay_ns(ns);
    }
}

/// A bus that writes down what is on it, and when.
#[derive(Clone)]
struct Recorded {
    bus: SimBus,
    clock: Clock,
    transcript: Rc<RefCell<Vec<String>>>,
}

impl ErrorType for Recorded {
    type Error = ErrorKind;
}

impl I2c for Recorded {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        let result = self.bus.transaction(address, operations);
        let line = format!("{} {address:#04x} {operations:02x?} {result:?}", self.clock.ns());
        self.transcript.borrow_mut().push(line);
        result
    }
}

type Transcript = (Vec<String>, Vec<Reading>, Vec<Option<f32>>, Sensor);

fn board(kind: Kind) -> (Clock, Recorded, Found) {
    let clock = Clock::default();
    let bus = SimBus::new(clock.clone());
    let (found, chip) = attach(&bus, kind);
    chip.set_field([12.5, -70.0, 33.0]);
    (clock.clone(), Recorded { bus, clock, transcript: Rc::default() }, found)
}

fn waited_for(kind: Kind) -> Transcript {
    let (clock, bus, found) = board(kind);
    let mut driver = AnyMagnetometer::new(bus.clone(), SimDelay(clock.clone()), found);
    let (mut readings, mut temperatures) = (Vec::new(), Vec::new());
    driver.init().unwrap();
    for _ in 0..300 {
        clock.advance_ns(1_000_000);
        if driver.data_ready().unwrap() {
            readings.push(driver.read().unwrap());
            temperatures.push(driver.temperature_c().unwrap());
        }
    }
    let sensor = driver.describe();
    (bus.transcript.take(), readings, temperatures, sensor)
}

fn awaited(kind: Kind) -> Transcript {
    let (clock, bus, found) = board(kind);
    let delay = Awaited(SimDelay(clock.clone()));
    let mut driver = asynch::AnyMagnetometer::new(Awaited(bus.clone()), delay, found);
    let (mut readings, mut temperatures) = (Vec::new(), Vec::new());
    block_on(async {
        driver.init().await.unwrap();
        for _ in 0..300 {
            clock.advance_ns(1_000_000);
            if driver.data_ready().await.unwrap() {
                readings.push(driver.read().await.unwrap());
                temperatures.push(driver.temperature_c().await.unwrap());
            }
        }
    });
    let sensor = driver.describe();
    (bus.transcript.take(), readings, temperatures, sensor)
}

#[test]
fn both_do_the_same_on_the_bus_and_read_the_same() {
    for kind in KINDS {
        let (one, other) = (waited_for(kind), awaited(kind));
        assert!(one.0.len() > 300 && one.1.len() >= 5, "{kind:?}: {} {}", one.0.len(), one.1.len());
        assert_eq!(one, other, "{kind:?}");
    }
}

type Tested = (Vec<String>, Result<Outcome, Error<ErrorKind>>);

fn same(
    kind: Kind,
    blocking: impl Fn(Recorded, SimDelay) -> Tested,
    awaited: impl Fn(Recorded, SimDelay) -> Tested,
) {
    let (clock, bus, _) = board(kind);
    let one = blocking(bus, SimDelay(clock));
    let (clock, bus, _) = board(kind);
    let other = awaited(bus, SimDelay(clock));
    assert!(one.0.len() > 5 && one.1.is_ok_and(|outcome| outcome.passed()), "{kind:?}: {:?}", one.1);
    assert_eq!(one, other, "{kind:?}");
}

fn same_of<C: SelfTest + Copy>(kind: Kind, config: C) {
    same(
        kind,
        |bus, mut delay| {
            let mut driver = Driver::new(bus.clone(), config);
            let outcome = driver.self_test(&mut delay);
            (bus.transcript.take(), outcome)
        },
        |bus, delay| {
            let mut driver = asynch::Driver::new(Awaited(bus.clone()), config);
            let outcome = block_on(driver.self_test(&mut Awaited(delay)));
            (bus.transcript.take(), outcome)
        },
    );
}

#[test]
fn both_do_the_same_in_a_self_test() {
    same_of(Kind::Lis2mdl, lis2mdl::Config::default());
    same_of(Kind::Lis3mdl, lis3mdl::Config::default());
    same_of(Kind::Hmc5883l, hmc5883l::Config::default());
    same_of(Kind::Ak09916, ak09916::Config::default());
    same_of(Kind::Ist8310, ist8310::Config::default());
    same(
        Kind::Rm3100,
        |bus, mut delay| {
            let outcome = Driver::new(bus.clone(), rm3100::Config::default()).self_test(&mut delay);
            (bus.transcript.take(), outcome)
        },
        |bus, delay| {
            let mut driver = asynch::Driver::new(Awaited(bus.clone()), rm3100::Config::default());
            let outcome = block_on(driver.self_test(&mut Awaited(delay)));
            (bus.transcript.take(), outcome)
        },
    );
    same(
        Kind::Bmm150,
        |bus, delay| {
            let outcome = bmm150::Bmm150::new(bus.clone(), delay, bmm150::Config::default()).self_test();
            (bus.transcript.take(), outcome)
        },
        |bus, delay| {
            let mut driver =
                asynch::Bmm150::new(Awaited(bus.clone()), Awaited(delay), bmm150::Config::default());
            let outcome = block_on(driver.self_test());
            (bus.transcript.take(), outcome)
        },
    );
    same(
        Kind::Icm20948,
        |bus, mut delay| {
            let mut driver = icm20948::Icm20948::new(bus.clone(), icm20948::Config::default());
            let outcome = driver.self_test(&mut delay);
            (bus.transcript.take(), outcome)
        },
        |bus, delay| {
            let mut driver = asynch::Icm20948::new(Awaited(bus.clone()), icm20948::Config::default());
            let outcome = block_on(driver.self_test(&mut Awaited(delay)));
            (bus.transcript.take(), outcome)
        },
    );
}
