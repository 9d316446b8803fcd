//! The chips whose sequence on the bus is their own.

use embedded_hal::i2c::ErrorKind;
use embedded_hal_mock::eh1::delay::NoopDelay;
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use ironout_drivers::bmm150::{self, Bmm150, Trim};
use ironout_drivers::icm20948::{self, Icm20948};
use ironout_drivers::mmc5603::{self, Mmc5603};
use ironout_drivers::mmc5983ma::{self, Mmc5983ma};
use ironout_drivers::{Error, Magnetometer};

use crate::transactions::case::{rd, wr};

/// An operation of which each transaction fails in turn.
pub fn each_fails(
    transactions: &[Transaction],
    operation: impl Fn(Mock) -> (Result<(), Error<ErrorKind>>, Mock),
) {
    for place in 0..transactions.len() {
        let failing =
            [&transactions[..place], &[transactions[place].clone().with_error(ErrorKind::Other)]].concat();
        let (answer, mut bus) = operation(Mock::new(&failing));
        assert_eq!(answer, Err(Error::Bus(ErrorKind::Other)), "transaction {place}");
        bus.done();
    }
    let (answer, mut bus) = operation(Mock::new(transactions));
    assert_eq!(answer, Ok(()));
    bus.done();
}

/// A trimming: x1 … xy1, with those registers between that have no meaning.
const TRIMMING: [u8; 21] =
    [1, 0xfe, 0, 0, 0, 30, 0, 26, 27, 0, 0, 0x80, 0x02, 0xcc, 0x5b, 0xc8, 0x19, 25, 0, 0xfd, 29];

fn bmm150_init() -> Vec<Transaction> {
    vec![
        wr(0x10, 0x4b, 0x01),
        rd(0x10, 0x40, &[0x32]),
        rd(0x10, 0x5d, &TRIMMING),
        rd(0x10, 0x40, &[0x32]),
        wr(0x10, 0x51, 4),
        wr(0x10, 0x52, 14),
        wr(0x10, 0x4c, 0x38),
        rd(0x10, 0x51, &[4, 14]),
        rd(0x10, 0x4c, &[0x38]),
    ]
}

#[test]
fn bmm150_is_woken_identified_trimmed_and_configured() {
    each_fails(&bmm150_init(), |bus| {
        let mut driver = Bmm150::new(bus, NoopDelay::new(), bmm150::Config::default());
        (driver.init(), driver.destroy().0)
    });
    let mut driver = Bmm150::new(Mock::new(&bmm150_init()), NoopDelay::new(), bmm150::Config::default());
    driver.init().unwrap();
    let expected = Trim {
        x1: 1,
        y1: -2,
        x2: 26,
        y2: 27,
        z1: 23_500,
        z2: 640,
        z3: 25,
        z4: 30,
        xy1: 29,
        xy2: -3,
        xyz1: 6600,
    };
    assert_eq!(driver.trim(), expected);
    driver.destroy().0.done();

    let mut driver = Bmm150::new(
        Mock::new(&[wr(0x10, 0x4b, 0x01), rd(0x10, 0x40, &[0x00])]),
        NoopDelay::new(),
        bmm150::Config::default(),
    );
    assert_eq!(driver.init(), Err(Error::NotFound { expected: [0x32, 0, 0], found: [0; 3] }));
    driver.destroy().0.done();

    let blank = [wr(0x10, 0x4b, 0x01), rd(0x10, 0x40, &[0x32]), rd(0x10, 0x5d, &[0; 21])];
    let mut driver = Bmm150::new(Mock::new(&blank), NoopDelay::new(), bmm150::Config::default());
    assert!(matches!(driver.init(), Err(Error::InvalidConfig(_))), "a chip without trimming");
    driver.destroy().0.done();
}

/// The published compensation in floating point, µT.
fn compensated_ut(trim: &Trim, [x, y, z]: [i16; 3], hall: u16) -> [f64; 3] {
    let hall = f64::from(hall);
    let off = f64::from(trim.xyz1) * 16_384.0 / hall - 16_384.0;
    let gain = f64::from(trim.xy2) * off * off / 268_435_456.0 + off * f64::from(trim.xy1) / 16_384.0 + 256.0;
    let flat = |count: i16, first: i8, second: i8| {
        (f64::from(count) * gain * (f64::from(second) + 160.0) / 8192.0 + f64::from(first) * 8.0) / 16.0
    };
    let slope = f64::from(trim.z2) + f64::from(trim.z1) * hall / 32_768.0;
    let drift = f64::from(trim.z3) * (hall - f64::from(trim.xyz1));
    let up = ((f64::from(z) - f64::from(trim.z4)) * 131_072.0 - drift) / (slope * 4.0) / 16.0;
    [flat(x, trim.x1, trim.x2), flat(y, trim.y1, trim.y2), up]
}

#[test]
fn the_compensation_in_integers_is_the_one_in_floating_point_to_a_count() {
    let trim = Trim::of(TRIMMING);
    for hall in [5800, 6300, 6600, 6900, 7600] {
        for [x, y, z] in [[0, 0, 0], [150, -300, 900], [-1200, 2000, -7000], [4000, -4000, 16_000]] {
            let integers = trim.compensate([x, y, z], hall).map(|count| f64::from(count) / 16.0);
            let floats = compensated_ut(&trim, [x, y, z], hall);
            for axis in 0..3 {
                let error_ut = (integers[axis] - floats[axis]).abs();
                // A sixteenth, and the rounding of the gain's twelve bits.
                assert!(
                    error_ut < 0.0625 + 1e-4 * floats[axis].abs(),
                    "{hall} axis {axis}: {integers:?} {floats:?}"
                );
            }
        }
    }
}

#[test]
fn no_trimming_and_no_hall_resistance_is_a_panic() {
    for byte in 0..=u8::MAX {
        let trim = Trim::of([byte; 21]);
        for hall in [0, 1, 0x3fff] {
            for count in [i16::MIN, -1, 0, 1, i16::MAX] {
                trim.compensate([count; 3], hall);
            }
        }
    }
    Trim::default().compensate([i16::MIN; 3], 0);
}

#[test]
fn bmm150_reads_13_and_15_bits_and_its_overflows() {
    let read = |bytes: [u8; 8]| {
        let mut transactions = bmm150_init();
        transactions.extend([rd(0x10, 0x48, &[0x01]), rd(0x10, 0x42, &[0; 8])]);
        transactions.extend([rd(0x10, 0x48, &[0x00]), rd(0x10, 0x48, &[0x01]), rd(0x10, 0x42, &bytes)]);
        let mut driver = Bmm150::new(Mock::new(&transactions), NoopDelay::new(), bmm150::Config::default());
        driver.init().unwrap();
        // The first is of the configuration before.
        assert_eq!(driver.data_ready(), Ok(false));
        assert_eq!(driver.data_ready(), Ok(false));
        assert_eq!(driver.data_ready(), Ok(true));
        let reading = driver.read().unwrap();
        assert_eq!(driver.temperature_c(), Ok(None));
        driver.destroy().0.done();
        reading
    };
    let hall = 6600_u16 << 2 | 1;
    let raw = |x: i16, y: i16, z: i16| {
        let [x, y, z] = [x << 3 | 1, y << 3 | 1, z << 1 | 1].map(i16::to_le_bytes);
        let hall = hall.to_le_bytes();
        [x[0], x[1], y[0], y[1], z[0], z[1], hall[0], hall[1]]
    };
    let reading = read(raw(150, -300, 900));
    let expected = compensated_ut(&Trim::of(TRIMMING), [150, -300, 900], 6600);
    for axis in 0..3 {
        assert!(
            (f64::from(reading.counts[axis]) / 16.0 - expected[axis]).abs() < 0.08,
            "{reading:?} {expected:?}"
        );
    }
    assert_eq!(read(raw(-4096, 0, 0)).overflow, [true, false, false]);
    assert_eq!(read(raw(0, -4096, 0)).overflow, [false, true, false]);
    assert_eq!(read(raw(0, 0, -16_384)).overflow, [false, false, true]);
}

#[test]
fn icm20948_is_woken_and_its_bypass_opened_before_its_magnetometer_is_asked() {
    let init = [
        wr(0x69, 0x7f, 0x00),
        rd(0x69, 0x00, &[0xea]),
        wr(0x69, 0x06, 0x01),
        wr(0x69, 0x03, 0x00),
        wr(0x69, 0x0f, 0x02),
        rd(0x69, 0x06, &[0x01]),
        rd(0x69, 0x03, &[0x00]),
        rd(0x69, 0x0f, &[0x02]),
        rd(0x0c, 0x00, &[0x48, 0x09]),
        wr(0x0c, 0x31, 0x00),
        wr(0x0c, 0x32, 0x00),
        wr(0x0c, 0x31, 0x08),
        rd(0x0c, 0x31, &[0x08]),
    ];
    let config = icm20948::Config { address: 0x69, ..Default::default() };
    each_fails(&init, |bus| {
        let mut driver = Icm20948::new(bus, config);
        (driver.init(), driver.destroy())
    });
    let mut driver = Icm20948::new(Mock::new(&[wr(0x69, 0x7f, 0), rd(0x69, 0x00, &[0x71])]), config);
    assert_eq!(driver.init(), Err(Error::NotFound { expected: [0xea, 0, 0], found: [0x71, 0, 0] }));
    driver.destroy().done();
}

fn mmc_init() -> Vec<Transaction> {
    vec![
        rd(0x30, 0x2f, &[0x30]),
        wr(0x30, 0x0a, 0x00),
        wr(0x30, 0x0c, 0x00),
        wr(0x30, 0x0b, 0x00),
        wr(0x30, 0x08, 0x03),
        wr(0x30, 0x09, 0x02),
    ]
}

/// The seven bytes of 18-bit outputs.
fn mmc_bytes(counts: [u32; 3]) -> [u8; 7] {
    let [x, y, z] = counts;
    let low = (x & 3) << 6 | (y & 3) << 4 | (z & 3) << 2;
    [
        (x >> 10) as u8,
        (x >> 2) as u8,
        (y >> 10) as u8,
        (y >> 2) as u8,
        (z >> 10) as u8,
        (z >> 2) as u8,
        low as u8,
    ]
}

/// From the configuration to continuous measurements: temperature, after SET, after RESET, after SET.
fn mmc_offset() -> Vec<Transaction> {
    let measured =
        |counts| [rd(0x30, 0x08, &[0x01]), rd(0x30, 0x00, &mmc_bytes(counts)), wr(0x30, 0x08, 0x01)];
    let mut transactions = vec![
        rd(0x30, 0x08, &[0x00]),
        rd(0x30, 0x08, &[0x02]),
        rd(0x30, 0x07, &[120]),
        wr(0x30, 0x09, 0x08),
        wr(0x30, 0x09, 0x01),
    ];
    // A field of 1000, −2000 and 3000 counts, offsets of 100, 50 and −8.
    transactions.extend(measured([131_072 + 1100, 131_072 - 1950, 131_072 + 2992]));
    transactions.extend([wr(0x30, 0x09, 0x10), wr(0x30, 0x09, 0x01)]);
    transactions.extend(measured([131_072 - 900, 131_072 + 2050, 131_072 - 3008]));
    transactions.extend([wr(0x30, 0x09, 0x08), wr(0x30, 0x09, 0x01)]);
    transactions.extend(measured([131_072 + 1100, 131_072 - 1950, 131_072 + 2992]));
    transactions.push(wr(0x30, 0x0b, 0x0d));
    transactions
}

#[test]
fn mmc5983ma_measures_its_offset_by_set_and_reset_and_takes_it_out() {
    each_fails(&mmc_init(), |bus| {
        let mut driver = Mmc5983ma::new(bus, mmc5983ma::Config::default());
        (driver.init(), driver.destroy())
    });
    let mut transactions = mmc_init();
    transactions.extend(mmc_offset());
    transactions.extend([rd(0x30, 0x08, &[0x00]), rd(0x30, 0x08, &[0x01])]);
    transactions.extend([
        rd(0x30, 0x00, &mmc_bytes([131_072 + 1100, 131_072 - 1950, 262_143])),
        wr(0x30, 0x08, 0x01),
    ]);
    let mut driver =
        Mmc5983ma::new(Mock::new(&transactions), mmc5983ma::Config { shift: 0, ..Default::default() });
    driver.init().unwrap();
    assert_eq!(driver.temperature_c(), Ok(None));
    // Not yet, temperature, three measurements; then none, and one.
    for ready in [false, false, false, false, false, false, true] {
        assert_eq!(driver.data_ready(), Ok(ready));
    }
    assert_eq!(driver.temperature_c(), Ok(Some(21.0)));
    let reading = driver.read().unwrap();
    assert_eq!(
        reading.counts,
        [1000, -2000, i16::MAX],
        "four times the field that 16 bits hold is out of range"
    );
    assert_eq!(reading.overflow, [false, false, true]);
    driver.destroy().done();
}

#[test]
fn mmc5983ma_begins_anew_where_the_bus_failed_between() {
    let steps = mmc_offset();
    for place in 0..steps.len() {
        let mut transactions = mmc_init();
        transactions.extend(steps[..place].iter().cloned());
        transactions.push(steps[place].clone().with_error(ErrorKind::ArbitrationLoss));
        let mut driver = Mmc5983ma::new(Mock::new(&transactions), mmc5983ma::Config::default());
        driver.init().unwrap();
        let failed = loop {
            match driver.data_ready() {
                Ok(ready) => assert!(!ready),
                Err(error) => break error,
            }
        };
        assert_eq!(failed, Error::Bus(ErrorKind::ArbitrationLoss));
        driver.destroy().done();
    }
}

/// The nine bytes of 20-bit outputs.
fn mmc5603_bytes(counts: [u32; 3]) -> [u8; 9] {
    let [x, y, z] = counts;
    let [high, middle, low] = [12, 4, 0].map(|shift| counts.map(|count| (count >> shift) as u8));
    debug_assert!(x | y | z < 1 << 20);
    [high[0], middle[0], high[1], middle[1], high[2], middle[2], low[0] << 4, low[1] << 4, low[2] << 4]
}

fn mmc5603_init() -> Vec<Transaction> {
    vec![
        rd(0x30, 0x39, &[0x10]),
        wr(0x30, 0x1c, 0x00),
        wr(0x30, 0x1d, 0x00),
        wr(0x30, 0x18, 0xc0),
        wr(0x30, 0x1b, 0x02),
    ]
}

#[test]
fn mmc5603_measures_its_offset_by_set_and_reset_and_takes_it_out() {
    each_fails(&mmc5603_init(), |bus| {
        let mut driver = Mmc5603::new(bus, NoopDelay::new(), mmc5603::Config::default());
        (driver.init(), driver.destroy().0)
    });
    let measured =
        |counts| [rd(0x30, 0x18, &[0x40]), rd(0x30, 0x00, &mmc5603_bytes(counts)), wr(0x30, 0x18, 0x40)];
    let zero = 524_288;
    let mut transactions = mmc5603_init();
    transactions.extend([rd(0x30, 0x18, &[0x50]), rd(0x30, 0x18, &[0x90]), rd(0x30, 0x09, &[120])]);
    // A field of 1000, −2000 and 3000 counts, offsets of 100, 50 and −8.
    transactions.extend([wr(0x30, 0x1b, 0x08), wr(0x30, 0x1b, 0x01)]);
    transactions.extend(measured([zero + 1100, zero - 1950, zero + 2992]));
    transactions.extend([wr(0x30, 0x1b, 0x10), wr(0x30, 0x1b, 0x01)]);
    transactions.extend(measured([zero - 900, zero + 2050, zero - 3008]));
    transactions.extend([wr(0x30, 0x1b, 0x08), wr(0x30, 0x1b, 0x01)]);
    transactions.extend(measured([zero + 1100, zero - 1950, zero + 2992]));
    transactions.extend([wr(0x30, 0x1a, 75), wr(0x30, 0x1b, 0x80), wr(0x30, 0x1d, 0x10)]);
    transactions.extend(measured([zero + 1100, zero - 1950, zero + 491_521]));
    let config = mmc5603::Config { shift: 0, ..Default::default() };
    let mut driver = Mmc5603::new(Mock::new(&transactions), NoopDelay::new(), config);
    driver.init().unwrap();
    // The flag of the field while the temperature is waited for, the temperature, three measurements, and one.
    for ready in [false, false, false, false, false, true] {
        assert_eq!(driver.data_ready(), Ok(ready));
    }
    assert_eq!(driver.temperature_c(), Ok(Some(21.0)));
    let reading = driver.read().unwrap();
    assert_eq!(reading.counts, [1000, -2000, i16::MAX]);
    assert_eq!(reading.overflow, [false, false, true]);
    driver.destroy().0.done();
}
