//! A bus that fails, at every byte of every transaction of every operation.

use embedded_hal::i2c::ErrorKind;
use ironout_drivers::{Error, Kind, Magnetometer};
use ironout_rig::bus::Hit;

use crate::bench::{Bench, KINDS, near};

const FIELD_UT: [f64; 3] = [12.0, -34.0, 56.0];

/// One operation of a driver; what it answers is of no interest here.
type Operation = fn(&mut Bench) -> Result<(), Error<ErrorKind>>;

const OPERATIONS: [(&str, Operation); 5] = [
    ("init", |bench| bench.driver.init()),
    ("data_ready", |bench| bench.driver.data_ready().map(|_| ())),
    ("read", |bench| bench.driver.read().map(|_| ())),
    ("temperature_c", |bench| bench.driver.temperature_c().map(|_| ())),
    // With the waiting for the first measurements, and what a chip does before them.
    ("init and the first measurement", |bench| {
        bench.driver.init()?;
        assert!(bench.is_ready()?, "{:?}", bench.kind);
        bench.driver.read().map(|_| ())
    }),
];

/// The bytes on the wire, transaction by transaction, of an operation that goes well.
fn wire_bytes(bench: &mut Bench, operation: Operation) -> Vec<usize> {
    use std::cell::RefCell;
    use std::rc::Rc;
    let seen: Rc<RefCell<Vec<usize>>> = Rc::default();
    let (begin, log) = (bench.faults.transactions(), seen.clone());
    bench.faults.set(move |transaction, _| {
        let place = (transaction - begin) as usize;
        let mut log = log.borrow_mut();
        let length = log.len().max(place + 1);
        log.resize(length, 0);
        log[place] += 1;
        Hit::Pass
    });
    operation(bench).unwrap();
    bench.faults.clear();
    seen.take()
}

#[test]
fn a_fault_at_any_byte_of_any_transaction_is_an_error_and_heals() {
    let mut faults = 0;
    for kind in KINDS {
        for (name, operation) in OPERATIONS {
            let whole = name.contains("first");
            let start = || {
                let mut bench = Bench::ready(kind, FIELD_UT);
                bench.fresh();
                if name == "read" {
                    assert_eq!(bench.is_ready(), Ok(true));
                }
                bench
            };
            let transactions = wire_bytes(&mut start(), operation);
            for (transaction, bytes) in transactions.into_iter().enumerate() {
                // The long one by its addresses alone: its bytes are those of the others.
                for byte in 0..if whole { 1 } else { bytes } {
                    let mut bench = start();
                    bench.faults.nack_at(transaction as u64, byte);
                    let failed = operation(&mut bench);
                    assert!(
                        matches!(
                            failed,
                            Err(Error::Bus(ErrorKind::NoAcknowledge(_) | ErrorKind::ArbitrationLoss))
                        ),
                        "{kind:?} {name}, transaction {transaction}, byte {byte}: {failed:?}"
                    );
                    bench.faults.clear();
                    // A fault of anything but the configuration heals by asking again.
                    if !name.starts_with("init") {
                        assert_eq!(bench.is_ready(), Ok(true), "{kind:?} {name} {transaction} {byte}");
                    }
                    assert_eq!(bench.driver.init(), Ok(()), "{kind:?} {name} {transaction} {byte}");
                    let measured = bench.fresh_ut().unwrap();
                    assert!(near(measured, FIELD_UT, bench.tolerance_ut()), "{kind:?} {name}: {measured:?}");
                    faults += 1;
                }
            }
        }
    }
    assert!(faults > 1000, "{faults}");
}

#[test]
fn a_bus_that_is_held_is_an_error_of_every_operation_and_free_again() {
    for kind in KINDS {
        let mut bench = Bench::ready(kind, FIELD_UT);
        bench.fresh();
        bench.faults.hold_bus();
        for (name, operation) in OPERATIONS {
            // Some temperatures are none, or known already.
            let without_bus = name == "temperature_c" && operation(&mut bench).is_ok();
            assert!(
                without_bus || operation(&mut bench) == Err(Error::Bus(ErrorKind::Bus)),
                "{kind:?} {name}"
            );
        }
        bench.faults.clear();
        assert_eq!(bench.driver.init(), Ok(()));
        assert!(near(bench.fresh_ut().unwrap(), FIELD_UT, bench.tolerance_ut()));
    }
}

#[test]
fn a_flipped_configuration_byte_is_noticed_where_it_can_be_read_back() {
    for kind in KINDS {
        let mut bench = Bench::new(kind, FIELD_UT);
        let transactions = wire_bytes(&mut bench, |bench| bench.driver.init());
        let mut noticed = 0;
        for (transaction, bytes) in transactions.iter().enumerate() {
            // Address, register, value: a write of one register.
            if *bytes != 3 {
                continue;
            }
            for bit in 0..8 {
                let mut bench = Bench::new(kind, FIELD_UT);
                bench.faults.flip_at(transaction as u64, 2, 1 << bit);
                match bench.driver.init() {
                    Ok(()) | Err(Error::Bus(_) | Error::NotFound { .. }) => {}
                    Err(Error::NotKept { written, read, .. }) => {
                        assert_ne!(written, read);
                        noticed += 1;
                    }
                    Err(other) => panic!("{kind:?}: {other}"),
                }
                bench.faults.clear();
                assert_eq!(bench.driver.init(), Ok(()), "{kind:?}");
                assert!(near(bench.fresh_ut().unwrap(), FIELD_UT, bench.tolerance_ut()), "{kind:?}");
            }
        }
        match kind {
            // Their control registers cannot be read.
            Kind::Mmc5983ma | Kind::Mmc5603 => assert_eq!(noticed, 0),
            _ => assert!(noticed >= 4, "{kind:?}: {noticed}"),
        }
    }
}

#[test]
fn random_faults_on_a_tenth_of_the_bytes_never_make_a_wrong_measurement() {
    for (seed, kind) in (0..).zip(KINDS) {
        let mut bench = Bench::ready(kind, FIELD_UT);
        bench.fresh();
        bench.faults.nack_randomly(seed, 0.1);
        let (mut good, mut failed) = (0, 0);
        for _ in 0..3000 {
            bench.wait_ms(1);
            let reading = match bench.driver.data_ready() {
                Ok(true) => bench.driver.read(),
                Ok(false) => continue,
                Err(error) => Err(error),
            };
            match reading {
                Ok(reading) => {
                    let sensor = bench.driver.describe();
                    let measured = sensor.measured_ut(sensor.sample(&reading)).unwrap();
                    assert!(near(measured, FIELD_UT, bench.tolerance_ut()), "{kind:?}: {measured:?}");
                    good += 1;
                }
                Err(Error::Bus(_)) => failed += 1,
                Err(other) => panic!("{kind:?}: {other}"),
            }
        }
        assert!(good >= 20 && failed >= 20, "{kind:?}: {good} {failed}");
    }
}
