//! The chips that are a register map.

use ironout_drivers::{Driver, Magnetometer};
use ironout_drivers::{
    Error, Reading, ak09916, hmc5883l, ist8310, lis2mdl, lis3mdl, lsm303dlhc, qmc5883l, qmc5883p, qmc6309,
    qmc6310, rm3100,
};

use crate::transactions::case::{Case, counts, rd, wr};
use embedded_hal_mock::eh1::i2c::Mock;

#[test]
fn lis2mdl() {
    let mut init = vec![rd(0x1e, 0x4f, &[0x40])];
    init.extend((0x45..=0x4a).map(|offset| wr(0x1e, offset, 0)));
    init.extend([wr(0x1e, 0x60, 0x8c), wr(0x1e, 0x61, 0x02), wr(0x1e, 0x62, 0x10)]);
    // Bit 7 lets the pointer go on.
    init.extend([rd(0x1e, 0xc5, &[0; 6]), rd(0x1e, 0xe0, &[0x8c, 0x02, 0x10])]);
    let read = |bytes: [u8; 6]| vec![rd(0x1e, 0xe8, &bytes)];
    Case {
        config: lis2mdl::Config::default(),
        init,
        identity: ([0x40, 0, 0], rd(0x1e, 0x4f, &[0x33]), [0x33, 0, 0]),
        ready: vec![rd(0x1e, 0x67, &[0x0f])],
        not_ready: vec![rd(0x1e, 0x67, &[0x07])],
        readings: vec![
            (read([0x02, 0x01, 0xd4, 0xfe, 0x07, 0x00]), counts([258, -300, 7])),
            (
                read([0xff, 0x7f, 0x00, 0x80, 0xfe, 0x7f]),
                Reading { counts: [i16::MAX, i16::MIN, 32_766], overflow: [true, true, false] },
            ),
        ],
        celsius: vec![
            (vec![rd(0x1e, 0xee, &[0x00, 0x00])], Some(25.0)),
            // −282 eighths of a degree.
            (vec![rd(0x1e, 0xee, &[0xe6, 0xfe])], Some(-10.25)),
        ],
    }
    .run();
}

#[test]
fn lsm303agr_has_no_temperature_and_other_rates_have_other_bytes() {
    use lis2mdl::{Config, DataRate, Model};
    let config =
        Config { rate: DataRate::Hz20, low_pass: true, data_ready_pin: true, ..Config::of(Model::Lsm303agr) };
    let mut init = vec![rd(0x1e, 0x4f, &[0x40])];
    init.extend((0x45..=0x4a).map(|offset| wr(0x1e, offset, 0)));
    init.extend([wr(0x1e, 0x60, 0x84), wr(0x1e, 0x61, 0x03), wr(0x1e, 0x62, 0x11)]);
    init.extend([rd(0x1e, 0xc5, &[0; 6]), rd(0x1e, 0xe0, &[0x84, 0x03, 0x11])]);
    let mut driver = Driver::new(Mock::new(&init), config);
    assert_eq!((driver.init(), driver.temperature_c()), (Ok(()), Ok(None)));
    assert_eq!(driver.describe().rate_hz, 20.0);
    driver.destroy().done();
}

#[test]
fn a_register_that_does_not_keep_its_value_is_named_with_it() {
    let mut transactions = vec![rd(0x1e, 0x4f, &[0x40])];
    transactions.extend((0x45..=0x4a).map(|offset| wr(0x1e, offset, 0)));
    transactions.extend([wr(0x1e, 0x60, 0x8c), wr(0x1e, 0x61, 0x02), wr(0x1e, 0x62, 0x10)]);
    transactions.extend([rd(0x1e, 0xc5, &[0; 6]), rd(0x1e, 0xe0, &[0x8c, 0x00, 0x10])]);
    let mut driver = Driver::new(Mock::new(&transactions), lis2mdl::Config::default());
    assert_eq!(driver.init(), Err(Error::NotKept { register: 0x61, written: 0x02, read: 0x00 }));
    driver.destroy().done();
}

#[test]
fn lis3mdl() {
    let read = |bytes: [u8; 6]| vec![rd(0x1c, 0xa8, &bytes)];
    Case {
        config: lis3mdl::Config::default(),
        init: vec![
            rd(0x1c, 0x0f, &[0x3d]),
            wr(0x1c, 0x20, 0xfc),
            wr(0x1c, 0x21, 0x00),
            wr(0x1c, 0x22, 0x00),
            wr(0x1c, 0x23, 0x0c),
            wr(0x1c, 0x24, 0x40),
            rd(0x1c, 0xa0, &[0xfc, 0x00, 0x00, 0x0c, 0x40]),
        ],
        identity: ([0x3d, 0, 0], rd(0x1c, 0x0f, &[0x3f]), [0x3f, 0, 0]),
        ready: vec![rd(0x1c, 0x27, &[0x08])],
        not_ready: vec![rd(0x1c, 0x27, &[0xf7])],
        readings: vec![
            (read([0x02, 0x01, 0xd4, 0xfe, 0x07, 0x00]), counts([258, -300, 7])),
            (
                read([0, 0, 0xff, 0x7f, 0, 0]),
                Reading { counts: [0, i16::MAX, 0], overflow: [false, true, false] },
            ),
        ],
        celsius: vec![(vec![rd(0x1c, 0xae, &[0xe6, 0xfe])], Some(-10.25))],
    }
    .run();
    use lis3mdl::{Config, DataRate, Range};
    let config = Config { address: 0x1e, range: Range::Gauss16, rate: DataRate::Hz155 };
    let mut driver = Driver::new(
        Mock::new(&[
            rd(0x1e, 0x0f, &[0x3d]),
            wr(0x1e, 0x20, 0xe2),
            wr(0x1e, 0x21, 0x60),
            wr(0x1e, 0x22, 0x00),
            wr(0x1e, 0x23, 0x0c),
            wr(0x1e, 0x24, 0x40),
            rd(0x1e, 0xa0, &[0xe2, 0x60, 0x00, 0x0c, 0x40]),
        ]),
        config,
    );
    assert_eq!(driver.init(), Ok(()));
    assert_eq!(driver.describe().ut_per_count, [100.0 / 1711.0; 3]);
    driver.destroy().done();
}

#[test]
fn lsm303dlhc() {
    let read = |bytes: [u8; 6]| vec![rd(0x1e, 0x03, &bytes)];
    Case {
        config: lsm303dlhc::Config::default(),
        init: vec![
            rd(0x1e, 0x0a, b"H43"),
            wr(0x1e, 0x00, 0x98),
            wr(0x1e, 0x01, 0x20),
            wr(0x1e, 0x02, 0x00),
            rd(0x1e, 0x00, &[0x98, 0x20, 0x00]),
        ],
        identity: (*b"H43", rd(0x1e, 0x0a, b"H5\0"), *b"H5\0"),
        ready: vec![rd(0x1e, 0x09, &[0x03])],
        not_ready: vec![rd(0x1e, 0x09, &[0x02])],
        readings: vec![(read([0x01, 0x02, 0xfe, 0xd4, 0x00, 0x07]), counts([258, 7, -300]))],
        celsius: vec![(
            vec![rd(0x1e, 0x31, &[0x0a]), rd(0x1e, 0x32, &[0xc0]), rd(0x1e, 0x31, &[0x0a])],
            Some(21.5),
        )],
    }
    .run();
}

#[test]
fn hmc5883l() {
    let read = |bytes: [u8; 6]| vec![rd(0x1e, 0x03, &bytes)];
    Case {
        config: hmc5883l::Config::default(),
        init: vec![
            rd(0x1e, 0x0a, b"H43"),
            wr(0x1e, 0x00, 0x78),
            wr(0x1e, 0x01, 0x20),
            wr(0x1e, 0x02, 0x00),
            rd(0x1e, 0x00, &[0x78, 0x20, 0x00]),
        ],
        identity: (*b"H43", rd(0x1e, 0x0a, &[0, 0, 0]), [0, 0, 0]),
        ready: vec![rd(0x1e, 0x09, &[0x01])],
        not_ready: vec![rd(0x1e, 0x09, &[0x02])],
        readings: vec![
            // x, z, y.
            (read([0x01, 0x02, 0xfe, 0xd4, 0x00, 0x07]), counts([258, 7, -300])),
            (
                read([0xf0, 0x00, 0x07, 0xff, 0xf8, 0x00]),
                Reading { counts: [-4096, -2048, 2047], overflow: [true, false, false] },
            ),
        ],
        celsius: vec![(vec![], None)],
    }
    .run();
    for (place, range) in hmc5883l::Range::ALL.into_iter().enumerate() {
        assert_eq!(usize::from(range.bits() >> 5), place, "datasheet table 9");
    }
}

#[test]
fn qmc5883l() {
    let read = |bytes: [u8; 7]| vec![rd(0x0d, 0x00, &bytes)];
    Case {
        config: qmc5883l::Config::default(),
        init: vec![
            rd(0x0d, 0x0d, &[0xff]),
            wr(0x0d, 0x0a, 0x00),
            wr(0x0d, 0x0b, 0x01),
            wr(0x0d, 0x09, 0x19),
            rd(0x0d, 0x0a, &[0x00, 0x01]),
            rd(0x0d, 0x09, &[0x19]),
        ],
        identity: ([0xff, 0, 0], rd(0x0d, 0x0d, &[0x00]), [0, 0, 0]),
        ready: vec![rd(0x0d, 0x06, &[0x01])],
        not_ready: vec![rd(0x0d, 0x06, &[0x06])],
        readings: vec![
            (read([0x02, 0x01, 0xd4, 0xfe, 0x07, 0x00, 0x01]), counts([258, -300, 7])),
            // Flagged: the axis at its end, or all where none is.
            (
                read([0xff, 0x7f, 0, 0, 0, 0, 0x03]),
                Reading { counts: [i16::MAX, 0, 0], overflow: [true, false, false] },
            ),
            (read([1, 0, 2, 0, 3, 0, 0x03]), Reading { counts: [1, 2, 3], overflow: [true; 3] }),
        ],
        celsius: vec![(vec![rd(0x0d, 0x07, &[0x18, 0xfc])], Some(-10.0))],
    }
    .run();
}

#[test]
fn qmc5883p() {
    let read = |bytes: [u8; 9]| vec![rd(0x2c, 0x01, &bytes)];
    Case {
        config: qmc5883p::Config::default(),
        init: vec![
            rd(0x2c, 0x00, &[0x80]),
            wr(0x2c, 0x29, 0x06),
            wr(0x2c, 0x0b, 0x08),
            wr(0x2c, 0x0a, 0x09),
            rd(0x2c, 0x29, &[0x06]),
            rd(0x2c, 0x0b, &[0x08]),
            rd(0x2c, 0x0a, &[0x09]),
        ],
        identity: ([0x80, 0, 0], rd(0x2c, 0x00, &[0x81]), [0x81, 0, 0]),
        ready: vec![rd(0x2c, 0x09, &[0x01])],
        not_ready: vec![rd(0x2c, 0x09, &[0x02])],
        readings: vec![
            (read([0x02, 0x01, 0xd4, 0xfe, 0x07, 0x00, 0, 0, 0x01]), counts([258, -300, 7])),
            (read([1, 0, 2, 0, 3, 0, 0, 0, 0x03]), Reading { counts: [1, 2, 3], overflow: [true; 3] }),
        ],
        celsius: vec![(vec![], None)],
    }
    .run();
    assert_eq!(qmc5883p::Range::ALL.map(|range| range.bits()), [0x0c, 0x08, 0x04, 0x00]);
}

#[test]
fn qmc6310() {
    let read = |bytes: [u8; 6]| vec![rd(0x1c, 0x01, &bytes)];
    Case {
        config: qmc6310::Config::default(),
        init: vec![
            rd(0x1c, 0x00, &[0x80]),
            wr(0x1c, 0x0a, 0x00),
            wr(0x1c, 0x29, 0x06),
            wr(0x1c, 0x0b, 0x08),
            wr(0x1c, 0x0a, 0x09),
            rd(0x1c, 0x29, &[0x06]),
            rd(0x1c, 0x0b, &[0x08]),
            rd(0x1c, 0x0a, &[0x09]),
        ],
        identity: ([0x80, 0, 0], rd(0x1c, 0x00, &[0x90]), [0x90, 0, 0]),
        ready: vec![rd(0x1c, 0x09, &[0x01])],
        not_ready: vec![rd(0x1c, 0x09, &[0x02])],
        readings: vec![
            (read([0x02, 0x01, 0xd4, 0xfe, 0x07, 0x00]), counts([258, -300, 7])),
            // 30 000 is the last that is a measurement.
            (
                read([0x31, 0x75, 0xcf, 0x8a, 0x30, 0x75]),
                Reading { counts: [30_001, -30_001, 30_000], overflow: [true, true, false] },
            ),
        ],
        celsius: vec![(vec![], None)],
    }
    .run();
    for (range, ut) in qmc6310::Range::ALL.into_iter().zip([200.0_f32, 800.0, 1200.0, 3000.0]) {
        let sensor = Driver::new(Mock::new(&[]), qmc6310::Config { range, ..Default::default() });
        let most = sensor.describe().ut_per_count[0] * f32::from(sensor.describe().full_scale_counts);
        assert!((most - ut).abs() < 0.01, "{range:?}: {most}");
        sensor.destroy().done();
    }
}

#[test]
fn qmc6309() {
    let read = |bytes: [u8; 6]| vec![rd(0x7c, 0x01, &bytes)];
    Case {
        config: qmc6309::Config::default(),
        init: vec![
            rd(0x7c, 0x00, &[0x90]),
            wr(0x7c, 0x0a, 0x00),
            wr(0x7c, 0x0b, 0x38),
            wr(0x7c, 0x0a, 0x01),
            rd(0x7c, 0x0b, &[0x38]),
            rd(0x7c, 0x0a, &[0x01]),
        ],
        identity: ([0x90, 0, 0], rd(0x7c, 0x00, &[0x80]), [0x80, 0, 0]),
        ready: vec![rd(0x7c, 0x09, &[0x19])],
        not_ready: vec![rd(0x7c, 0x09, &[0x1a])],
        readings: vec![
            (read([0x02, 0x01, 0xd4, 0xfe, 0x07, 0x00]), counts([258, -300, 7])),
            // 32 000 is the last that is a measurement.
            (
                read([0x01, 0x7d, 0xff, 0x82, 0x00, 0x7d]),
                Reading { counts: [32_001, -32_001, 32_000], overflow: [true, true, false] },
            ),
        ],
        celsius: vec![(vec![], None)],
    }
    .run();
    use ironout_drivers::Chip;
    use qmc6309::{DataRate, Range};
    assert_eq!(Range::ALL.map(|range| range.bits()), [0x08, 0x04, 0x00]);
    let rates = [DataRate::Hz10, DataRate::Hz50, DataRate::Hz100, DataRate::Hz200];
    let control_2 = |rate| qmc6309::Config { rate, ..Default::default() }.writes()[1].byte;
    assert_eq!(rates.map(control_2), [0x18, 0x28, 0x38, 0x48]);
}

#[test]
fn ak09916() {
    let read = |bytes: [u8; 9]| vec![rd(0x0c, 0x10, &bytes)];
    Case {
        config: ak09916::Config::default(),
        init: vec![
            rd(0x0c, 0x00, &[0x48, 0x09]),
            wr(0x0c, 0x31, 0x00),
            wr(0x0c, 0x32, 0x00),
            wr(0x0c, 0x31, 0x08),
            rd(0x0c, 0x31, &[0x08]),
        ],
        identity: ([0x48, 0x09, 0], rd(0x0c, 0x00, &[0x48, 0x05]), [0x48, 0x05, 0]),
        ready: vec![rd(0x0c, 0x10, &[0x01])],
        not_ready: vec![rd(0x0c, 0x10, &[0x02])],
        readings: vec![
            (read([1, 0x02, 0x01, 0xd4, 0xfe, 0x07, 0x00, 0, 0]), counts([258, -300, 7])),
            (read([1, 1, 0, 2, 0, 3, 0, 0, 0x08]), Reading { counts: [1, 2, 3], overflow: [true; 3] }),
        ],
        celsius: vec![(vec![], None)],
    }
    .run();
}

#[test]
fn ist8310_measures_when_told_and_says_when_it_lost_its_resolution() {
    let outputs =
        |bytes: [u8; 6], resolution: u8| rd(0x0e, 0x03, &[&bytes[..], &[0, 0, 0, 0, resolution]].concat());
    let read = |bytes| vec![outputs(bytes, 0x70), wr(0x0e, 0x0a, 0x01)];
    Case {
        config: ist8310::Config::default(),
        init: vec![
            rd(0x0e, 0x00, &[0x10]),
            wr(0x0e, 0x0c, 0x00),
            wr(0x0e, 0x0d, 0x70),
            wr(0x0e, 0x41, 0x24),
            wr(0x0e, 0x42, 0xc0),
            rd(0x0e, 0x0c, &[0x00, 0x70]),
            rd(0x0e, 0x41, &[0x24, 0xc0]),
            wr(0x0e, 0x0a, 0x01),
        ],
        identity: ([0x10, 0, 0], rd(0x0e, 0x00, &[0x08]), [0x08, 0, 0]),
        // Not told yet: it is told first.
        ready: vec![wr(0x0e, 0x0a, 0x01), rd(0x0e, 0x02, &[0x01])],
        not_ready: vec![wr(0x0e, 0x0a, 0x01), rd(0x0e, 0x02, &[0x02])],
        readings: vec![
            (read([0x02, 0x01, 0xd4, 0xfe, 0x07, 0x00]), counts([258, -300, 7])),
            // 1600 µT on x; y and z have room.
            (
                read([0x80, 0x52, 0x7f, 0x52, 0xff, 0x7f]),
                Reading { counts: [21_120, 21_119, 32_767], overflow: [true, false, true] },
            ),
        ],
        celsius: vec![(vec![], None)],
    }
    .run();
    let mut driver = Driver::new(Mock::new(&[outputs([1, 0, 2, 0, 3, 0], 0x00)]), ist8310::Config::default());
    assert_eq!(driver.read(), Err(Error::NotKept { register: 0x0d, written: 0x70, read: 0x00 }));
    driver.destroy().done();
}

#[test]
fn rm3100_carries_24_bits_with_one_left_out() {
    let read = |bytes: [u8; 9]| vec![rd(0x20, 0x24, &bytes)];
    Case {
        config: rm3100::Config::default(),
        init: vec![
            rd(0x20, 0x36, &[0x22]),
            wr(0x20, 0x01, 0x00),
            wr(0x20, 0x04, 0),
            wr(0x20, 0x05, 200),
            wr(0x20, 0x06, 0),
            wr(0x20, 0x07, 200),
            wr(0x20, 0x08, 0),
            wr(0x20, 0x09, 200),
            wr(0x20, 0x0b, 0x95),
            wr(0x20, 0x01, 0x71),
            rd(0x20, 0x04, &[0, 200, 0, 200, 0, 200]),
            rd(0x20, 0x0b, &[0x95]),
            rd(0x20, 0x01, &[0x71]),
        ],
        identity: ([0x22, 0, 0], rd(0x20, 0x36, &[0x00]), [0, 0, 0]),
        ready: vec![rd(0x20, 0x34, &[0x80])],
        not_ready: vec![rd(0x20, 0x34, &[0x7f])],
        readings: vec![
            // 60 000, −300 and 7 counts of the chip: halves, away from zero.
            (read([0x00, 0xea, 0x60, 0xff, 0xfe, 0xd4, 0x00, 0x00, 0x07]), counts([30_000, -150, 4])),
            // 60 001 is beyond 800 µT; −60 002 too.
            (
                read([0x00, 0xea, 0x61, 0xff, 0x15, 0x9e, 0x00, 0x00, 0x00]),
                Reading { counts: [30_001, -30_001, 0], overflow: [true, true, false] },
            ),
            (
                read([0x7f, 0xff, 0xff, 0x80, 0x00, 0x00, 0x00, 0x00, 0x00]),
                Reading { counts: [i16::MAX, i16::MIN, 0], overflow: [true, true, false] },
            ),
        ],
        celsius: vec![(vec![], None)],
    }
    .run();
}
