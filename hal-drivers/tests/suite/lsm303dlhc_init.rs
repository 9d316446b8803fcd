//! Identification and configuration of the LSM303DLHC.

use embedded_hal::i2c::ErrorKind;
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use ironout_drivers::lsm303dlhc::register::ADDRESS as MAG;
use ironout_drivers::lsm303dlhc::{Config, DataRate, Lsm303dlhc, Range};
use ironout_drivers::{Error, Magnetometer};

/// What `init` sends for `config`, and what a healthy chip answers.
fn init_transactions(config: Config) -> Vec<Transaction> {
    let (cra, crb) = (config.cra(), config.range.crb());
    vec![
        Transaction::write_read(MAG, vec![0x0a], b"H43".to_vec()),
        Transaction::write(MAG, vec![0x00, cra]),
        Transaction::write(MAG, vec![0x01, crb]),
        Transaction::write(MAG, vec![0x02, 0x00]),
        Transaction::write_read(MAG, vec![0x00], vec![cra, crb, 0x00]),
    ]
}

#[test]
fn writes_rate_temperature_range_and_continuous_mode_and_gives_the_bus_back() {
    let config =
        Config { range: Range::Gauss1_9, rate: DataRate::Hz220, temperature: true, ..Config::default() };
    assert_eq!((config.cra(), config.range.crb()), (0x9c, 0x40), "datasheet tables 71, 72 and 75");
    let mut sensor = Lsm303dlhc::new(Mock::new(&init_transactions(config)), config);
    sensor.init().unwrap();
    sensor.destroy().done();
}

#[test]
fn another_chip_at_the_address_is_named_and_nothing_is_written_to_it() {
    let bus = Mock::new(&[Transaction::write_read(MAG, vec![0x0a], vec![0x48, 0x00, 0xff])]);
    let mut sensor = Lsm303dlhc::new(bus, Config::default());
    let error = sensor.init().unwrap_err();
    assert_eq!(error, Error::NotFound { expected: *b"H43", found: [0x48, 0x00, 0xff] });
    assert_eq!(error.to_string(), "identity [48, 00, ff] where [48, 34, 33] is expected");
    sensor.destroy().done();
}

#[test]
fn a_register_that_does_not_keep_its_value_is_named() {
    let config = Config::default();
    let mut transactions = init_transactions(config);
    transactions.pop();
    transactions.push(Transaction::write_read(MAG, vec![0x00], vec![config.cra(), config.range.crb(), 0x03]));
    let mut sensor = Lsm303dlhc::new(Mock::new(&transactions), config);
    assert_eq!(sensor.init(), Err(Error::NotKept { register: 0x02, written: 0x00, read: 0x03 }));
    sensor.destroy().done();
}

#[test]
fn an_absent_chip_is_a_bus_error_and_init_may_be_repeated() {
    let absent = ErrorKind::NoAcknowledge(embedded_hal::i2c::NoAcknowledgeSource::Address);
    let config = Config::default();
    let mut transactions = vec![Transaction::write_read(MAG, vec![0x0a], vec![0; 3]).with_error(absent)];
    transactions.extend(init_transactions(config));
    let mut sensor = Lsm303dlhc::new(Mock::new(&transactions), config);
    assert_eq!(sensor.init(), Err(Error::Bus(absent)));
    assert_eq!(sensor.init(), Ok(()));
    sensor.destroy().done();
}
