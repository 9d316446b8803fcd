//! A bus with one chip of each kind, and its driver.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_hal::i2c::ErrorKind;
use ironout_drivers::{AnyMagnetometer, Error, Found, Kind, Magnetometer, Reading};
use ironout_rig::board::SimDelay;
use ironout_rig::bus::{Clock, FaultControl, Faulty, SimBus};
use ironout_rig::chips::{
    Ak09916Model, Bmm150Model, Bmm350Model, Hmc5883lModel, Icm20948Model, Ist8310Model, Lis2mdlModel,
    Lis3mdlModel, Lsm303dlhcChip, Mmc5603Model, Mmc5983maModel, Model, OtpMemory, Qmc5883lModel,
    Qmc5883pModel, Qmc6309Model, Qmc6310Model, RegisterChip, Rm3100Model, Trimming,
};

pub type Wire = Faulty<SimBus>;
pub type Driver = AnyMagnetometer<Wire, SimDelay>;

/// All kinds.
pub const KINDS: [Kind; 18] = [
    Kind::Lis2mdl,
    Kind::Iis2mdc,
    Kind::Lsm303agr,
    Kind::Lis3mdl,
    Kind::Lsm303dlhc,
    Kind::Hmc5883l,
    Kind::Qmc5883l,
    Kind::Qmc5883p,
    Kind::Qmc6309,
    Kind::Qmc6310,
    Kind::Mmc5603,
    Kind::Mmc5983ma,
    Kind::Bmm150,
    Kind::Bmm350,
    Kind::Ak09916,
    Kind::Icm20948,
    Kind::Ist8310,
    Kind::Rm3100,
];

/// The offset of the simulated MMC5983MA's and MMC5603's bridges, µT.
pub const BRIDGE_OFFSET_UT: [f64; 3] = [31.0, -12.5, 4.0];

/// What a strong field left in the simulated BMM350, µT.
pub const MAGNETISED_UT: [f64; 3] = [40.0, -25.0, 60.0];

/// A hand on a simulated chip, whichever model it is.
pub trait Hand {
    fn set_field(&self, field_ut: [f64; 3]);
    fn set_temperature(&self, celsius: f64);
    fn set_dead_axis(&self, axis: Option<usize>);
    fn set_register(&self, register: u8, byte: u8);
    fn power_cycle(&self);
    /// Its measurements do not end any more.
    fn freeze(&self);
}

impl<M: Model> Hand for RefCell<RegisterChip<M>> {
    fn set_field(&self, field_ut: [f64; 3]) {
        self.borrow_mut().set_field(move |_| field_ut);
    }
    fn set_temperature(&self, celsius: f64) {
        self.borrow_mut().temperature_c = celsius;
    }
    fn set_dead_axis(&self, axis: Option<usize>) {
        self.borrow_mut().dead_axis = axis;
    }
    fn set_register(&self, register: u8, byte: u8) {
        self.borrow_mut().registers[usize::from(register)] = byte;
    }
    fn power_cycle(&self) {
        RegisterChip::power_cycle(&mut self.borrow_mut());
    }
    fn freeze(&self) {
        self.borrow_mut().frozen = true;
    }
}

impl Hand for RefCell<Lsm303dlhcChip> {
    fn set_field(&self, field_ut: [f64; 3]) {
        self.borrow_mut().set_field(move |_| field_ut);
    }
    fn set_temperature(&self, celsius: f64) {
        self.borrow_mut().temperature_c = celsius;
    }
    fn set_dead_axis(&self, _axis: Option<usize>) {}
    fn set_register(&self, register: u8, byte: u8) {
        assert_eq!(register, 0x0a, "its identity is all that can be set");
        self.borrow_mut().set_identity([byte, b'4', b'3']);
    }
    fn power_cycle(&self) {
        Lsm303dlhcChip::power_cycle(&mut self.borrow_mut());
    }
    fn freeze(&self) {
        panic!("this model does not stop");
    }
}

/// Puts a chip of this kind on the bus, where it is when nobody has chosen another address.
pub fn attach(bus: &SimBus, kind: Kind) -> (Found, Rc<dyn Hand>) {
    let no_field = |_: f64| [0.0; 3];
    let found = |address| Found { address, kind, or: None };
    fn put<M: Model + 'static>(bus: &SimBus, chip: RegisterChip<M>) -> Rc<dyn Hand> {
        let chip = Rc::new(RefCell::new(chip));
        bus.attach(chip.clone());
        chip
    }
    match kind {
        Kind::Lis2mdl | Kind::Iis2mdc | Kind::Lsm303agr => {
            let model = Lis2mdlModel { is_lsm303agr: kind == Kind::Lsm303agr };
            (found(0x1e), put(bus, RegisterChip::new(0x1e, model, no_field)))
        }
        Kind::Lis3mdl => (found(0x1c), put(bus, RegisterChip::new(0x1c, Lis3mdlModel, no_field))),
        Kind::Lsm303dlhc => {
            let chip = Rc::new(RefCell::new(Lsm303dlhcChip::new(no_field, 0.0, 1)));
            bus.attach(chip.clone());
            (found(0x1e), chip)
        }
        Kind::Hmc5883l => {
            (found(0x1e), put(bus, RegisterChip::new(0x1e, Hmc5883lModel::default(), no_field)))
        }
        Kind::Qmc5883l => (found(0x0d), put(bus, RegisterChip::new(0x0d, Qmc5883lModel, no_field))),
        Kind::Qmc5883p => (found(0x2c), put(bus, RegisterChip::new(0x2c, Qmc5883pModel, no_field))),
        Kind::Qmc6309 => (found(0x7c), put(bus, RegisterChip::new(0x7c, Qmc6309Model::default(), no_field))),
        Kind::Qmc6310 => (found(0x1c), put(bus, RegisterChip::new(0x1c, Qmc6310Model, no_field))),
        Kind::Mmc5603 => {
            (found(0x30), put(bus, RegisterChip::new(0x30, Mmc5603Model::new(BRIDGE_OFFSET_UT), no_field)))
        }
        Kind::Mmc5983ma => {
            (found(0x30), put(bus, RegisterChip::new(0x30, Mmc5983maModel::new(BRIDGE_OFFSET_UT), no_field)))
        }
        Kind::Bmm150 => {
            (found(0x10), put(bus, RegisterChip::new(0x10, Bmm150Model::new(Trimming::default()), no_field)))
        }
        Kind::Bmm350 => {
            let model = Bmm350Model::new(OtpMemory::default(), MAGNETISED_UT);
            (found(0x14), put(bus, RegisterChip::new(0x14, model, no_field)))
        }
        Kind::Ak09916 => (found(0x0c), put(bus, RegisterChip::new(0x0c, Ak09916Model::default(), no_field))),
        Kind::Icm20948 => {
            let host = Icm20948Model::default();
            let connected = host.bypass.clone();
            put(bus, RegisterChip::new(0x68, host, no_field));
            (found(0x68), put(bus, RegisterChip::new(0x0c, Ak09916Model { connected }, no_field)))
        }
        Kind::Ist8310 => {
            let model = Ist8310Model { offset_ut: [0.0; 3] };
            (found(0x0e), put(bus, RegisterChip::new(0x0e, model, no_field)))
        }
        Kind::Rm3100 => (found(0x20), put(bus, RegisterChip::new(0x20, Rm3100Model, no_field))),
    }
}

/// A chip of a kind, its driver, and hands on everything.
pub struct Bench {
    pub kind: Kind,
    pub clock: Clock,
    pub faults: FaultControl,
    pub chip: Rc<dyn Hand>,
    pub driver: Driver,
}

impl Bench {
    /// Powered up in this field; nothing was sent yet.
    pub fn new(kind: Kind, field_ut: [f64; 3]) -> Self {
        let clock = Clock::default();
        let bus = SimBus::new(clock.clone());
        let (found, chip) = attach(&bus, kind);
        chip.set_field(field_ut);
        let faults = FaultControl::new();
        let wire = Faulty::new(bus, faults.clone());
        let driver = AnyMagnetometer::new(wire, SimDelay(clock.clone()), found);
        Self { kind, clock, faults, chip, driver }
    }

    /// Powered up and configured.
    pub fn ready(kind: Kind, field_ut: [f64; 3]) -> Self {
        let mut bench = Self::new(kind, field_ut);
        bench.driver.init().unwrap_or_else(|error| panic!("{kind:?}: {error}"));
        bench
    }

    pub fn wait_ms(&self, ms: u64) {
        self.clock.advance_ns(ms * 1_000_000);
    }

    /// Waits for a measurement, 500 ms of the chip's time at most.
    pub fn is_ready(&mut self) -> Result<bool, Error<ErrorKind>> {
        for _ in 0..500 {
            if self.driver.data_ready()? {
                return Ok(true);
            }
            self.wait_ms(1);
        }
        Ok(false)
    }

    /// The next measurement.
    pub fn next(&mut self) -> Reading {
        assert_eq!(self.is_ready(), Ok(true), "{:?}: no data", self.kind);
        self.driver.read().unwrap()
    }

    /// A measurement of the field as it is now: what was measured before is dropped.
    pub fn fresh(&mut self) -> Reading {
        self.next();
        self.next();
        self.next()
    }

    /// The same, in µT; `None` where it is out of range.
    pub fn fresh_ut(&mut self) -> Option<[f32; 3]> {
        let reading = self.fresh();
        let sensor = self.driver.describe();
        sensor.measured_ut(sensor.sample(&reading))
    }

    /// What the driver may be wrong by in a constant field, µT: half a count, and more where counts are computed.
    pub fn tolerance_ut(&self) -> f64 {
        let count = f64::from(self.driver.describe().ut_per_count[2]);
        match self.kind {
            // 13 and 15 bits of 0.3 µT, compensated.
            Kind::Bmm150 => 0.35,
            // The offset is a mean of three roundings.
            Kind::Mmc5983ma | Kind::Mmc5603 => 0.51 * count + 0.01,
            // Rounded by the chip before its compensation, and after.
            Kind::Bmm350 => 0.501 * count + 0.005,
            // Rounded by the chip, and once more to what is carried.
            Kind::Rm3100 => 0.76 * count,
            _ => 0.501 * count,
        }
    }
}

/// Whether two fields are the same to this, µT.
pub fn near(measured: [f32; 3], expected: [f64; 3], tolerance_ut: f64) -> bool {
    measured
        .into_iter()
        .zip(expected)
        .all(|(measured, expected)| (f64::from(measured) - expected).abs() <= tolerance_ut)
}
