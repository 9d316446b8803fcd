//! The drivers against the chips' register models: what the datasheets say, from both sides.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use eeprom24x::{Eeprom24x, SlaveAddr, Storage, addr_size::TwoBytes, page_size::B32, unique_serial};
use embedded_hal::i2c::{ErrorKind, I2c, NoAcknowledgeSource};
use embedded_storage::{ReadStorage as _, Storage as _};
use ironout::calibration::Calibration;
use ironout::extended::Effects;
use ironout::fit::{Method, Order};
use ironout::record::Record;
use ironout::store::{Done, Slot, StorageSlots, Store, StoreError, StoreJob, run};
use ironout_drivers::lsm303dlhc::{Config, DataRate, Lsm303dlhc, Range};
use ironout_drivers::{Error, Magnetometer};
use ironout_rig::board::SimDelay;
use ironout_rig::bus::{Clock, FaultControl, Faulty, Hit, SimBus};
use ironout_rig::chips::{At24cChip, Lsm303dlhcChip, TornPage};

const NOBODY: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

/// A bus with a magnetometer in a constant field.
fn magnetometer(
    field_ut: [f64; 3],
    config: Config,
) -> (Clock, Rc<RefCell<Lsm303dlhcChip>>, Lsm303dlhc<SimBus>) {
    let clock = Clock::default();
    let bus = SimBus::new(clock.clone());
    let chip = Rc::new(RefCell::new(Lsm303dlhcChip::new(move |_| field_ut, 0.0, 1)));
    bus.attach(chip.clone());
    (clock, chip, Lsm303dlhc::new(bus, config))
}

fn eeprom() -> (Clock, Rc<RefCell<At24cChip>>, SimBus) {
    let clock = Clock::default();
    let bus = SimBus::new(clock.clone());
    let chip = Rc::new(RefCell::new(At24cChip::new(0x50, 4096, 32)));
    bus.attach(chip.clone());
    (clock, chip, bus)
}

#[test]
fn the_driver_measures_the_field_at_every_range_to_half_a_count() {
    let field_ut = [-45.0, 93.25, 20.5];
    for range in Range::ALL {
        let (clock, _, mut sensor) = magnetometer(field_ut, Config { range, ..Config::default() });
        sensor.init().unwrap();
        clock.advance_to_ms(20);
        let (counts, scale) = (sensor.read().unwrap().counts, sensor.describe().ut_per_count);
        for axis in 0..3 {
            let error_ut = f64::from(f32::from(counts[axis]) * scale[axis]) - field_ut[axis];
            assert!(error_ut.abs() <= 0.501 * f64::from(scale[axis]), "{range:?} axis {axis}: {error_ut}");
        }
    }
}

#[test]
fn data_are_ready_once_a_period_and_not_again_before_they_are_new() {
    let (clock, _, mut sensor) = magnetometer([1.0; 3], Config { rate: DataRate::Hz30, ..Config::default() });
    sensor.init().unwrap();
    assert_eq!(sensor.data_ready(), Ok(false), "no conversion is done yet");
    // The first conversion is dropped: it may be of the gain before.
    let mut ready = 1;
    for ms in 1..=1000 {
        clock.advance_to_ms(ms);
        if sensor.data_ready().unwrap() {
            sensor.read().unwrap();
            ready += 1;
        }
    }
    assert!((29..=30).contains(&ready), "{ready}");
}

#[test]
fn a_field_out_of_range_is_an_overflow_of_its_axis_only() {
    let (clock, _, mut sensor) = magnetometer([50.0, -700.0, 20.0], Config::default());
    sensor.init().unwrap();
    clock.advance_to_ms(20);
    let reading = sensor.read().unwrap();
    assert_eq!((reading.counts[1], reading.overflow), (-4096, [false, true, false]));
    sensor.reconfigure(Config { range: Range::Gauss8_1, ..Config::default() }).unwrap();
    clock.advance_to_ms(40);
    assert!(!sensor.read().unwrap().saturated());
}

#[test]
fn the_temperature_is_read_although_the_pointer_does_not_go_on_there() {
    let (clock, chip, mut sensor) = magnetometer([1.0; 3], Config::default());
    sensor.init().unwrap();
    for celsius in [-10.25_f32, 0.0, 36.625] {
        chip.borrow_mut().temperature_c = f64::from(celsius);
        clock.advance_ns(20_000_000);
        assert_eq!(sensor.temperature_c(), Ok(Some(celsius)));
    }
}

#[test]
fn registers_that_are_read_only_stay_and_the_pointer_wraps_as_documented() {
    let (_, _, sensor) = magnetometer([1.0; 3], Config::default());
    let mut bus = sensor.destroy();
    bus.write(0x1e, &[0x0a, 0, 0, 0]).unwrap();
    let mut identity = [0; 5];
    bus.write_read(0x1e, &[0x0a], &mut identity).unwrap();
    assert_eq!(identity, [b'H', b'4', b'3', 0x10, 0x20], "12 is followed by 0");
    let mut wrapped = [0; 12];
    bus.write_read(0x1e, &[0x03], &mut wrapped).unwrap();
    assert_eq!(wrapped[..6], wrapped[6..], "8 is followed by 3");
    let mut beyond = [9; 1];
    bus.write_read(0x1e, &[0x83], &mut beyond).unwrap();
    assert_eq!(beyond, [0], "the top bit of the sub-address belongs to the accelerometer half");
}

#[test]
fn a_dip_of_the_supply_shows_as_no_more_data() {
    let (clock, chip, mut sensor) = magnetometer([1.0; 3], Config::default());
    sensor.init().unwrap();
    let is_ready_after = |ms: u64, sensor: &mut Lsm303dlhc<SimBus>| {
        clock.advance_ns(ms * 1_000_000);
        sensor.data_ready().unwrap()
    };
    assert!(!is_ready_after(20, &mut sensor), "the first one is dropped");
    assert!(is_ready_after(20, &mut sensor));
    chip.borrow_mut().power_cycle();
    assert!(!is_ready_after(2000, &mut sensor));
    sensor.init().unwrap();
    assert!(!is_ready_after(20, &mut sensor), "the first one is dropped");
    assert!(is_ready_after(20, &mut sensor));
}

#[test]
fn an_absent_chip_and_another_chip_are_different_errors() {
    let (_, chip, mut sensor) = magnetometer([1.0; 3], Config::default());
    chip.borrow_mut().set_identity(*b"H5\0");
    assert_eq!(sensor.init(), Err(Error::NotFound { expected: *b"H43", found: *b"H5\0" }));
    let bus = sensor.destroy();
    bus.detach(0x1e);
    assert_eq!(Lsm303dlhc::new(bus, Config::default()).init(), Err(Error::Bus(NOBODY)));
}

#[test]
fn a_fault_at_any_byte_of_any_transaction_is_an_error_and_leaves_a_working_bus() {
    let (clock, _, sensor) = magnetometer([12.0, 34.0, 56.0], Config::default());
    let control = FaultControl::new();
    let mut sensor = Lsm303dlhc::new(Faulty::new(sensor.destroy(), control.clone()), Config::default());
    sensor.init().unwrap();
    clock.advance_to_ms(20);
    let good = sensor.read().unwrap();
    // Address, sub-address, address, six data bytes.
    for byte in 0..9 {
        control.nack_at(0, byte);
        let expected = match byte {
            0 | 2 => NOBODY,
            1 => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data),
            _ => ErrorKind::ArbitrationLoss,
        };
        assert_eq!(sensor.read(), Err(Error::Bus(expected)), "byte {byte}");
        assert_eq!(sensor.read(), Ok(good), "after byte {byte}");
    }
    // Identification, three registers, and their reading back.
    for (transaction, bytes) in [(0, 6), (1, 3), (2, 3), (3, 3), (4, 6)] {
        for byte in 0..bytes {
            control.nack_at(transaction, byte);
            assert!(matches!(sensor.init(), Err(Error::Bus(_))), "transaction {transaction} byte {byte}");
            assert_eq!(sensor.init(), Ok(()));
        }
    }
    control.hold_bus();
    assert_eq!(sensor.read(), Err(Error::Bus(ErrorKind::Bus)));
    control.clear();
    assert_eq!(sensor.init(), Ok(()));
}

#[test]
fn a_flipped_configuration_byte_is_noticed_when_read_back() {
    let (_, _, sensor) = magnetometer([1.0; 3], Config::default());
    let control = FaultControl::new();
    let mut sensor = Lsm303dlhc::new(Faulty::new(sensor.destroy(), control.clone()), Config::default());
    // Transaction 2 writes CRB; byte 2 of it is the value.
    control.flip_at(2, 2, 0x40);
    assert_eq!(sensor.init(), Err(Error::NotKept { register: 0x01, written: 0x20, read: 0x60 }));
    assert_eq!(sensor.init(), Ok(()));
}

type Rom<I2C> = Storage<I2C, B32, TwoBytes, unique_serial::No, SimDelay>;

/// The EEPROM's driver, as the boards use it.
fn rom<I2C: I2c>(bus: I2C, clock: &Clock) -> Rom<I2C> {
    Rom::new(Eeprom24x::new_24x32(bus, SlaveAddr::default()), SimDelay(clock.clone()))
}

fn slots<I2C: I2c>(bus: I2C, clock: &Clock) -> StorageSlots<Rom<I2C>> {
    StorageSlots::new(rom(bus, clock), 0, 32).unwrap()
}

/// Saves a record, with the clock going on.
fn save(store: &mut impl Store, clock: &Clock, in_use: Option<Slot>) -> Result<(Slot, Record), StoreError> {
    let record = Record {
        sequence: 0,
        calibration: Calibration { offset_ut: [1.0, 2.0, 3.0], ..Calibration::identity(48.0) },
        effects: Effects::none(),
        method: Method::Adjusted,
        model: Order::Ellipsoid,
        samples: 1000,
        noise_ut: 0.1,
        rms_ut: 0.1,
        axes: None,
        predicted_error: ironout::record::PredictedError::UNKNOWN,
        covariance: None,
        holds_for: None,
    };
    match run(StoreJob::save(in_use, record), store, |ms| clock.advance_ns(ms * 1_000_000))? {
        Done::Saved(slot, record) => Ok((slot, record)),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_eeprom_driver_writes_any_range_and_the_chip_would_wrap_without_it() {
    let (clock, chip, mut bus) = eeprom();
    let data: Vec<u8> = (0..200).collect();
    let mut rom = rom(bus.clone(), &clock);
    for offset in [0, 1, 31, 32, 1000, 4096 - 200] {
        rom.write(offset, &data).unwrap();
        let mut back = vec![0; 200];
        rom.read(offset, &mut back).unwrap();
        assert_eq!(back, data, "at {offset}");
    }
    // Straight to the chip: 34 bytes from the beginning of a page overwrite its first two.
    bus.write(0x50, &[&[0x02, 0x00][..], &data[..34]].concat()).unwrap();
    assert_eq!(chip.borrow().memory[0x200..0x203], [32, 33, 2]);
}

#[test]
fn a_record_is_saved_in_the_write_time_of_its_pages_and_a_chip_that_is_gone_is_given_up() {
    let (clock, _, bus) = eeprom();
    let mut store = slots(bus.clone(), &clock);
    assert_eq!(save(&mut store, &clock, None).map(|(slot, _)| slot), Ok(Slot::A));
    // 148 bytes are five pages of 5 ms; the rest are bytes on the bus.
    assert!((25..50).contains(&clock.ms()), "{} ms", clock.ms());
    bus.detach(0x50);
    assert_eq!(save(&mut store, &clock, None), Err(StoreError::Read(Slot::A)));
}

#[test]
fn a_page_write_that_was_cut_short_is_waited_for_by_the_next_access() {
    let (clock, chip, bus) = eeprom();
    let control = FaultControl::new();
    let mut store = slots(Faulty::new(bus, control.clone()), &clock);
    let (_, first) = save(&mut store, &clock, None).unwrap();
    // The first page of the second record, whatever transaction that is: cut in its sixth byte, the chip writes the five
    // before it and does not answer meanwhile.
    let pages = Rc::new(Cell::new(0));
    let counted = pages.clone();
    control.set(move |_, byte| {
        if byte != 34 {
            return Hit::Pass;
        }
        counted.set(counted.get() + 1);
        if counted.get() == 8 { Hit::Nack } else { Hit::Pass }
    });
    let (slot, second) = save(&mut store, &clock, Some(Slot::A)).unwrap();
    assert!(pages.get() > 8, "the cut came and was overcome");
    assert_eq!((slot, second.sequence), (Slot::B, first.sequence + 1));
    assert_eq!(Record::decode(&chip.borrow().memory[512..]), Ok(second));
}

#[test]
fn power_lost_in_a_page_leaves_it_torn_in_each_way() {
    for (torn_page, rest) in [(TornPage::Old, 0x11), (TornPage::Erased, 0xff)] {
        let (clock, chip, bus) = eeprom();
        let mut rom = rom(bus, &clock);
        rom.write(0, &[0x11; 64]).unwrap();
        chip.borrow_mut().torn_page = torn_page;
        chip.borrow_mut().lose_power_after(40);
        // The driver does not ask whether the page arrived: reading back is what tells.
        rom.write(0, &[0x22; 64]).unwrap();
        let mut back = [0; 64];
        assert!(rom.read(0, &mut back).is_err());
        chip.borrow_mut().power_cycle();
        rom.read(0, &mut back).unwrap();
        assert_eq!(back[..40], [0x22; 40]);
        assert_eq!(back[40..], [rest; 24]);
    }
}
