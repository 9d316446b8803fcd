//! ST LIS3MDL: 16 bits, ±4 to ±16 G, 0.625 to 155 Hz.
//!
//! From the datasheet (DocID 024204): sensitivities table 3, temperature table 4, registers section 7; self-test by application
//! note AN4602.
//!
//! | what | where |
//! |---|---|
//! | address | 0x1c or 0x1e, by pin SA1 |
//! | identity | WHO_AM_I 0x0f = 0x3d |
//! | output | OUT_X_L 0x28 to 0x2d, low byte first (CTRL_REG4 bit BLE clear); bit 7 of the sub-address lets the pointer go on |
//! | status | STATUS_REG 0x27, bit 3 ZYXDA |
//! | temperature | 0x2e, low byte first, 8 counts per °C, 0 at 25 °C |
//! | self-test | CTRL_REG1 bit 0 at ±12 G: 1 to 3 G on x and y, 0.1 to 1 G on z |

use super::description::{Chip, Identity, Thermometer, Write};
use super::self_test::{Good, Plan, SelfTest};
use ironout_sensor::{AxisMap, Reading, Sensor};

/// Both addresses, by the level of pin SA1.
pub const ADDRESSES: [u8; 2] = [0x1c, 0x1e];
/// Who it is.
pub const WHO_AM_I: u8 = 0x0f;
/// What [`WHO_AM_I`] reads.
pub const IDENTITY: u8 = 0x3d;
/// Temperature (bit 7), performance of x and y (6–5), rate (4–2), fast rate (1), self-test (0).
pub const CTRL_1: u8 = 0x20;
/// Range (bits 6–5).
pub const CTRL_2: u8 = 0x21;
/// Mode (bits 1–0): 0 is continuous.
pub const CTRL_3: u8 = 0x22;
/// Performance of z (bits 3–2), byte order (1).
pub const CTRL_4: u8 = 0x23;
/// Block data update (bit 6).
pub const CTRL_5: u8 = 0x24;
/// Bit 3: a new set of data.
pub const STATUS: u8 = 0x27;
/// The first of the six output bytes.
pub const OUT_X_L: u8 = 0x28;
/// The first of the two temperature bytes.
pub const TEMP_OUT_L: u8 = 0x2e;
/// [`CTRL_1`]: the temperature sensor runs.
pub const TEMP_EN: u8 = 1 << 7;
/// [`CTRL_1`]: x and y at ultra-high performance; 155 Hz with [`FAST_ODR`].
pub const ULTRA_HIGH_XY: u8 = 3 << 5;
/// [`CTRL_1`]: the rate follows from the performance.
pub const FAST_ODR: u8 = 1 << 1;
/// [`CTRL_1`]: self-test.
pub const SELF_TEST: u8 = 1 << 0;
/// [`CTRL_4`]: z at ultra-high performance.
pub const ULTRA_HIGH_Z: u8 = 3 << 2;
/// [`CTRL_5`]: output bytes of one measurement stay together.
pub const BDU: u8 = 1 << 6;
/// [`STATUS`]: new data on all axes.
pub const ZYXDA: u8 = 1 << 3;

/// Measuring range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Range {
    #[default]
    Gauss4,
    Gauss8,
    Gauss12,
    Gauss16,
}

impl Range {
    /// All ranges, the finest first.
    pub const ALL: [Range; 4] = [Range::Gauss4, Range::Gauss8, Range::Gauss12, Range::Gauss16];

    /// The byte for [`CTRL_2`].
    pub const fn bits(self) -> u8 {
        (self as u8) << 5
    }

    /// Counts per gauss.
    pub const fn counts_per_gauss(self) -> u16 {
        match self {
            Range::Gauss4 => 6842,
            Range::Gauss8 => 3421,
            Range::Gauss12 => 2281,
            Range::Gauss16 => 1711,
        }
    }
}

/// Measurements a second, all at ultra-high performance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum DataRate {
    Hz10,
    Hz20,
    Hz40,
    #[default]
    Hz80,
    Hz155,
}

impl DataRate {
    /// The rate bits of [`CTRL_1`].
    pub const fn bits(self) -> u8 {
        match self {
            DataRate::Hz10 => 4 << 2,
            DataRate::Hz20 => 5 << 2,
            DataRate::Hz40 => 6 << 2,
            DataRate::Hz80 => 7 << 2,
            DataRate::Hz155 => FAST_ODR,
        }
    }

    /// Measurements a second.
    pub const fn hz(self) -> f32 {
        match self {
            DataRate::Hz10 => 10.0,
            DataRate::Hz20 => 20.0,
            DataRate::Hz40 => 40.0,
            DataRate::Hz80 => 80.0,
            DataRate::Hz155 => 155.0,
        }
    }
}

/// The whole configuration. The default: address 0x1c, ±4 G, 80 Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// One of [`ADDRESSES`].
    pub address: u8,
    /// Measuring range.
    pub range: Range,
    /// Measurements a second.
    pub rate: DataRate,
}

impl Default for Config {
    fn default() -> Self {
        Self { address: ADDRESSES[0], range: Range::default(), rate: DataRate::default() }
    }
}

impl Config {
    fn registers(ctrl_1: u8, range: Range) -> [Write; 5] {
        [
            Write::kept(CTRL_1, ctrl_1),
            Write::kept(CTRL_2, range.bits()),
            Write::kept(CTRL_3, 0),
            Write::kept(CTRL_4, ULTRA_HIGH_Z),
            Write::kept(CTRL_5, BDU),
        ]
    }
}

impl Chip for Config {
    const IDENTITY: Identity = Identity { register: WHO_AM_I, bytes: &[IDENTITY] };
    const STATUS: (u8, u8) = (STATUS, ZYXDA);
    const OUTPUT: u8 = OUT_X_L;
    const INCREMENT: u8 = 0x80;
    const DROPPED: u8 = 1;
    type Output = [u8; 6];
    type Writes = [Write; 5];

    fn address(&self) -> u8 {
        self.address
    }

    fn writes(&self) -> [Write; 5] {
        Self::registers(TEMP_EN | ULTRA_HIGH_XY | self.rate.bits(), self.range)
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "LIS3MDL",
            ut_per_count: [100.0 / f32::from(self.range.counts_per_gauss()); 3],
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
        Thermometer::Burst(TEMP_OUT_L)
    }

    fn celsius(&self, bytes: [u8; 2]) -> f32 {
        25.0 + f32::from(i16::from_le_bytes(bytes)) / 8.0
    }
}

impl SelfTest for Config {
    /// AN4602: ±12 G, 80 Hz, the mean of five measurements without and with the test's field, 60 ms apart.
    fn plan(&self) -> Plan<[Write; 5]> {
        let ctrl_1 = DataRate::Hz80.bits();
        let (xy, z) = ((2281, 6843), (228, 2281));
        Plan {
            before: Self::registers(ctrl_1, Range::Gauss12),
            start: Write::kept(CTRL_1, ctrl_1 | SELF_TEST),
            settling_ms: 60,
            samples: 5,
            patience_ms: 100,
            good: Good::Step([xy, xy, z]),
        }
    }
}
