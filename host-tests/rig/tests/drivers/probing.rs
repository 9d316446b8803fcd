//! What a probing finds, and what it says of what it cannot know.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_hal::i2c::ErrorKind;
use ironout_drivers::{AnyMagnetometer, Found, Kind, Magnetometer, asynch, probe};
use ironout_rig::board::SimDelay;
use ironout_rig::bus::{Clock, FaultControl, Faulty, Hit, SimBus};
use ironout_rig::chips::{Action, At24cChip, Model, RegisterChip, Registers, World};

use crate::bench::{KINDS, attach};

fn found_on(bus: &SimBus, clock: &Clock) -> Vec<Found> {
    probe(&mut bus.clone(), &mut SimDelay(clock.clone())).iter().collect()
}

fn empty() -> (Clock, SimBus) {
    let clock = Clock::default();
    (clock.clone(), SimBus::new(clock))
}

/// A chip that is none of ours: whatever is read is this.
struct Stranger(u8);

impl Model for Stranger {
    fn power_up(&mut self, registers: &mut Registers) {
        *registers = [self.0; 256];
    }
    fn writable(&self, _register: u8) -> u8 {
        0
    }
    fn written(&mut self, _registers: &mut Registers, register: u8, byte: u8) -> Action {
        panic!("{byte:#04x} was written to register {register:#04x} of somebody else's chip");
    }
    fn was_read(&mut self, _registers: &mut Registers, _register: u8) {}
    fn period_ns(&self, _registers: &Registers) -> Option<u64> {
        None
    }
    fn measure(&mut self, _registers: &mut Registers, _world: &World) {}
}

fn put(bus: &SimBus, address: u8, reads: u8) {
    bus.attach(Rc::new(RefCell::new(RegisterChip::new(address, Stranger(reads), |_: f64| [0.0; 3]))));
}

/// The accelerometer of an LSM303, as far as its identity.
fn put_accelerometer(bus: &SimBus) {
    put(bus, 0x19, 0x33);
}

#[test]
fn every_chip_is_found_alone_and_its_driver_measures() {
    for kind in KINDS {
        let (clock, bus) = empty();
        let (expected, chip) = attach(&bus, kind);
        if matches!(kind, Kind::Lsm303agr | Kind::Lsm303dlhc) {
            put_accelerometer(&bus);
        }
        chip.set_field([10.0, 20.0, -30.0]);
        let found = found_on(&bus, &clock);
        let [found] = found[..] else { panic!("{kind:?}: {found:?}") };
        // Registers and identity of these two are the same.
        let kind = if kind == Kind::Iis2mdc { Kind::Lis2mdl } else { kind };
        assert_eq!((found.kind, found.address), (kind, expected.address));
        let or = match kind {
            Kind::Lis2mdl => Some(Kind::Iis2mdc),
            Kind::Lsm303agr => Some(Kind::Lis2mdl),
            Kind::Lsm303dlhc => Some(Kind::Hmc5883l),
            _ => None,
        };
        assert_eq!(found.or, or);
        assert_eq!(found.is_ambiguous(), kind == Kind::Lsm303dlhc);
        let mut driver = AnyMagnetometer::new(bus, SimDelay(clock.clone()), found);
        driver.init().unwrap();
        for _ in 0..500 {
            clock.advance_ns(1_000_000);
            if driver.data_ready().unwrap() {
                break;
            }
        }
        let sensor = driver.describe();
        let field = sensor.measured_ut(sensor.sample(&driver.read().unwrap())).unwrap();
        assert!((field[2] + 30.0).abs() < 0.4, "{kind:?}: {field:?}");
        // A microcontroller that restarts alone finds the chip as it left it: the same one.
        assert_eq!(found_on(&driver.destroy(), &clock), [found], "{kind:?}");
    }
}

#[test]
fn chips_of_every_other_address_are_found_too() {
    use ironout_rig::chips::{
        Bmm150Model, Bmm350Model, Ist8310Model, Lis3mdlModel, OtpMemory, Qmc6310Model, Rm3100Model, Trimming,
    };
    let (clock, bus) = empty();
    let field = |_: f64| [0.0; 3];
    bus.attach(Rc::new(RefCell::new(RegisterChip::new(0x1e, Lis3mdlModel, field))));
    bus.attach(Rc::new(RefCell::new(RegisterChip::new(0x0c, Ist8310Model { offset_ut: [0.0; 3] }, field))));
    bus.attach(Rc::new(RefCell::new(RegisterChip::new(0x13, Bmm150Model::new(Trimming::default()), field))));
    bus.attach(Rc::new(RefCell::new(RegisterChip::new(0x23, Rm3100Model, field))));
    let bmm350 = Bmm350Model::new(OtpMemory::default(), [0.0; 3]);
    bus.attach(Rc::new(RefCell::new(RegisterChip::new(0x15, bmm350, field))));
    bus.attach(Rc::new(RefCell::new(RegisterChip::new(0x3c, Qmc6310Model, field))));
    let found: Vec<_> = found_on(&bus, &clock).iter().map(ToString::to_string).collect();
    assert_eq!(
        found,
        [
            "IST8310 at 0x0c",
            "BMM150 at 0x13",
            "BMM350 at 0x15",
            "LIS3MDL at 0x1e",
            "RM3100 at 0x23",
            "QMC6310 at 0x3c"
        ]
    );
}

#[test]
fn what_is_ambiguous_is_said_and_decided_by_the_caller() {
    let (clock, bus) = empty();
    attach(&bus, Kind::Hmc5883l);
    assert_eq!(found_on(&bus, &clock)[0].to_string(), "HMC5883L at 0x1e");
    put_accelerometer(&bus);
    let found = found_on(&bus, &clock)[0];
    assert_eq!(found.to_string(), "LSM303DLHC at 0x1e (or HMC5883L)");
    assert!(found.is_ambiguous());
    let decided = found.as_kind(Kind::Hmc5883l);
    assert!(!decided.is_ambiguous());
    let driver = AnyMagnetometer::new(bus, SimDelay(clock), decided);
    assert_eq!(driver.describe().name, "HMC5883L");
}

#[test]
fn strangers_are_counted_not_written_to_and_not_taken_for_a_chip() {
    for reads in [0x00, 0xff, 0x10, 0x3d, 0x40] {
        let (clock, bus) = empty();
        // An EEPROM, and a chip at every address that is asked but those of a BMM150, which has to be woken.
        bus.attach(Rc::new(RefCell::new(At24cChip::new(0x50, 4096, 32))));
        let addresses = [0x0d_u8, 0x19, 0x2c, 0x30, 0x68, 0x69];
        for address in addresses {
            put(&bus, address, reads);
        }
        let findings = probe(&mut bus.clone(), &mut SimDelay(clock));
        // 0x10 at register 0 of 0x0d is what an IST8310 says, and at 0x39 of 0x30 an MMC5603; the rest are nobody.
        let most = if reads == 0x10 { 2 } else { 0 };
        assert!(findings.iter().count() <= most, "{reads:#04x}: {:?}", findings.iter().collect::<Vec<_>>());
        assert_eq!(
            usize::from(findings.strangers) + findings.iter().count(),
            addresses.len() - 1,
            "{reads:#04x}"
        );
        assert_eq!(findings.trouble, None);
    }
}

#[test]
fn a_display_at_the_address_of_a_qmc6310n_is_none() {
    // Whatever is read of it is its status, with the busy bit of an SH1106 where a QMC6310 has its identity.
    let (clock, bus) = empty();
    put(&bus, 0x3c, 0x80);
    let findings = probe(&mut bus.clone(), &mut SimDelay(clock));
    assert_eq!((findings.first(), findings.trouble, findings.strangers), (None, None, 1));
}

#[test]
fn an_empty_bus_is_empty_and_a_held_one_is_trouble() {
    let (clock, bus) = empty();
    let faults = FaultControl::new();
    let mut wire = Faulty::new(bus.clone(), faults.clone());
    let mut delay = SimDelay(clock.clone());
    let findings = probe(&mut wire, &mut delay);
    assert_eq!((findings.first(), findings.trouble, findings.strangers), (None, None, 0));
    faults.hold_bus();
    let findings = probe(&mut wire, &mut delay);
    assert_eq!((findings.first(), findings.trouble), (None, Some(ErrorKind::Bus)));
    faults.clear();
    attach(&bus, Kind::Rm3100);
    assert_eq!(probe(&mut wire, &mut delay).first().map(|found| found.kind), Some(Kind::Rm3100));
}

#[test]
fn a_fault_at_any_byte_of_a_probing_hides_a_chip_at_most_and_never_makes_another() {
    for kind in KINDS {
        let healthy = {
            let (clock, bus) = empty();
            attach(&bus, kind);
            found_on(&bus, &clock)
        };
        for transaction in 0..60 {
            for byte in 0..5 {
                let (clock, bus) = empty();
                attach(&bus, kind);
                let faults = FaultControl::new();
                faults.set(move |t, b| if (t, b) == (transaction, byte) { Hit::Nack } else { Hit::Pass });
                let mut wire = Faulty::new(bus, faults);
                let findings = probe(&mut wire, &mut SimDelay(clock));
                for found in findings.iter() {
                    let same = |one: &Found| one.address == found.address && one.kind == found.kind;
                    assert!(healthy.iter().any(same), "{kind:?} {transaction} {byte}: {found:?}");
                }
            }
        }
    }
}

#[test]
fn the_awaited_probing_finds_the_same() {
    for kind in KINDS {
        let (clock, bus) = empty();
        attach(&bus, kind);
        let mut awaited = crate::twins::Awaited(bus.clone());
        let mut delay = crate::twins::Awaited(SimDelay(clock.clone()));
        let findings = embassy_futures::block_on(asynch::probe(&mut awaited, &mut delay));
        assert_eq!(findings.iter().collect::<Vec<_>>(), found_on(&bus, &clock), "{kind:?}");
    }
}
