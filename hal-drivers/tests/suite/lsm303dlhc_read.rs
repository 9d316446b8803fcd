//! Output registers, their order, scale and overflow.

use embedded_hal::i2c::ErrorKind;
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use ironout_drivers::lsm303dlhc::register::ADDRESS as MAG;
use ironout_drivers::lsm303dlhc::{Config, Lsm303dlhc, Range};
use ironout_drivers::{Error, Magnetometer, Reading};

fn read(bytes: [u8; 6]) -> Reading {
    let bus = Mock::new(&[Transaction::write_read(MAG, vec![0x03], bytes.to_vec())]);
    let mut sensor = Lsm303dlhc::new(bus, Config::default());
    let reading = sensor.read().unwrap();
    sensor.destroy().done();
    reading
}

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
fn the_registers_stand_in_the_order_x_z_y_high_byte_first() {
    let reading = read([0x01, 0x02, 0xfe, 0xd4, 0x00, 0x07]);
    assert_eq!(reading.counts, [258, 7, -300]);
    assert!(!reading.saturated());
}

#[test]
fn minus_4096_is_an_overflow_of_that_axis_and_the_extremes_are_not() {
    let reading = read([0x07, 0xff, 0xf0, 0x00, 0xf8, 0x00]);
    assert_eq!(reading.counts, [2047, -2048, -4096]);
    assert_eq!(reading.overflow, [false, false, true]);
    assert!(reading.saturated());
}

#[test]
fn a_value_beyond_12_bits_is_no_measurement() {
    let reading = read([0x08, 0x00, 0xf7, 0xff, 0x41, 0x00]);
    assert_eq!((reading.counts, reading.overflow), ([2048, 16640, -2049], [true; 3]));
}

#[test]
fn z_has_its_own_scale_at_every_range() {
    for range in Range::ALL {
        let config = Config { range, ..Config::default() };
        let scale = Lsm303dlhc::new(Mock::new(&[]), config);
        let [x, y, z] = scale.describe().ut_per_count;
        scale.destroy().done();
        assert_eq!(x, y);
        assert!(z > 1.1 * x && z < 1.14 * x, "{range:?}: {x} {z}");
    }
    assert_eq!(Range::Gauss1_9.ut_per_count(), [100.0 / 855.0, 100.0 / 855.0, 100.0 / 760.0]);
}

#[test]
fn data_ready_is_bit_0_of_the_status_alone() {
    let bus = Mock::new(&[
        Transaction::write_read(MAG, vec![0x09], vec![0x02]),
        Transaction::write_read(MAG, vec![0x09], vec![0x03]),
    ]);
    let mut sensor = Lsm303dlhc::new(bus, Config::default());
    assert_eq!(sensor.data_ready(), Ok(false));
    assert_eq!(sensor.data_ready(), Ok(true));
    sensor.destroy().done();
}

#[test]
fn the_first_conversion_after_a_configuration_may_be_of_the_gain_before_and_is_dropped() {
    let config = Config::default();
    let ready = || Transaction::write_read(MAG, vec![0x09], vec![0x01]);
    let conversion = || Transaction::write_read(MAG, vec![0x03], vec![0x00, 0x01, 0x00, 0x03, 0x00, 0x02]);
    let mut transactions = init_transactions(config);
    transactions.extend([ready(), conversion(), ready(), conversion()]);
    let mut sensor = Lsm303dlhc::new(Mock::new(&transactions), config);
    sensor.init().unwrap();
    assert_eq!(sensor.data_ready(), Ok(false), "it is read and dropped");
    assert_eq!(sensor.data_ready(), Ok(true));
    assert_eq!(sensor.read().map(|reading| reading.counts), Ok([1, 2, 3]));
    sensor.destroy().done();
}

#[test]
fn a_bus_error_is_passed_on() {
    let bus = Mock::new(&[
        Transaction::write_read(MAG, vec![0x03], vec![0; 6]).with_error(ErrorKind::ArbitrationLoss)
    ]);
    let mut sensor = Lsm303dlhc::new(bus, Config::default());
    assert_eq!(sensor.read(), Err(Error::Bus(ErrorKind::ArbitrationLoss)));
    sensor.destroy().done();
}
