//! Accelerometers and gyroscopes.

use embassy_futures::block_on;
use embedded_hal::i2c::ErrorKind;
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use embedded_hal_mock::eh1::spi::{Mock as SpiMock, Transaction as Spi};
use ironout_drivers::l3gd20::{self, L3gd20};
use ironout_drivers::lsm303_accelerometer::{Config, Lsm303Accelerometer, Model, Range};
use ironout_drivers::{Accelerometer, AsyncAccelerometer, AsyncGyroscope, Error, Gyroscope, asynch};

use crate::transactions::case::{rd, wr};

const G_MPS2: f32 = 9.806_65;

fn near(one: Option<[f32; 3]>, other: [f32; 3], tolerance: f32) -> bool {
    one.is_some_and(|one| one.into_iter().zip(other).all(|(one, other)| (one - other).abs() <= tolerance))
}

/// 1000, −500 and 8 counts, left-justified.
const ACCELERATION: [u8; 6] = [0x80, 0x3e, 0xc0, 0xe0, 0x80, 0x00];

fn accelerometer(config: Config, transactions: &[Transaction]) -> Result<Option<[f32; 3]>, Error<ErrorKind>> {
    let mut driver = Lsm303Accelerometer::new(Mock::new(transactions), config);
    let answer = driver.init().and_then(|()| driver.read_mps2());
    driver.destroy().done();
    let mut driver = asynch::Lsm303Accelerometer::new(Mock::new(transactions), config);
    let awaited = block_on(async {
        driver.init().await?;
        driver.read_mps2().await
    });
    assert_eq!(awaited, answer);
    driver.destroy().done();
    answer
}

#[test]
fn the_accelerometer_of_an_lsm303dlhc_reads_12_bits_in_metres_per_square_second() {
    let config = Config { range: Range::G4, ..Config::default() };
    let transactions = [
        wr(0x19, 0x20, 0x57),
        wr(0x19, 0x23, 0x98),
        rd(0x19, 0x20, &[0x57]),
        rd(0x19, 0x23, &[0x98]),
        rd(0x19, 0xa8, &ACCELERATION),
    ];
    let read = accelerometer(config, &transactions).unwrap();
    // 2 mg a count.
    assert!(near(read, [2.0, -1.0, 0.016].map(|g| g * G_MPS2), 1e-4), "{read:?}");
    for place in 0..transactions.len() {
        let failing =
            [&transactions[..place], &[transactions[place].clone().with_error(ErrorKind::Other)]].concat();
        assert_eq!(accelerometer(config, &failing), Err(Error::Bus(ErrorKind::Other)), "{place}");
    }
    // At the end of the range it is no measurement.
    let mut clipped = transactions[..4].to_vec();
    clipped.push(rd(0x19, 0xa8, &[0xf0, 0x7f, 0, 0, 0, 0]));
    assert_eq!(accelerometer(config, &clipped), Ok(None));
}

#[test]
fn the_accelerometer_of_an_lsm303agr_is_identified_and_reads_what_the_crate_of_that_name_reads() {
    let config = Config { model: Model::Lsm303agr, ..Config::default() };
    let transactions = [
        rd(0x19, 0x0f, &[0x33]),
        wr(0x19, 0x20, 0x57),
        wr(0x19, 0x23, 0x88),
        rd(0x19, 0x20, &[0x57]),
        rd(0x19, 0x23, &[0x88]),
        rd(0x19, 0xa8, &ACCELERATION),
    ];
    let read = accelerometer(config, &transactions).unwrap();
    assert!(near(read, [0.98, -0.49, 0.00784].map(|g| g * G_MPS2), 1e-4), "{read:?}");
    let refused = accelerometer(config, &[rd(0x19, 0x0f, &[0x00])]);
    assert_eq!(refused, Err(Error::NotFound { expected: [0x33, 0, 0], found: [0; 3] }));

    use embedded_hal_mock::eh1::delay::NoopDelay;
    use lsm303agr::{AccelMode, AccelOutputDataRate, Lsm303agr};
    let mut other = Lsm303agr::new_with_i2c(Mock::new(&[
        wr(0x19, 0x20, 0x57),
        wr(0x19, 0x23, 0x08),
        rd(0x19, 0xa8, &ACCELERATION),
    ]));
    other
        .set_accel_mode_and_odr(&mut NoopDelay::new(), AccelMode::HighResolution, AccelOutputDataRate::Hz100)
        .unwrap();
    let (x, y, z) = other.acceleration().unwrap().xyz_mg();
    other.destroy().done();
    // That crate takes a whole mg for a count where the datasheet has 0.98.
    let expected = [x, y, z].map(|mg| mg as f32 / 1000.0 * G_MPS2);
    assert!(near(read, expected, 0.021 * G_MPS2), "{read:?} {expected:?}");
}

#[test]
fn the_magnetometer_of_an_lsm303agr_reads_what_the_crate_of_that_name_reads() {
    use ironout_drivers::{Driver, Magnetometer, lis2mdl};
    let bytes = rd(0x1e, 0xe8, &[0x02, 0x01, 0xd4, 0xfe, 0x07, 0x00]);
    let other = lsm303agr::Lsm303agr::new_with_i2c(Mock::new(&[wr(0x1e, 0x60, 0x00), bytes.clone()]));
    let mut other = other.into_mag_continuous().expect("continuous");
    let (x, y, z) = other.magnetic_field().unwrap().xyz_nt();
    other.destroy().done();
    let mut driver = Driver::new(Mock::new(&[bytes]), lis2mdl::Config::of(lis2mdl::Model::Lsm303agr));
    let sensor = driver.describe();
    let field = sensor.measured_ut(sensor.sample(&driver.read().unwrap()));
    assert!(near(field, [x, y, z].map(|nt| nt as f32 / 1000.0), 1e-3), "{field:?}");
    driver.destroy().done();
}

const RATES: [u8; 6] = [0x02, 0x01, 0xd4, 0xfe, 0x07, 0x00];

/// 258, −300 and 7 counts of 17.5 m°/s.
fn expected_radps() -> [f32; 3] {
    [258.0, -300.0, 7.0].map(|counts: f32| (counts * 0.0175).to_radians())
}

#[test]
fn the_gyroscope_is_any_of_three_on_i2c() {
    let config = l3gd20::Config { range: l3gd20::Range::Dps500 };
    for (identity, model) in
        [(0xd4, l3gd20::Model::L3gd20), (0xd7, l3gd20::Model::L3gd20h), (0xd3, l3gd20::Model::I3g4250d)]
    {
        let transactions = [
            rd(0x6b, 0x0f, &[identity]),
            wr(0x6b, 0x20, 0x0f),
            wr(0x6b, 0x23, 0x90),
            rd(0x6b, 0x20, &[0x0f]),
            rd(0x6b, 0x23, &[0x90]),
            rd(0x6b, 0xa8, &RATES),
        ];
        let mut driver = L3gd20::new_i2c(Mock::new(&transactions), 0x6b, config);
        driver.init().unwrap();
        assert_eq!(driver.model(), Some(model));
        assert!(near(driver.read_radps().unwrap(), expected_radps(), 1e-6));
        driver.destroy().done();
        for place in 0..transactions.len() {
            let failing =
                [&transactions[..place], &[transactions[place].clone().with_error(ErrorKind::Other)]]
                    .concat();
            let mut driver = L3gd20::new_i2c(Mock::new(&failing), 0x6b, config);
            let answer = driver.init().and_then(|()| driver.read_radps());
            assert_eq!(answer, Err(Error::Bus(ErrorKind::Other)), "{place}");
            driver.destroy().done();
        }
    }
    let mut driver = L3gd20::new_i2c(Mock::new(&[rd(0x6b, 0x0f, &[0x00])]), 0x6b, config);
    assert_eq!(driver.init(), Err(Error::NotFound { expected: [0xd4, 0, 0], found: [0; 3] }));
    driver.destroy().done();
}

#[test]
fn the_gyroscope_on_spi_has_its_read_and_increment_bits() {
    let one = |first: u8, byte: u8| {
        vec![
            Spi::transaction_start(),
            Spi::write_vec(vec![first]),
            Spi::read_vec(vec![byte]),
            Spi::transaction_end(),
        ]
    };
    let put = |register: u8, byte: u8| {
        vec![Spi::transaction_start(), Spi::write_vec(vec![register, byte]), Spi::transaction_end()]
    };
    let mut transactions =
        [one(0x8f, 0xd4), put(0x20, 0x0f), put(0x23, 0x80), one(0xa0, 0x0f), one(0xa3, 0x80)].concat();
    transactions.extend([
        Spi::transaction_start(),
        Spi::write_vec(vec![0xe8]),
        Spi::read_vec(vec![0xff, 0x7f, 0, 0, 0, 0]),
        Spi::transaction_end(),
    ]);
    let mut driver = L3gd20::new_spi(SpiMock::new(&transactions), l3gd20::Config::default());
    driver.init().unwrap();
    assert_eq!(driver.read_radps(), Ok(None), "the end of the range");
    driver.destroy().done();
    let mut driver = asynch::L3gd20::new_spi(SpiMock::new(&transactions), l3gd20::Config::default());
    assert_eq!(block_on(async { driver.init().await }), Ok(()));
    assert_eq!(block_on(async { driver.read_radps().await }), Ok(None));
    driver.destroy().done();
}
