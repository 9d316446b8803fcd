//! ST LIS2MDL, IIS2MDC, and the magnetic half of an LSM303AGR: 16 bits, ±49.152 G, 10 to 100 Hz.
//!
//! | | LIS2MDL, IIS2MDC | LSM303AGR (DocID 027765) |
//! |---|---|---|
//! | address | 0x1e (section "I2C operation") | 0x1e |
//! | identity | WHO_AM_I 0x4f = 0x40 | WHO_AM_I_M 0x4f = 0x40 |
//! | sensitivity | 1.5 mG a count, ±7 % (table "Sensor characteristics") | the same |
//! | output | OUTX_L_REG 0x68 to 0x6d, low byte first | the same |
//! | status | STATUS_REG 0x67, bit 3 Zyxda | the same |
//! | temperature | TEMP_OUT_L_REG 0x6e, 8 counts per °C, 0 at 25 °C | none in this half |
//! | self-test | CFG_REG_C bit 1; 15 to 500 mG on each axis | the same |
//!
//! The three are one set of registers and one identity; only an accelerometer at 0x19 with identity 0x33 beside it tells that
//! the chip is an LSM303AGR. Addresses as the datasheets give them, checked against ST's and the `lsm303agr` crate's register lists.
//! Bit 7 of the sub-address lets the pointer go on (needed by the LSM303AGR, without meaning to the others).

use super::description::{Chip, Identity, Thermometer, Write};
use super::self_test::{Good, Plan, SelfTest};
use ironout_sensor::{AxisMap, Reading, Sensor};

/// The only address.
pub const ADDRESS: u8 = 0x1e;
/// The first of the six bytes that are added to each measurement.
pub const OFFSET_X_L: u8 = 0x45;
/// Who it is.
pub const WHO_AM_I: u8 = 0x4f;
/// What [`WHO_AM_I`] reads.
pub const IDENTITY: u8 = 0x40;
/// Temperature compensation (bit 7), low power (4), rate (3–2), mode (1–0).
pub const CFG_A: u8 = 0x60;
/// Offset cancellation (bit 1), low-pass filter (0).
pub const CFG_B: u8 = 0x61;
/// Block data update (bit 4), self-test (1), data-ready pin (0).
pub const CFG_C: u8 = 0x62;
/// Bit 3: a new set of data.
pub const STATUS: u8 = 0x67;
/// The first of the six output bytes.
pub const OUT_X_L: u8 = 0x68;
/// The first of the two temperature bytes.
pub const TEMP_OUT_L: u8 = 0x6e;

/// [`CFG_A`]: temperature compensation, which the datasheet wants to be on.
pub const COMP_TEMP_EN: u8 = 1 << 7;
/// [`CFG_B`]: the set pulses cancel the chip's own offset.
pub const OFF_CANC: u8 = 1 << 1;
/// [`CFG_B`]: low-pass filter.
pub const LPF: u8 = 1 << 0;
/// [`CFG_C`]: output bytes of one measurement stay together.
pub const BDU: u8 = 1 << 4;
/// [`CFG_C`]: self-test.
pub const SELF_TEST: u8 = 1 << 1;
/// [`CFG_C`]: data-ready on its pin.
pub const DRDY_ON_PIN: u8 = 1 << 0;
/// [`STATUS`]: new data on all axes.
pub const ZYXDA: u8 = 1 << 3;

/// Which of the chips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Model {
    /// LIS2MDL.
    #[default]
    Lis2mdl,
    /// IIS2MDC, the industrial grade of it.
    Iis2mdc,
    /// The magnetic half of an LSM303AGR.
    Lsm303agr,
}

/// Measurements a second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum DataRate {
    Hz10,
    Hz20,
    Hz50,
    #[default]
    Hz100,
}

impl DataRate {
    /// The rate bits of [`CFG_A`].
    pub const fn bits(self) -> u8 {
        (self as u8) << 2
    }

    /// Measurements a second.
    pub const fn hz(self) -> f32 {
        match self {
            DataRate::Hz10 => 10.0,
            DataRate::Hz20 => 20.0,
            DataRate::Hz50 => 50.0,
            DataRate::Hz100 => 100.0,
        }
    }
}

/// The whole configuration. The default: LIS2MDL, 100 Hz, offset cancellation, no filter, no pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Which chip it is: its name, and whether it has a temperature.
    pub model: Model,
    /// Measurements a second.
    pub rate: DataRate,
    /// The set pulses cancel the chip's own offset, measurement by measurement.
    pub offset_cancellation: bool,
    /// The low-pass filter: a quarter of the rate instead of half of it, and less noise (3 mG rms instead of 4.5).
    pub low_pass: bool,
    /// Data-ready on the INT/DRDY pin.
    pub data_ready_pin: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            model: Model::default(),
            rate: DataRate::default(),
            offset_cancellation: true,
            low_pass: false,
            data_ready_pin: false,
        }
    }
}

impl Config {
    /// The default of this chip.
    pub fn of(model: Model) -> Self {
        Self { model, ..Self::default() }
    }

    fn cfg_b(&self) -> u8 {
        (if self.offset_cancellation { OFF_CANC } else { 0 }) | (if self.low_pass { LPF } else { 0 })
    }

    fn cfg_c(&self) -> u8 {
        BDU | if self.data_ready_pin { DRDY_ON_PIN } else { 0 }
    }

    fn registers(cfg_a: u8, cfg_b: u8, cfg_c: u8) -> [Write; 9] {
        let zero = |place: u8| Write::kept(OFFSET_X_L + place, 0);
        [
            // What somebody else stored there would be in every measurement.
            zero(0),
            zero(1),
            zero(2),
            zero(3),
            zero(4),
            zero(5),
            Write::kept(CFG_A, cfg_a),
            Write::kept(CFG_B, cfg_b),
            Write::kept(CFG_C, cfg_c),
        ]
    }
}

impl Chip for Config {
    const IDENTITY: Identity = Identity { register: WHO_AM_I, bytes: &[IDENTITY] };
    const STATUS: (u8, u8) = (STATUS, ZYXDA);
    const OUTPUT: u8 = OUT_X_L;
    const INCREMENT: u8 = 0x80;
    // The first after idle is taken while the chip settles (turn-on time, 9.4 ms at most).
    const DROPPED: u8 = 1;
    type Output = [u8; 6];
    type Writes = [Write; 9];

    fn address(&self) -> u8 {
        ADDRESS
    }

    fn writes(&self) -> [Write; 9] {
        Self::registers(COMP_TEMP_EN | self.rate.bits(), self.cfg_b(), self.cfg_c())
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: match self.model {
                Model::Lis2mdl => "LIS2MDL",
                Model::Iis2mdc => "IIS2MDC",
                Model::Lsm303agr => "LSM303AGR",
            },
            // 1.5 mG.
            ut_per_count: [0.15; 3],
            axes: AxisMap::IDENTITY,
            rate_hz: self.rate.hz(),
            full_scale_counts: i16::MAX as u16,
            bits: 16,
            shift: 0,
        }
    }

    fn decode(&self, &[xl, xh, yl, yh, zl, zh]: &[u8; 6]) -> Reading {
        let counts = [[xl, xh], [yl, yh], [zl, zh]].map(i16::from_le_bytes);
        // The chip has no flag for it: the end of the range is no measurement.
        Reading { counts, overflow: counts.map(|count| count == i16::MAX || count == i16::MIN) }
    }

    fn thermometer(&self) -> Thermometer {
        match self.model {
            Model::Lis2mdl | Model::Iis2mdc => Thermometer::Burst(TEMP_OUT_L),
            Model::Lsm303agr => Thermometer::None,
        }
    }

    fn celsius(&self, bytes: [u8; 2]) -> f32 {
        25.0 + f32::from(i16::from_le_bytes(bytes)) / 8.0
    }
}

impl SelfTest for Config {
    /// Application note AN5069, section "Magnetometer self-test": 100 Hz with offset cancellation, 60 ms to settle, 50
    /// measurements, and again with the test's field; limits of the datasheet, 15 to 500 mG.
    fn plan(&self) -> Plan<[Write; 9]> {
        Plan {
            before: Self::registers(COMP_TEMP_EN | DataRate::Hz100.bits(), OFF_CANC, BDU),
            start: Write::kept(CFG_C, BDU | SELF_TEST),
            settling_ms: 60,
            samples: 50,
            patience_ms: 100,
            good: Good::Step([(10, 333); 3]),
        }
    }
}
