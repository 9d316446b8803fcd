//! The temperature registers, left-justified on the chip and right-justified in the emulated one.

use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use ironout_drivers::Magnetometer;
use ironout_drivers::lsm303dlhc::register::ADDRESS as MAG;
use ironout_drivers::lsm303dlhc::{Config, Lsm303dlhc, TemperatureFormat};

fn celsius(temperature_format: TemperatureFormat, bytes: [u8; 2]) -> Option<f32> {
    let bus = Mock::new(&[Transaction::write_read(MAG, vec![0x31], bytes.to_vec())]);
    let mut sensor = Lsm303dlhc::new(bus, Config { temperature_format, ..Config::default() });
    let celsius = sensor.temperature_c().unwrap();
    sensor.destroy().done();
    celsius
}

#[test]
fn the_real_chip_is_left_justified_and_signed() {
    // 21.5 °C are 172 counts, 0x0ac; −10.25 °C are −82 counts, 0xfae.
    assert_eq!(celsius(TemperatureFormat::LeftJustified, [0x0a, 0xc0]), Some(21.5));
    assert_eq!(celsius(TemperatureFormat::LeftJustified, [0xfa, 0xe0]), Some(-10.25));
}

#[test]
fn the_emulated_chip_is_right_justified_and_sign_extended() {
    assert_eq!(celsius(TemperatureFormat::RightJustified, [0x00, 0xac]), Some(21.5));
    assert_eq!(celsius(TemperatureFormat::RightJustified, [0xff, 0xae]), Some(-10.25));
}

#[test]
fn nothing_is_read_where_the_sensor_is_switched_off() {
    let mut sensor = Lsm303dlhc::new(Mock::new(&[]), Config { temperature: false, ..Config::default() });
    assert_eq!(sensor.temperature_c(), Ok(None));
    sensor.destroy().done();
}
