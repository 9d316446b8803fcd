//! The temperature registers, left-justified on the chip and right-justified in the emulated one.

use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use ironout_drivers::Magnetometer;
use ironout_drivers::lsm303dlhc::register::ADDRESS as MAG;
use ironout_drivers::lsm303dlhc::{Config, Lsm303dlhc, TemperatureFormat};

fn read(register: u8, byte: u8) -> Transaction {
    Transaction::write_read(MAG, vec![register], vec![byte])
}

fn celsius(temperature_format: TemperatureFormat, transactions: &[Transaction]) -> Option<f32> {
    let config = Config { temperature_format, ..Config::default() };
    let mut sensor = Lsm303dlhc::new(Mock::new(transactions), config);
    let celsius = sensor.temperature_c().unwrap();
    sensor.destroy().done();
    celsius
}

/// A temperature that does not change while it is read.
fn steady([high, low]: [u8; 2]) -> [Transaction; 3] {
    [read(0x31, high), read(0x32, low), read(0x31, high)]
}

#[test]
fn the_real_chip_is_left_justified_and_signed() {
    // 21.5 °C are 172 counts, 0x0ac; −10.25 °C are −82 counts, 0xfae.
    assert_eq!(celsius(TemperatureFormat::LeftJustified, &steady([0x0a, 0xc0])), Some(21.5));
    assert_eq!(celsius(TemperatureFormat::LeftJustified, &steady([0xfa, 0xe0])), Some(-10.25));
}

#[test]
fn the_emulated_chip_is_right_justified_and_sign_extended() {
    assert_eq!(celsius(TemperatureFormat::RightJustified, &steady([0x00, 0xac])), Some(21.5));
    assert_eq!(celsius(TemperatureFormat::RightJustified, &steady([0xff, 0xae])), Some(-10.25));
}

#[test]
fn the_bytes_of_two_measurements_are_not_mixed() {
    // 15.875 °C becomes 16 °C between the two bytes: 0x07f0 becomes 0x0800.
    let torn = [read(0x31, 0x07), read(0x32, 0x00), read(0x31, 0x08), read(0x32, 0x00)];
    assert_eq!(celsius(TemperatureFormat::LeftJustified, &torn), Some(16.0));
}

#[test]
fn nothing_is_read_where_the_sensor_is_switched_off() {
    let mut sensor = Lsm303dlhc::new(Mock::new(&[]), Config { temperature: false, ..Config::default() });
    assert_eq!(sensor.temperature_c(), Ok(None));
    sensor.destroy().done();
}
