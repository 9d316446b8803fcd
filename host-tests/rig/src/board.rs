//! A simulated board: the unchanged drivers and application on the simulated bus, chips and clock.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_hal::i2c::ErrorKind;
use ironout::device::{ButtonEvent, Device, DeviceConfig, SensorAnswer, SensorFault, SensorTask};
use ironout::store::{Slots, StorageSlots};
use ironout_drivers::at24c::{At24c, Geometry};
use ironout_drivers::lsm303dlhc::{Config, DataRate, Lsm303dlhc, Range};
use ironout_drivers::{Error, Magnetometer};

use crate::bus::{Clock, FaultControl, Faulty, SimBus};
use crate::chips::{At24cChip, FieldSource, Lsm303dlhcChip};

type Wire = Faulty<SimBus>;

/// Samples are taken 50 times a second, as on the real boards.
const SAMPLE_PERIOD_MS: u32 = 20;
/// How the sensor is used: 75 Hz, so that a new measurement waits at every sample.
const SENSOR: Config = Config {
    range: Range::Gauss1_9,
    rate: DataRate::Hz75,
    temperature: true,
    temperature_format: ironout_drivers::lsm303dlhc::TemperatureFormat::LeftJustified,
};

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
    sensor: Lsm303dlhc<Wire>,
    store: StorageSlots<At24c<Wire>>,
    console: String,
}

impl SimBoard {
    /// A board with an erased EEPROM in this field, its sensor with this noise (µT on each axis); powered up.
    pub fn new(field: impl FieldSource + 'static, noise_ut: f64, seed: u64) -> Self {
        let mag = Rc::new(RefCell::new(Lsm303dlhcChip::new(field, noise_ut, seed)));
        let geometry = Geometry::AT24C32;
        let (size, page) = (geometry.size_bytes as usize, usize::from(geometry.page_bytes));
        let eeprom = Rc::new(RefCell::new(At24cChip::new(geometry.address, size, page)));
        let clock = Clock::default();
        let bus = SimBus::new(clock.clone());
        bus.attach(mag.clone());
        bus.attach(eeprom.clone());
        let (sensor_faults, store_faults) = (FaultControl::new(), FaultControl::new());
        let sensor = Lsm303dlhc::new(Faulty::new(bus.clone(), sensor_faults.clone()), SENSOR);
        let wire = Faulty::new(bus.clone(), store_faults.clone());
        let store = StorageSlots::new(At24c::new(wire, geometry).expect("a chip of the family"), 0);
        let device = Self::device(&sensor);
        let mut board = Self {
            clock,
            bus,
            mag,
            eeprom,
            sensor_faults,
            store_faults,
            device,
            sensor,
            store,
            console: String::new(),
        };
        board.restart();
        board
    }

    fn device(sensor: &Lsm303dlhc<Wire>) -> Device {
        Device::new(DeviceConfig {
            board: "simulated",
            sensor: sensor.name(),
            ut_per_count: sensor.ut_per_count(),
            sample_period_ms: SAMPLE_PERIOD_MS,
        })
    }

    /// Power off and on: everything but the EEPROM's cells is forgotten. Returns what was found in the slots.
    pub fn restart(&mut self) -> Slots {
        self.mag.borrow_mut().power_cycle();
        self.eeprom.borrow_mut().power_cycle();
        self.console.clear();
        self.device = Self::device(&self.sensor);
        self.device.boot(&mut self.store)
    }

    /// Lets the board run; every millisecond it looks at its sensor.
    pub fn run_ms(&mut self, ms: u64) {
        let from_ms = self.clock.ms();
        for t_ms in from_ms + 1..=from_ms + ms {
            self.clock.advance_to_ms(t_ms);
            let sensor = &mut self.sensor;
            self.device
                .tick(self.clock.ms(), &mut self.console, |task| serve(sensor, task))
                .expect("a string takes everything");
        }
    }

    /// Sends bytes to the console.
    pub fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.device.on_byte(byte, &mut self.console, &mut self.store).expect("a string takes everything");
        }
    }

    /// What the console has sent since this was asked last, by lines.
    pub fn received(&mut self) -> Vec<String> {
        std::mem::take(&mut self.console).lines().map(str::to_owned).collect()
    }

    /// Sends one command and returns its answer; stream lines that came before it are dropped.
    pub fn command(&mut self, line: &str) -> Vec<String> {
        self.console.clear();
        self.send(line.as_bytes());
        self.send(b"\n");
        self.received()
    }

    /// Presses the button.
    pub fn press(&mut self) -> ButtonEvent {
        self.device.on_button(&mut self.store)
    }

    /// The temperature that the sensor's driver reads.
    ///
    /// # Errors
    /// Those of the driver.
    pub fn temperature_c(&mut self) -> Result<Option<f32>, Error<ErrorKind>> {
        self.sensor.temperature_c()
    }
}

/// Does with the sensor what the application asks for.
fn serve<M: Magnetometer>(sensor: &mut M, task: SensorTask) -> SensorAnswer {
    let answer = match task {
        SensorTask::Start => sensor.init().map(|()| SensorAnswer::Started),
        SensorTask::Sample => match sensor.data_ready() {
            Ok(false) => Ok(SensorAnswer::NotReady),
            Ok(true) => sensor.read().map(|reading| SensorAnswer::Sample {
                counts: reading.counts,
                saturated: reading.saturated(),
            }),
            Err(error) => Err(error),
        },
    };
    answer.unwrap_or_else(|error| {
        SensorAnswer::Failed(match error {
            Error::Bus(_) => SensorFault::NoAnswer,
            Error::NotFound { expected, found } => SensorFault::WrongChip { expected, found },
            Error::NotKept { .. } | Error::InvalidConfig(_) => SensorFault::NotKept,
        })
    })
}
