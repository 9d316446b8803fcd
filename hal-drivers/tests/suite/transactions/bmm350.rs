//! BMM350: its memory, its resets and its compensation.

use embedded_hal_mock::eh1::delay::NoopDelay;
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use ironout_drivers::bmm350::{self, Bmm350, Otp};
use ironout_drivers::{Error, Magnetometer};

use crate::transactions::case::{rd, wr};
use crate::transactions::own::each_fails;

/// A reading of the BMM350: two bytes without a meaning come first.
fn rd350(register: u8, bytes: &[u8]) -> Transaction {
    rd(0x14, register, &[&[0x7f, 0x7f], bytes].concat())
}

/// Words 0x0d to 0x16, and 0x18.
const OTP_WORDS: [u16; 11] =
    [0x0df8, 0x0fdb, 0x0a79, 0xf756, 0x050e, 0xe10c, 0x12ec, 0xfa07, 0xf90b, 0xe910, 0xfd44];

fn bmm350_init() -> Vec<Transaction> {
    let mut transactions = vec![rd350(0x00, &[0x33]), wr(0x14, 0x7e, 0xb6)];
    for (place, word) in OTP_WORDS.into_iter().enumerate() {
        let address = if place == 10 { 0x18 } else { 0x0d + place as u8 };
        let [high, low] = word.to_be_bytes();
        // The first takes a millisecond more.
        transactions.push(wr(0x14, 0x50, 0x20 | address));
        if place == 0 {
            transactions.push(rd350(0x55, &[0x00]));
        }
        transactions.extend([rd350(0x55, &[0x01]), rd350(0x52, &[high]), rd350(0x53, &[low])]);
    }
    transactions.extend([
        wr(0x14, 0x50, 0x80),
        wr(0x14, 0x06, 0x07),
        rd350(0x07, &[0xe0]),
        wr(0x14, 0x06, 0x05),
        rd350(0x07, &[0xa0]),
        rd350(0x00, &[0x33]),
        wr(0x14, 0x04, 0x14),
        wr(0x14, 0x05, 0x07),
        wr(0x14, 0x2e, 0x80),
        rd350(0x04, &[0x14, 0x07]),
        rd350(0x2e, &[0x80]),
        wr(0x14, 0x06, 0x02),
        rd350(0x07, &[0x40]),
        wr(0x14, 0x06, 0x01),
        rd350(0x07, &[0x28]),
    ]);
    transactions
}

#[test]
fn bmm350_reads_its_memory_is_magnetically_reset_and_started() {
    each_fails(&bmm350_init(), |bus| {
        let mut driver = Bmm350::new(bus, NoopDelay::new(), bmm350::Config::default());
        (driver.init(), driver.destroy().0)
    });
    let mut driver = Bmm350::new(Mock::new(&bmm350_init()), NoopDelay::new(), bmm350::Config::default());
    driver.init().unwrap();
    let expected = Otp {
        offset: [-37, 121, -1450],
        sensitivity: [-9, 14, 5],
        offset_drift: [12, -20, 7],
        sensitivity_drift: [-31, 18, -6],
        cross: [11, -7, 16, -23],
        celsius_offset: -8,
        celsius_sensitivity: 13,
        reference: -700,
    };
    assert_eq!(driver.otp(), expected);
    driver.destroy().0.done();
}

#[test]
fn bmm350_says_what_it_did_not_do() {
    let whole = bmm350_init();
    let until = |wanted: Transaction, answer: Transaction| {
        let place = whole.iter().position(|transaction| *transaction == wanted).unwrap();
        [&whole[..place], &[answer]].concat()
    };
    let cases = [
        (vec![rd350(0x00, &[0x32])], Error::NotFound { expected: [0x33, 0, 0], found: [0x32, 0, 0] }),
        (
            vec![rd350(0x00, &[0x33]), wr(0x14, 0x7e, 0xb6), wr(0x14, 0x50, 0x2d), rd350(0x55, &[0x41])],
            Error::NotKept { register: 0x50, written: 0x2d, read: 0x41 },
        ),
        (
            until(rd350(0x07, &[0xa0]), rd350(0x07, &[0xe1])),
            Error::NotKept { register: 0x06, written: 0x05, read: 0xe1 },
        ),
        (
            until(rd350(0x07, &[0x28]), rd350(0x07, &[0x20])),
            Error::NotKept { register: 0x06, written: 0x01, read: 0x20 },
        ),
    ];
    for (transactions, error) in cases {
        let mut driver = Bmm350::new(Mock::new(&transactions), NoopDelay::new(), bmm350::Config::default());
        assert_eq!(driver.init(), Err(error));
        driver.destroy().0.done();
    }
}

#[test]
fn bmm350_compensates_as_published() {
    // Bosch's formula with this chip's numbers, in double precision and by hand of another: 20 000, −3000 and 9000 counts at
    // 51 936 counts of temperature.
    let words: [u16; 10] = OTP_WORDS[..10].try_into().unwrap();
    let otp = Otp::of(words, OTP_WORDS[10]);
    let t = (1.0 + 13.0 / 512.0) * (51_936.0 * 0.000_981_282 - 25.49) - 8.0 / 5.0;
    let warmer = t - (-700.0 / 512.0 + 23.0);
    let x = (20_000.0 * 0.007_069_979 * (1.0 - 9.0 / 256.0) - 37.0 + 12.0 / 32.0 * warmer)
        / (1.0 - 31.0 / 16_384.0 * warmer);
    let y = (-3000.0 * 0.007_069_979 * (1.0 + 14.0 / 256.0 + 0.01) + 121.0 - 20.0 / 32.0 * warmer)
        / (1.0 + 18.0 / 16_384.0 * warmer);
    let z = (9000.0 * 0.007_174_964 * (1.0 + 5.0 / 256.0) - 1450.0 + 7.0 / 32.0 * warmer)
        / (1.0 + (-6.0 / 16_384.0 - 0.0001) * warmer);
    let (xy, yx, zx, zy) = (11.0 / 800.0, -7.0 / 800.0, 16.0 / 800.0, -23.0 / 800.0);
    let flat = 1.0 - yx * xy;
    let published =
        [(x - xy * y) / flat, (y - yx * x) / flat, z + (x * (yx * zy - zx) - y * (zy - xy * zx)) / flat];
    let celsius = otp.celsius(51_936);
    assert!((f64::from(celsius) - t).abs() < 1e-4, "{celsius} {t}");
    let field = otp.compensate([20_000, -3000, 9000], celsius);
    for axis in 0..3 {
        assert!((f64::from(field[axis]) - published[axis]).abs() < 1e-3, "{field:?} {published:?}");
    }
}

#[test]
fn no_memory_of_a_bmm350_is_a_panic_or_a_measurement_that_is_none() {
    use ironout_drivers::Chip;
    for byte in 0..=u8::MAX {
        let word = u16::from_le_bytes([byte, byte.wrapping_mul(37)]);
        let trimmed = bmm350::Trimmed { otp: Otp::of([word; 10], word), config: bmm350::Config::default() };
        for bytes in [[0x00; 12], [0xff; 12], [0x80; 12], [0x7f; 12]] {
            let reading = trimmed.decode(&bytes);
            for (count, beyond) in reading.counts.into_iter().zip(reading.overflow) {
                assert!(beyond || count.unsigned_abs() <= 32_000, "{reading:?}");
            }
        }
    }
}

#[test]
fn bmm350_reads_21_bits_after_two_bytes_without_a_meaning() {
    let mut transactions = bmm350_init();
    let outputs = |x: i32, y: i32, z: i32, t: i32| {
        let bytes = [x, y, z, t].map(|count| [count as u8, (count >> 8) as u8, (count >> 16) as u8]);
        rd350(0x31, bytes.as_flattened())
    };
    transactions.extend([rd350(0x30, &[0x04]), outputs(0, 0, 0, 0)]);
    transactions.extend([rd350(0x30, &[0x00]), rd350(0x30, &[0x04])]);
    transactions.extend([outputs(20_000, -3000, 1_048_575, 51_936), rd350(0x3b, &[0xca, 0x00])]);
    let mut driver = Bmm350::new(Mock::new(&transactions), NoopDelay::new(), bmm350::Config::default());
    driver.init().unwrap();
    // The first is of the configuration before.
    for ready in [false, false, true] {
        assert_eq!(driver.data_ready(), Ok(ready));
    }
    let reading = driver.read().unwrap();
    let field = driver.otp().compensate([20_000, -3000, 1_048_575], driver.otp().celsius(51_936));
    assert_eq!(reading.overflow, [false, false, true]);
    for axis in 0..2 {
        assert!(
            (f32::from(reading.counts[axis]) / 16.0 - field[axis]).abs() <= 0.032,
            "{reading:?} {field:?}"
        );
    }
    let celsius = driver.temperature_c().unwrap().unwrap();
    assert!((celsius - driver.otp().celsius(51_712)).abs() < 1e-3, "{celsius}");
    driver.destroy().0.done();
}
