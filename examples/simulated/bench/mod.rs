//! The hardware of the two example firmwares: an LSM303DLHC and an AT24C32 on a simulated I²C bus, on a board that is turned in a
//! field of 50 µT. Not part of what the examples show.
#![allow(dead_code, reason = "each example uses its own part")]

use std::cell::RefCell;
use std::rc::Rc;

use eeprom24x::{Eeprom24x, SlaveAddr, Storage, addr_size::TwoBytes, page_size::B32, unique_serial};
use ironout::store::StorageSlots;
use ironout_drivers::lsm303dlhc::{Config, Lsm303dlhc, Range};
use ironout_rig::board::SimDelay;
use ironout_rig::bus::{Clock, SimBus};
use ironout_rig::chips::{At24cChip, Lsm303dlhcChip};
use ironout_simulation::{Motion, World, WorldOptions};

pub type Sensor = Lsm303dlhc<SimBus>;
pub type Store = StorageSlots<Storage<SimBus, B32, TwoBytes, unique_serial::No, SimDelay>>;

/// Hard iron of the board, µT.
pub const HARD_IRON_UT: [f64; 3] = [93.0, 40.0, -70.0];

/// The chips, and the drivers that a firmware would make of its peripherals.
pub struct Bench {
    pub clock: Clock,
    pub chip: Rc<RefCell<Lsm303dlhcChip>>,
    pub sensor: Sensor,
    pub store: Store,
}

impl Bench {
    pub fn new() -> Self {
        let options = WorldOptions {
            seed: 7,
            motion: Motion::Sphere,
            hard_iron_ut: Some(HARD_IRON_UT),
            ..Default::default()
        };
        let world = World::new(options);
        let chip = Rc::new(RefCell::new(Lsm303dlhcChip::new(move |t_s| world.sensor_ut(t_s), 0.05, 7)));
        let clock = Clock::default();
        let bus = SimBus::new(clock.clone());
        bus.attach(chip.clone());
        bus.attach(Rc::new(RefCell::new(At24cChip::new(0x50, 4096, 32))));
        let config = Config { range: Range::Gauss1_9, ..Config::default() };
        let eeprom = Eeprom24x::new_24x32(bus.clone(), SlaveAddr::default());
        let eeprom = Storage::new(eeprom, SimDelay(clock.clone()));
        let store = StorageSlots::new(eeprom, 0, 32).expect("two slots fit into 4 KiB");
        Self { sensor: Lsm303dlhc::new(bus, config), store, clock, chip }
    }
}

/// What a user types, and when, ms.
pub const SCRIPT: [(u64, &str); 7] = [
    (200, "field 50"),
    (300, "cal start"),
    (10_000, "status"),
    (50_000, "cal stop"),
    (50_300, "cal accept"),
    (50_500, "stream cal"),
    (60_000, "version"),
];
/// When the example ends, ms.
pub const END_MS: u64 = 60_500;

/// Shows what the console said, and holds it against what has to come of the script at `rate_hz` samples a second.
pub fn check(console: &str, rate_hz: f64) {
    let mut errors_ut = Vec::new();
    for line in console.lines() {
        match line.strip_prefix("C,").and_then(|values| values.split(',').nth(4)) {
            Some(norm_ut) => errors_ut.push(norm_ut.parse::<f64>().expect("a corrected sample") - 50.0),
            None => println!("{line}"),
        }
    }
    let rms_ut = (errors_ut.iter().map(|e| e * e).sum::<f64>() / errors_ut.len() as f64).sqrt();
    println!("{} corrected samples, rms of the magnitude's error {rms_ut:.3} uT", errors_ut.len());
    assert!(console.contains("ok verdict=accepted") && console.contains("ok calibrated=1"), "{console}");
    assert!(console.contains("samples_lost=0"), "{console}");
    assert!(rms_ut < 0.15, "{rms_ut}");
    let expected = rate_hz * (END_MS - 50_500) as f64 / 1000.0;
    assert!((errors_ut.len() as f64 - expected).abs() < 0.02 * expected, "{} samples", errors_ut.len());
}
