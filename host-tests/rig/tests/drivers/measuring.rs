//! What is measured: scale, sign, order of the axes, data ready, overflow, temperature, supply.

use ironout_drivers::{Error, Kind, Magnetometer};

use crate::bench::{Bench, KINDS, near};

#[test]
fn every_chip_measures_the_field_with_its_sign_along_its_axes() {
    for kind in KINDS {
        let mut bench = Bench::ready(kind, [0.0; 3]);
        let mut fields = vec![[0.0; 3], [-45.0, 93.25, 20.5], [61.5, -7.0, -88.0]];
        for axis in 0..3 {
            for ut in [-50.0, 50.0] {
                let mut field = [0.0; 3];
                field[axis] = ut;
                fields.push(field);
            }
        }
        for field_ut in fields {
            bench.chip.set_field(field_ut);
            let measured = bench.fresh_ut().unwrap();
            assert!(near(measured, field_ut, bench.tolerance_ut()), "{kind:?}: {measured:?} of {field_ut:?}");
        }
    }
}

#[test]
fn every_chip_says_its_name_and_a_scale_that_the_field_fits() {
    for kind in KINDS {
        let sensor = Bench::new(kind, [0.0; 3]).driver.describe();
        assert_eq!(sensor.name, kind.name());
        assert!(sensor.rate_hz >= 30.0, "{kind:?}");
        for scale in sensor.ut_per_count {
            // The Earth's field with as much hard iron.
            assert!(scale * f32::from(sensor.full_scale_counts) > 130.0, "{kind:?}");
            assert!(scale <= 0.16, "{kind:?}: coarse");
        }
    }
}

#[test]
fn data_are_ready_once_a_period_and_not_again_before_they_are_new() {
    for kind in KINDS {
        let mut bench = Bench::ready(kind, [20.0, -30.0, 40.0]);
        assert_eq!(bench.driver.data_ready(), Ok(false), "{kind:?}: nothing is measured yet");
        // The time that the first ones take, which some chips need for themselves.
        bench.fresh();
        let end_ms = bench.clock.ms() + 1000;
        let mut ready = 0;
        while bench.clock.ms() < end_ms {
            if bench.driver.data_ready().unwrap() {
                bench.driver.read().unwrap();
                ready += 1;
                assert_eq!(bench.driver.data_ready(), Ok(false), "{kind:?}: read already");
            }
            bench.wait_ms(1);
        }
        let rate_hz = f64::from(bench.driver.describe().rate_hz);
        // A chip that is told waits for the next millisecond of this test.
        let least = if kind == Kind::Ist8310 { 120.0 } else { 0.97 * rate_hz - 1.0 };
        assert!((least..=rate_hz + 1.0).contains(&f64::from(ready)), "{kind:?}: {ready} at {rate_hz} Hz");
    }
}

#[test]
fn a_field_out_of_range_is_no_measurement_and_the_next_in_range_is() {
    // Beyond the range of each chip as it is configured by default.
    for kind in KINDS {
        let beyond_ut = match kind {
            Kind::Lis2mdl | Kind::Iis2mdc | Kind::Lsm303agr => 5_000.0,
            Kind::Lis3mdl => 500.0,
            Kind::Lsm303dlhc | Kind::Hmc5883l => 230.0,
            Kind::Qmc5883l => 1_200.0,
            Kind::Qmc5883p => 900.0,
            Kind::Qmc6309 | Kind::Qmc6310 => 801.0,
            Kind::Mmc5603 => 3_050.0,
            Kind::Mmc5983ma => 900.0,
            Kind::Bmm150 => 2_500.0,
            Kind::Bmm350 => 2_001.0,
            Kind::Ak09916 | Kind::Icm20948 => 4_950.0,
            Kind::Ist8310 => 1_700.0,
            Kind::Rm3100 => 820.0,
        };
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut field_ut = [10.0; 3];
                field_ut[axis] = sign
                    * beyond_ut
                    * if axis == 2 && matches!(kind, Kind::Bmm150 | Kind::Ist8310) { 2.0 } else { 1.0 };
                let mut bench = Bench::ready(kind, [10.0; 3]);
                bench.fresh();
                bench.chip.set_field(field_ut);
                let reading = bench.fresh();
                assert!(reading.overflow[axis], "{kind:?}: {field_ut:?} {reading:?}");
                let one_flag_for_all = matches!(kind, Kind::Ak09916 | Kind::Icm20948);
                assert_eq!(
                    reading.overflow.iter().filter(|axis| **axis).count(),
                    if one_flag_for_all { 3 } else { 1 }
                );
                assert!(!bench.driver.describe().sample(&reading).is_valid());
                bench.chip.set_field([10.0; 3]);
                let measured = bench.fresh_ut().unwrap_or_else(|| panic!("{kind:?}: stays out of range"));
                assert!(near(measured, [10.0; 3], bench.tolerance_ut()), "{kind:?}: {measured:?}");
            }
        }
    }
}

#[test]
fn the_temperature_is_the_chips_to_its_resolution_or_none() {
    for kind in KINDS {
        let resolution_c = match kind {
            Kind::Lis2mdl | Kind::Iis2mdc | Kind::Lis3mdl | Kind::Lsm303dlhc => Some(0.0626),
            Kind::Qmc5883l => Some(0.0051),
            Kind::Mmc5983ma | Kind::Mmc5603 => Some(0.401),
            Kind::Bmm350 => Some(0.126),
            _ => None,
        };
        let mut at_25_c = None;
        for celsius in [25.0, -10.25, 0.0, 36.6, 84.0] {
            let mut bench = Bench::ready(kind, [10.0; 3]);
            bench.chip.set_temperature(celsius);
            bench.fresh();
            let measured = bench.driver.temperature_c().unwrap().map(f64::from);
            assert_eq!(measured.is_some(), resolution_c.is_some(), "{kind:?}");
            let (Some(measured), Some(resolution_c)) = (measured, resolution_c) else { continue };
            // The zero of the QMC5883L is not calibrated: differences count.
            let zero = *at_25_c.get_or_insert(if kind == Kind::Qmc5883l { measured - 25.0 } else { 0.0 });
            assert!(
                (measured - zero - celsius).abs() <= 2.0 * resolution_c,
                "{kind:?}: {measured} at {celsius} °C"
            );
        }
    }
}

#[test]
fn the_compensated_field_does_not_go_with_the_temperature() {
    let field_ut = [-45.0, 93.25, 20.5];
    for kind in [Kind::Bmm150, Kind::Bmm350] {
        let mut bench = Bench::ready(kind, field_ut);
        for celsius in [-40.0, 0.0, 25.0, 85.0] {
            bench.chip.set_temperature(celsius);
            let measured = bench.fresh_ut().unwrap();
            assert!(near(measured, field_ut, bench.tolerance_ut()), "{kind:?}: {measured:?} at {celsius} °C");
        }
    }
}

#[test]
fn a_dip_of_the_supply_shows_and_a_new_configuration_heals_it() {
    for kind in KINDS {
        let mut bench = Bench::ready(kind, [10.0, 20.0, 30.0]);
        bench.fresh();
        bench.chip.power_cycle();
        match kind {
            // A chip that measures when told goes on, with the resolution of its power-up: what it reads shows it.
            Kind::Ist8310 => {
                assert_eq!(bench.driver.data_ready(), Ok(false), "the measurement it was told was lost");
                bench.driver.init().unwrap();
                bench.fresh();
                bench.chip.set_register(0x0d, 0);
                assert_eq!(bench.is_ready(), Ok(true));
                let lost = Error::NotKept { register: 0x0d, written: 0x70, read: 0 };
                assert_eq!(bench.driver.read(), Err(lost));
            }
            _ => assert_eq!(bench.is_ready(), Ok(false), "{kind:?}: no data without a configuration"),
        }
        bench.driver.init().unwrap();
        let measured = bench.fresh_ut().unwrap();
        assert!(near(measured, [10.0, 20.0, 30.0], bench.tolerance_ut()), "{kind:?}: {measured:?}");
    }
}

#[test]
fn another_chip_at_the_address_is_named() {
    for kind in KINDS {
        let (register, expected): (u8, [u8; 3]) = match kind {
            Kind::Lis2mdl | Kind::Iis2mdc | Kind::Lsm303agr => (0x4f, [0x40, 0, 0]),
            Kind::Lis3mdl => (0x0f, [0x3d, 0, 0]),
            Kind::Lsm303dlhc | Kind::Hmc5883l => (0x0a, *b"H43"),
            Kind::Qmc5883l => (0x0d, [0xff, 0, 0]),
            Kind::Qmc5883p => (0x00, [0x80, 0, 0]),
            Kind::Qmc6309 => (0x00, [0x90, 0, 0]),
            Kind::Qmc6310 => (0x00, [0x80, 0, 0]),
            Kind::Mmc5603 => (0x39, [0x10, 0, 0]),
            Kind::Mmc5983ma => (0x2f, [0x30, 0, 0]),
            // Its identity appears when it wakes.
            Kind::Bmm150 => continue,
            Kind::Bmm350 => (0x00, [0x33, 0, 0]),
            Kind::Ak09916 | Kind::Icm20948 => (0x00, [0x48, 0x09, 0]),
            Kind::Ist8310 => (0x00, [0x10, 0, 0]),
            Kind::Rm3100 => (0x36, [0x22, 0, 0]),
        };
        let mut bench = Bench::new(kind, [0.0; 3]);
        bench.chip.set_register(register, 0x5a);
        let found = [0x5a, expected[1], expected[2]];
        assert_eq!(bench.driver.init(), Err(Error::NotFound { expected, found }), "{kind:?}");
    }
}
