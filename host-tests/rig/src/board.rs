//! A simulated board: the unchanged drivers and application on the simulated bus, chips and clock.

use std::cell::RefCell;
use std::rc::Rc;

use eeprom24x::{Eeprom24x, SlaveAddr, addr_size::TwoBytes, page_size::B32, unique_serial};
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::ErrorKind;
use ironout::device::{ButtonEvent, Device, DeviceConfig, Pace};
use ironout::sensor::{AxisMap, Error, Magnetometer, Sensor};
use ironout::store::StorageSlots;
use ironout_drivers::lsm303dlhc::{Config, DataRate, Lsm303dlhc, Range, TemperatureFormat};

use crate::bus::{Clock, FaultControl, Faulty, SimBus};
use crate::chips::{At24cChip, FieldSource, Lsm303dlhcChip};

type Wire = Faulty<SimBus>;
/// An AT24C32 with the driver of the boards.
type Eeprom = eeprom24x::Storage<Wire, B32, TwoBytes, unique_serial::No, SimDelay>;

const EEPROM_ADDRESS: u8 = 0x50;
const EEPROM_BYTES: usize = 4096;
const EEPROM_PAGE_BYTES: usize = 32;

/// A wait on the simulated clock.
pub struct SimDelay(pub Clock);

impl DelayNs for SimDelay {
    fn delay_ns(&mut self, ns: u32) {
        self.0.advance_ns(u64::from(ns));
    }
}

/// How the board is put together.
#[derive(Clone, Copy, Debug)]
pub struct SimOptions {
    /// The sensor's configuration.
    pub sensor: Config,
    /// How its chip sits on the board.
    pub mounting: AxisMap,
    /// When samples are taken.
    pub pace: Pace,
}

impl Default for SimOptions {
    /// As on the emulated board: 50 samples a second of a sensor that measures 75 times, its axes those of the board.
    fn default() -> Self {
        Self {
            sensor: Config {
                range: Range::Gauss1_9,
                rate: DataRate::Hz75,
                temperature: true,
                temperature_format: TemperatureFormat::LeftJustified,
            },
            mounting: AxisMap::IDENTITY,
            pace: Pace::Every(20),
        }
    }
}

/// The board, its chips and the hands of the one who tests it.
pub struct SimBoard {
    /// The time.
    pub clock: Clock,
    /// The wires.
    pub bus: SimBus,
    /// The magnetometer chip.
    pub mag: Rc<RefCell<Lsm303dlhcChip>>,
    /// The EEPROM chip: its memory survives [`Self::restart`].
    pub eeprom: Rc<RefCell<At24cChip>>,
    /// Faults between the sensor's driver and the bus.
    pub sensor_faults: FaultControl,
    /// Faults between the EEPROM's driver and the bus.
    pub store_faults: FaultControl,
    /// The application.
    pub device: Device,
    options: SimOptions,
    since_ms: u64,
    sensor: Lsm303dlhc<Wire>,
    store: StorageSlots<Eeprom>,
    console: Terminal,
}

/// A terminal that takes everything.
#[derive(Default)]
struct Terminal(String);

impl std::fmt::Write for Terminal {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0.write_str(text)
    }
}

impl ironout::device::Output for Terminal {
    fn takes(&self, _bytes: usize) -> bool {
        true
    }
}

impl SimBoard {
    /// What the driver says of its sensor.
    pub fn sensor(&self) -> Sensor {
        self.sensor.describe()
    }

    /// A board with an erased EEPROM in this field, its sensor with this noise (µT on each axis); powered up.
    pub fn new(field: impl FieldSource + 'static, noise_ut: f64, seed: u64) -> Self {
        Self::with(SimOptions::default(), field, noise_ut, seed)
    }

    /// The same, put together like this. The field is that along the chip's axes.
    pub fn with(options: SimOptions, field: impl FieldSource + 'static, noise_ut: f64, seed: u64) -> Self {
        let mag = Rc::new(RefCell::new(Lsm303dlhcChip::new(field, noise_ut, seed)));
        let eeprom = At24cChip::new(EEPROM_ADDRESS, EEPROM_BYTES, EEPROM_PAGE_BYTES);
        let eeprom = Rc::new(RefCell::new(eeprom));
        let clock = Clock::default();
        let bus = SimBus::new(clock.clone());
        bus.attach(mag.clone());
        bus.attach(eeprom.clone());
        let (sensor_faults, store_faults) = (FaultControl::new(), FaultControl::new());
        let sensor = Lsm303dlhc::new(Faulty::new(bus.clone(), sensor_faults.clone()), options.sensor);
        let wire = Faulty::new(bus.clone(), store_faults.clone());
        let storage = Eeprom::new(Eeprom24x::new_24x32(wire, SlaveAddr::default()), SimDelay(clock.clone()));
        let store = StorageSlots::new(storage, 0, EEPROM_PAGE_BYTES as u32).expect("two slots fit");
        let device = Self::device(&sensor, &options);
        let mut board = Self {
            clock,
            bus,
            mag,
            eeprom,
            sensor_faults,
            store_faults,
            device,
            options,
            since_ms: 0,
            sensor,
            store,
            console: Terminal::default(),
        };
        board.restart();
        board
    }

    fn device(sensor: &Lsm303dlhc<Wire>, options: &SimOptions) -> Device {
        Device::new(DeviceConfig {
            board: "simulated",
            sensor: sensor.describe().mounted(options.mounting),
            pace: options.pace,
        })
    }

    /// Power off and on: everything but the EEPROM's cells is forgotten. Nothing has run yet.
    pub fn restart(&mut self) {
        self.mag.borrow_mut().power_cycle();
        self.eeprom.borrow_mut().power_cycle();
        self.console.0.clear();
        self.device = Self::device(&self.sensor, &self.options);
        // The device's clock begins anew.
        self.since_ms = self.clock.ms();
    }

    /// Milliseconds since power-up, as the board counts them.
    fn now_ms(&self) -> u64 {
        self.clock.ms() - self.since_ms
    }

    /// One turn of the board's loop; `false` where it would sleep.
    fn turn(&mut self) -> bool {
        let now_ms = self.now_ms();
        self.device.turn(now_ms, &mut self.sensor, &mut self.store, &mut self.console)
    }

    /// Sleeps until the next turn is due, but not beyond `end_ms` of the clock.
    fn sleep(&self, end_ms: u64) {
        let due_ms = self.device.next_deadline_ms().saturating_add(self.since_ms);
        self.clock.advance_to_ms(due_ms.clamp(self.clock.ms() + 1, end_ms.max(self.clock.ms() + 1)));
    }

    /// Lets the board run, asleep whenever nothing is due.
    pub fn run_ms(&mut self, ms: u64) {
        let end_ms = self.clock.ms() + ms;
        while self.clock.ms() < end_ms {
            if !self.turn() {
                self.sleep(end_ms);
            }
        }
        while self.turn() {}
    }

    /// Lets the board run until it has dealt with all that it was given.
    fn settle(&mut self) {
        while !self.device.is_idle() {
            if !self.turn() {
                self.sleep(u64::MAX);
            }
        }
    }

    /// Sends bytes to the console and waits for the answers.
    pub fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            while !self.device.take_byte(byte) {
                self.settle();
            }
        }
        self.settle();
    }

    /// What the console has sent since this was asked last, by lines.
    pub fn received(&mut self) -> Vec<String> {
        std::mem::take(&mut self.console.0).lines().map(str::to_owned).collect()
    }

    /// Sends one command and returns its answer; stream lines that came before it are dropped.
    pub fn command(&mut self, line: &str) -> Vec<String> {
        self.console.0.clear();
        self.send(line.as_bytes());
        self.send(b"\n");
        self.received()
    }

    /// Presses the button and waits for what comes of it.
    pub fn press(&mut self) -> ButtonEvent {
        self.device.on_press();
        self.settle();
        self.device.take_event().expect("every press does something")
    }

    /// The temperature that the sensor's driver reads.
    ///
    /// # Errors
    /// Those of the driver.
    pub fn temperature_c(&mut self) -> Result<Option<f32>, Error<ErrorKind>> {
        self.sensor.temperature_c()
    }
}
