//! Counts wider than 16 bits, and the offset that a chip removes itself.

use std::cell::RefCell;
use std::rc::Rc;

use ironout::fit::{FitOptions, fit};
use ironout::moments::Moments;
use ironout::scatter::Scatter;
use ironout_drivers::{Error, Kind, Magnetometer, Sensor, bmm350, mmc5603, mmc5983ma, rm3100};
use ironout_rig::board::SimDelay;
use ironout_rig::bus::{Clock, SimBus};
use ironout_rig::chips::{
    Bmm350Model, FieldSource, Mmc5603Model, Mmc5983maModel, OtpMemory, RegisterChip, Rm3100Model,
};

use crate::bench::{BRIDGE_OFFSET_UT, Bench, MAGNETISED_UT, near};

type Mmc = mmc5983ma::Mmc5983ma<SimBus>;

fn mmc(
    config: mmc5983ma::Config,
    field: impl FieldSource + 'static,
) -> (Clock, Rc<RefCell<RegisterChip<Mmc5983maModel>>>, Mmc) {
    let clock = Clock::default();
    let bus = SimBus::new(clock.clone());
    let chip = Rc::new(RefCell::new(RegisterChip::new(0x30, Mmc5983maModel::new(BRIDGE_OFFSET_UT), field)));
    bus.attach(chip.clone());
    let mut driver = Mmc::new(bus, config);
    driver.init().unwrap();
    (clock, chip, driver)
}

fn wait(clock: &Clock, driver: &mut impl Magnetometer<BusError: std::fmt::Debug>) {
    for _ in 0..200 {
        clock.advance_ns(1_000_000);
        if driver.data_ready().unwrap() {
            return;
        }
    }
    panic!("no data");
}

#[test]
fn the_chips_own_offset_is_measured_and_gone() {
    let (clock, _, mut driver) = mmc(mmc5983ma::Config::default(), |_| [20.0, -30.0, 40.0]);
    wait(&clock, &mut driver);
    assert!(near(driver.bridge_offset_ut(), BRIDGE_OFFSET_UT, 0.01), "{:?}", driver.bridge_offset_ut());
    let sensor = driver.describe();
    let field = sensor.measured_ut(sensor.sample(&driver.read().unwrap())).unwrap();
    assert!(near(field, [20.0, -30.0, 40.0], 0.0225), "{field:?}");
}

#[test]
fn a_field_that_turns_evenly_meanwhile_is_not_taken_for_the_chips_offset() {
    // 50 µT at half a turn a second: 1.3 µT from one measurement to the next. Over 24 ms it bends by 0.05 µT.
    let (clock, _, mut driver) = mmc(mmc5983ma::Config::default(), |t_s: f64| {
        let angle = std::f64::consts::PI * t_s;
        [50.0 * angle.cos(), 50.0 * angle.sin(), 0.0]
    });
    wait(&clock, &mut driver);
    assert!(near(driver.bridge_offset_ut(), BRIDGE_OFFSET_UT, 0.04), "{:?}", driver.bridge_offset_ut());
}

#[test]
fn the_offset_is_measured_anew_and_the_temperature_with_it() {
    let config = mmc5983ma::Config { refresh_every: 20, ..Default::default() };
    let (clock, chip, mut driver) = mmc(config, |_| [20.0, -30.0, 40.0]);
    wait(&clock, &mut driver);
    driver.read().unwrap();
    chip.borrow_mut().model.offset_ut = [35.0, -10.0, 2.0];
    chip.borrow_mut().temperature_c = 61.0;
    for _ in 0..25 {
        wait(&clock, &mut driver);
        driver.read().unwrap();
    }
    assert!(near(driver.bridge_offset_ut(), [35.0, -10.0, 2.0], 0.01), "{:?}", driver.bridge_offset_ut());
    assert_eq!(driver.temperature_c(), Ok(Some(61.0)));
}

#[test]
fn an_axis_out_of_range_keeps_its_offset() {
    let config = mmc5983ma::Config { refresh_every: 5, ..Default::default() };
    let (clock, chip, mut driver) = mmc(config, |_| [0.0; 3]);
    wait(&clock, &mut driver);
    driver.read().unwrap();
    chip.borrow_mut().set_field(|_: f64| [0.0, 900.0, 0.0]);
    for _ in 0..12 {
        wait(&clock, &mut driver);
        driver.read().unwrap();
    }
    assert!(near(driver.bridge_offset_ut(), BRIDGE_OFFSET_UT, 0.01), "{:?}", driver.bridge_offset_ut());
}

#[test]
fn what_the_shift_leaves_out_is_in_the_scale_and_what_does_not_fit_is_out_of_range() {
    for (shift, fits_ut, beyond_ut) in [(0, 190.0, 210.0), (1, 390.0, 410.0), (2, 760.0, 830.0)] {
        let config = mmc5983ma::Config { shift, ..Default::default() };
        let (clock, chip, mut driver) = mmc(config, move |_| [0.0, fits_ut, 0.0]);
        wait(&clock, &mut driver);
        let sensor = driver.describe();
        assert_eq!((sensor.bits, sensor.shift), (18, shift));
        let field = sensor.measured_ut(sensor.sample(&driver.read().unwrap())).unwrap();
        assert!(near(field, [0.0, fits_ut, 0.0], 0.02), "{shift}: {field:?}");
        chip.borrow_mut().set_field(move |_: f64| [0.0, beyond_ut, 0.0]);
        wait(&clock, &mut driver);
        driver.read().unwrap();
        wait(&clock, &mut driver);
        assert_eq!(driver.read().unwrap().overflow, [false, true, false], "{shift}");
    }
}

type Mmc20 = mmc5603::Mmc5603<SimBus, SimDelay>;

fn mmc20(
    config: mmc5603::Config,
    field: impl FieldSource + 'static,
) -> (Clock, Rc<RefCell<RegisterChip<Mmc5603Model>>>, Mmc20) {
    let clock = Clock::default();
    let bus = SimBus::new(clock.clone());
    let chip = Rc::new(RefCell::new(RegisterChip::new(0x30, Mmc5603Model::new(BRIDGE_OFFSET_UT), field)));
    bus.attach(chip.clone());
    let mut driver = Mmc20::new(bus, SimDelay(clock.clone()), config);
    driver.init().unwrap();
    (clock, chip, driver)
}

#[test]
fn the_20_bit_chip_measures_its_offset_at_each_rate_and_measures_it_anew() {
    for rate_hz in [10, 75, 100, 150, 255] {
        let config = mmc5603::Config { rate_hz, refresh_every: 20, shift: 2 };
        let (clock, chip, mut driver) = mmc20(config, |_| [20.0, -30.0, 40.0]);
        wait(&clock, &mut driver);
        assert!(near(driver.bridge_offset_ut(), BRIDGE_OFFSET_UT, 0.005), "{:?}", driver.bridge_offset_ut());
        let sensor = driver.describe();
        assert_eq!((sensor.bits, sensor.shift), (20, 2));
        let field = sensor.measured_ut(sensor.sample(&driver.read().unwrap())).unwrap();
        assert!(near(field, [20.0, -30.0, 40.0], 0.0225), "{field:?}");
        chip.borrow_mut().model.offset_ut = [35.0, -10.0, 2.0];
        chip.borrow_mut().temperature_c = 61.0;
        for _ in 0..25 {
            wait(&clock, &mut driver);
            driver.read().unwrap();
        }
        let offset_ut = driver.bridge_offset_ut();
        assert!(near(offset_ut, [35.0, -10.0, 2.0], 0.005), "{rate_hz} Hz: {offset_ut:?}");
        assert_eq!(driver.temperature_c(), Ok(Some(61.0)));
    }
}

#[test]
fn the_20_bit_chip_carries_the_range_that_its_shift_leaves() {
    for (shift, fits_ut, beyond_ut) in [(0, 190.0, 210.0), (2, 760.0, 830.0), (4, 2_980.0, 3_020.0)] {
        let config = mmc5603::Config { shift, ..Default::default() };
        let (clock, chip, mut driver) = mmc20(config, move |_| [0.0, fits_ut, 0.0]);
        wait(&clock, &mut driver);
        let sensor = driver.describe();
        let field = sensor.measured_ut(sensor.sample(&driver.read().unwrap())).unwrap();
        assert!(near(field, [0.0, fits_ut, 0.0], 0.06), "{shift}: {field:?}");
        chip.borrow_mut().set_field(move |_: f64| [0.0, beyond_ut, 0.0]);
        wait(&clock, &mut driver);
        driver.read().unwrap();
        wait(&clock, &mut driver);
        assert_eq!(driver.read().unwrap().overflow, [false, true, false], "{shift}");
    }
    for config in [
        mmc5603::Config { rate_hz: 0, ..Default::default() },
        mmc5603::Config { shift: 9, ..Default::default() },
    ] {
        let clock = Clock::default();
        let mut driver = Mmc20::new(SimBus::new(clock.clone()), SimDelay(clock), config);
        assert!(matches!(driver.init(), Err(Error::InvalidConfig(_))), "before anything is sent");
    }
}

#[test]
fn a_bmm350_is_magnetically_reset_and_reads_its_memory_at_each_rate() {
    use bmm350::{Averaging, Bmm350, Config, DataRate};
    for rate in [DataRate::Hz400, DataRate::Hz200, DataRate::Hz100, DataRate::Hz50, DataRate::Hz25] {
        let clock = Clock::default();
        let bus = SimBus::new(clock.clone());
        let memory = OtpMemory::default();
        let field_ut = [1_998.0, -3.25, -1_998.0];
        let model = Bmm350Model::new(memory, MAGNETISED_UT);
        let chip = Rc::new(RefCell::new(RegisterChip::new(0x15, model, move |_: f64| field_ut)));
        bus.attach(chip.clone());
        let config = Config { address: 0x15, rate, averaging: rate.most() };
        let mut driver = Bmm350::new(bus, SimDelay(clock.clone()), config);
        driver.init().unwrap();
        assert_eq!(chip.borrow().model.magnetised_ut, [0.0; 3]);
        let otp = driver.otp();
        assert_eq!(
            (otp.offset, otp.sensitivity, otp.cross),
            (memory.offset, memory.sensitivity, memory.cross)
        );
        assert_eq!(
            (otp.offset_drift, otp.sensitivity_drift),
            (memory.offset_drift, memory.sensitivity_drift)
        );
        assert_eq!(
            (otp.celsius_offset, otp.celsius_sensitivity, otp.reference),
            (memory.celsius.0, memory.celsius.1, memory.reference)
        );
        wait(&clock, &mut driver);
        let sensor = driver.describe();
        let field = sensor.measured_ut(sensor.sample(&driver.read().unwrap())).unwrap();
        assert!(near(field, field_ut, 0.04), "{rate:?}: {field:?}");
        // A field as strong as that of a magnet in the hand, and a configuration after it.
        chip.borrow_mut().model.magnetised_ut = MAGNETISED_UT;
        driver.init().unwrap();
        wait(&clock, &mut driver);
        let field = sensor.measured_ut(sensor.sample(&driver.read().unwrap())).unwrap();
        assert!(near(field, field_ut, 0.04), "{rate:?}: {field:?}");
    }
    let config = Config { rate: DataRate::Hz200, averaging: Averaging::Of4, ..Default::default() };
    let clock = Clock::default();
    let mut driver = Bmm350::new(SimBus::new(clock.clone()), SimDelay(clock), config);
    assert!(matches!(driver.init(), Err(Error::InvalidConfig(_))), "before anything is sent");
}

#[test]
fn the_24_bit_chip_carries_its_whole_range_at_each_cycle_count() {
    use rm3100::{Config, CycleCount, DataRate};
    for (cycles, rate) in [
        (CycleCount::C50, DataRate::Hz300),
        (CycleCount::C100, DataRate::Hz150),
        (CycleCount::C200, DataRate::Hz75),
    ] {
        let clock = Clock::default();
        let bus = SimBus::new(clock.clone());
        bus.attach(Rc::new(RefCell::new(RegisterChip::new(0x20, Rm3100Model, |_: f64| {
            [-799.0, 799.0, 0.4]
        }))));
        let config = Config { cycles, rate, shift: cycles.shift(), ..Config::default() };
        let mut driver = rm3100::Rm3100::new(bus, config);
        driver.init().unwrap();
        wait(&clock, &mut driver);
        let sensor: Sensor = driver.describe();
        let field = sensor.measured_ut(sensor.sample(&driver.read().unwrap())).unwrap();
        let tolerance_ut = 0.51 * f64::from(sensor.ut_per_count[0]) + 0.01;
        assert!(near(field, [-799.0, 799.0, 0.4], tolerance_ut), "{cycles:?}: {field:?}");
    }
    // More cycles than the rate leaves time for, and a shift of more bits than there are.
    for config in [
        Config { cycles: CycleCount::C200, rate: DataRate::Hz150, ..Config::default() },
        Config { shift: 9, ..Config::default() },
    ] {
        let mut driver = rm3100::Rm3100::new(SimBus::new(Clock::default()), config);
        assert!(matches!(driver.init(), Err(Error::InvalidConfig(_))), "before anything is sent");
    }
}

/// The offset and field that a fit finds from a chip's carried counts.
fn fitted(kind: Kind, hard_iron_ut: [f64; 3], field_ut: f64) -> ([f64; 3], f64) {
    let mut bench = Bench::ready(kind, [0.0; 3]);
    bench.fresh();
    let sensor = bench.driver.describe();
    let mut moments = Moments::new();
    // Points spread evenly over the sphere.
    const POINTS: u32 = 400;
    for point in 0..POINTS {
        let z = 1.0 - 2.0 * (f64::from(point) + 0.5) / f64::from(POINTS);
        let (sin, cos) = (f64::from(point) * 2.399_963).sin_cos();
        let flat = (1.0 - z * z).sqrt();
        let direction = [flat * cos, flat * sin, z];
        bench.chip.set_field(std::array::from_fn(|axis| hard_iron_ut[axis] + field_ut * direction[axis]));
        moments.push(sensor.sample(&bench.fresh()).counts);
    }
    let scatter = Scatter::from_moments(&moments, sensor.board_ut_per_count().map(f64::from)).unwrap();
    let report = fit(&scatter, &FitOptions::default()).expect("a good log");
    (report.calibration.offset_ut, report.measured_field_ut)
}

#[test]
fn a_fit_of_carried_counts_knows_their_scale() {
    let hard_iron_ut = [120.0, -85.0, 33.0];
    for kind in [Kind::Lis2mdl, Kind::Mmc5983ma, Kind::Mmc5603, Kind::Bmm350, Kind::Rm3100] {
        let (offset_ut, field_ut) = fitted(kind, hard_iron_ut, 48.0);
        for axis in 0..3 {
            assert!((offset_ut[axis] - hard_iron_ut[axis]).abs() < 0.03, "{kind:?}: {offset_ut:?}");
        }
        assert!((field_ut - 48.0).abs() < 0.03, "{kind:?}: {field_ut}");
    }
}
