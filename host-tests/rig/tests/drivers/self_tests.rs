//! The self-tests: passed by a good chip, failed on the right axis by one with a dead element, and over when they are over.

use std::rc::Rc;

use embedded_hal::i2c::ErrorKind;
use ironout_drivers::{
    Driver, Error, Magnetometer, Outcome, SelfTest, ak09916, bmm150, hmc5883l, icm20948, ist8310, lis2mdl,
    lis3mdl, rm3100,
};
use ironout_rig::board::SimDelay;
use ironout_rig::bus::{Clock, FaultControl, Faulty, SimBus};

use crate::bench::{Hand, Wire, attach, near};
use ironout_drivers::Kind;

const FIELD_UT: [f64; 3] = [22.0, -31.0, 41.0];

/// A driver with a self-test.
trait Tested {
    fn test(&mut self, delay: &mut SimDelay) -> Result<Outcome, Error<ErrorKind>>;
    fn as_magnetometer(&mut self) -> &mut dyn Magnetometer<BusError = ErrorKind>;
}

impl<C: SelfTest> Tested for Driver<Wire, C> {
    fn test(&mut self, delay: &mut SimDelay) -> Result<Outcome, Error<ErrorKind>> {
        self.self_test(delay)
    }
    fn as_magnetometer(&mut self) -> &mut dyn Magnetometer<BusError = ErrorKind> {
        self
    }
}

impl Tested for icm20948::Icm20948<Wire> {
    fn test(&mut self, delay: &mut SimDelay) -> Result<Outcome, Error<ErrorKind>> {
        self.self_test(delay)
    }
    fn as_magnetometer(&mut self) -> &mut dyn Magnetometer<BusError = ErrorKind> {
        self
    }
}

impl Tested for bmm150::Bmm150<Wire, SimDelay> {
    fn test(&mut self, _delay: &mut SimDelay) -> Result<Outcome, Error<ErrorKind>> {
        self.self_test()
    }
    fn as_magnetometer(&mut self) -> &mut dyn Magnetometer<BusError = ErrorKind> {
        self
    }
}

struct Rm3100(rm3100::Rm3100<Wire>);

impl Tested for Rm3100 {
    fn test(&mut self, delay: &mut SimDelay) -> Result<Outcome, Error<ErrorKind>> {
        self.0.self_test(delay)
    }
    fn as_magnetometer(&mut self) -> &mut dyn Magnetometer<BusError = ErrorKind> {
        &mut self.0
    }
}

const KINDS: [Kind; 9] = [
    Kind::Lis2mdl,
    Kind::Lsm303agr,
    Kind::Lis3mdl,
    Kind::Hmc5883l,
    Kind::Ak09916,
    Kind::Icm20948,
    Kind::Ist8310,
    Kind::Bmm150,
    Kind::Rm3100,
];

struct Chip {
    clock: Clock,
    faults: FaultControl,
    hand: Rc<dyn Hand>,
    driver: Box<dyn Tested>,
}

fn chip(kind: Kind) -> Chip {
    let clock = Clock::default();
    let bus = SimBus::new(clock.clone());
    let (_, hand) = attach(&bus, kind);
    hand.set_field(FIELD_UT);
    let faults = FaultControl::new();
    let wire = Faulty::new(bus, faults.clone());
    let driver: Box<dyn Tested> = match kind {
        Kind::Lis2mdl => Box::new(Driver::new(wire, lis2mdl::Config::default())),
        Kind::Lsm303agr => Box::new(Driver::new(wire, lis2mdl::Config::of(lis2mdl::Model::Lsm303agr))),
        Kind::Lis3mdl => Box::new(Driver::new(wire, lis3mdl::Config::default())),
        Kind::Hmc5883l => Box::new(Driver::new(wire, hmc5883l::Config::default())),
        Kind::Ak09916 => Box::new(Driver::new(wire, ak09916::Config::default())),
        Kind::Icm20948 => Box::new(icm20948::Icm20948::new(wire, icm20948::Config::default())),
        Kind::Ist8310 => Box::new(Driver::new(wire, ist8310::Config::default())),
        Kind::Bmm150 => {
            Box::new(bmm150::Bmm150::new(wire, SimDelay(clock.clone()), bmm150::Config::default()))
        }
        Kind::Rm3100 => Box::new(Rm3100(rm3100::Rm3100::new(wire, rm3100::Config::default()))),
        other => panic!("{other:?} has no self-test"),
    };
    let mut chip = Chip { clock, faults, hand, driver };
    chip.driver.as_magnetometer().init().unwrap();
    chip
}

impl Chip {
    fn test(&mut self) -> Result<Outcome, Error<ErrorKind>> {
        self.driver.test(&mut SimDelay(self.clock.clone()))
    }

    /// The field as the driver measures it now.
    fn measured_ut(&mut self) -> [f32; 3] {
        let driver = self.driver.as_magnetometer();
        let mut last = None;
        for _ in 0..500 {
            self.clock.advance_ns(1_000_000);
            if driver.data_ready().unwrap() {
                last = Some(driver.read().unwrap());
            }
        }
        let sensor = driver.describe();
        sensor.measured_ut(sensor.sample(&last.expect("data"))).expect("in range")
    }
}

#[test]
fn a_good_chip_passes_and_measures_the_field_afterwards() {
    for kind in KINDS {
        let mut chip = chip(kind);
        let outcome = chip.test().unwrap();
        assert!(outcome.passed(), "{kind:?}: {outcome:?}");
        let measured = chip.measured_ut();
        assert!(near(measured, FIELD_UT, 0.35), "{kind:?}: {measured:?}");
    }
}

#[test]
fn a_dead_axis_fails_alone() {
    for kind in KINDS {
        for axis in 0..3 {
            let mut chip = chip(kind);
            chip.hand.set_dead_axis(Some(axis));
            let Outcome::Failed { good, counts } = chip.test().unwrap() else { panic!("{kind:?} passed") };
            let expected: [bool; 3] = std::array::from_fn(|one| one != axis);
            assert_eq!(good, expected, "{kind:?} {counts:?}");
            chip.hand.set_dead_axis(None);
            assert!(near(chip.measured_ut(), FIELD_UT, 0.35), "{kind:?}");
        }
    }
}

#[test]
fn a_chip_that_does_not_measure_is_no_endless_wait() {
    for kind in KINDS {
        let mut chip = chip(kind);
        // Its measurements never end.
        chip.hand.freeze();
        let outcome = chip.test();
        assert_eq!(outcome, Ok(Outcome::NoData), "{kind:?}");
        assert!(chip.clock.s() < 5.0, "{kind:?}: {} s", chip.clock.s());
    }
}

#[test]
fn a_fault_at_any_transaction_of_a_self_test_is_an_error_and_the_driver_measures_on() {
    for kind in KINDS {
        let mut healthy = chip(kind);
        let before = healthy.faults.transactions();
        healthy.test().unwrap();
        let transactions = healthy.faults.transactions() - before;
        // Every one of the short tests; of those that average, the first and last and a spread of those between.
        let step = (transactions / 40).max(1);
        for transaction in (0..transactions).filter(|at| at % step == 0 || *at < 30 || at + 30 > transactions)
        {
            let mut chip = chip(kind);
            chip.faults.nack_at(transaction, 0);
            let outcome = chip.test();
            assert!(
                matches!(outcome, Err(Error::Bus(_))),
                "{kind:?} {transaction} of {transactions}: {outcome:?}"
            );
            chip.faults.clear();
            chip.driver.as_magnetometer().init().unwrap();
            assert!(near(chip.measured_ut(), FIELD_UT, 0.35), "{kind:?} {transaction}");
        }
    }
}
