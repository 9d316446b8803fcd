//! Bosch BMM150: 13 bits on x and y, 15 on z, compensated by each chip's own trimming; 2 to 30 Hz.
//!
//! From the datasheet (BST-BMM150-DS001-01): chip identity 5.3 and table 5, data tables 6 to 13, power and modes 5.6, repetitions 5.9,
//! self-test 4.4.1, presets table 3. The compensation is Bosch's, as their sensor API publishes it; the trimming registers
//! (0x5d to 0x71) as Linux names them.
//!
//! | what | where |
//! |---|---|
//! | address | 0x10 to 0x13, by its pins |
//! | identity | 0x40 = 0x32, readable only with the power bit (0x4b bit 0) set and 3 ms later |
//! | output | 0x42 to 0x49, low byte first: x and y from bit 3, z from bit 1, the Hall resistance from bit 2 |
//! | status | 0x48, bit 0; an axis out of range reads −4096 (x, y), −16384 (z) |
//! | temperature | none in °C: the Hall resistance takes it out of the compensated field |
//! | self-test | 0x4c bit 0, asleep; the results are bits 0 of 0x42, 0x44, 0x46 |

use super::description::{Chip, Identity, Write};
use ironout_sensor::{AxisMap, Reading, Sensor};

/// All addresses, by the levels of its pins.
pub const ADDRESSES: [u8; 4] = [0x10, 0x11, 0x12, 0x13];
/// Who it is.
pub const CHIP_ID: u8 = 0x40;
/// What [`CHIP_ID`] reads.
pub const IDENTITY: u8 = 0x32;
/// The first of the eight output bytes.
pub const DATA_X_L: u8 = 0x42;
/// Low byte of the Hall resistance; bit 0: a set of data waits.
pub const RHALL_L: u8 = 0x48;
/// Power (bit 0), reset (bits 7 and 1).
pub const POWER: u8 = 0x4b;
/// Rate (bits 5–3), mode (2–1), self-test (0).
pub const OPERATION: u8 = 0x4c;
/// Repetitions of x and y: 2n + 1.
pub const REPETITIONS_XY: u8 = 0x51;
/// Repetitions of z: n + 1.
pub const REPETITIONS_Z: u8 = 0x52;
/// The first of the 21 trimming bytes.
pub const TRIM: u8 = 0x5d;
/// [`RHALL_L`]: a set of data waits.
pub const DRDY: u8 = 1 << 0;
/// [`POWER`]: on.
pub const POWER_ON: u8 = 1;
/// From power-on to the first access, ms.
pub const START_UP_MS: u32 = 3;
/// [`OPERATION`]: asleep.
pub const SLEEP: u8 = 3 << 1;
/// [`OPERATION`]: self-test.
pub const SELF_TEST: u8 = 1 << 0;
/// What x and y read when out of range.
pub const OVERFLOW_XY: i16 = -4096;
/// What z reads when out of range.
pub const OVERFLOW_Z: i16 = -16384;

/// Rate and repetitions, as the datasheet combines them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Preset {
    /// 10 Hz, 3 and 3 repetitions, 1.0 and 1.4 µT of noise.
    LowPower,
    /// 10 Hz, 9 and 15 repetitions, 0.6 µT.
    Regular,
    /// 10 Hz, 15 and 27 repetitions, 0.5 µT.
    EnhancedRegular,
    /// 20 Hz, 47 and 83 repetitions, 0.3 µT.
    HighAccuracy,
    /// 30 Hz, 9 and 15 repetitions: as fast as the chip measures at its rates.
    #[default]
    Fast,
}

impl Preset {
    /// Measurements a second, and the repetitions of x and y, and of z.
    pub const fn figures(self) -> (u8, u8, u8) {
        match self {
            Preset::LowPower => (10, 3, 3),
            Preset::Regular => (10, 9, 15),
            Preset::EnhancedRegular => (10, 15, 27),
            Preset::HighAccuracy => (20, 47, 83),
            Preset::Fast => (30, 9, 15),
        }
    }

    /// The byte for [`OPERATION`]: rate, and normal mode.
    pub const fn operation(self) -> u8 {
        let rate: u8 = match self.figures().0 {
            20 => 5,
            30 => 7,
            _ => 0,
        };
        rate << 3
    }
}

/// The whole configuration. The default: address 0x10, 30 Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// One of [`ADDRESSES`].
    pub address: u8,
    /// Rate and repetitions.
    pub preset: Preset,
}

impl Default for Config {
    fn default() -> Self {
        Self { address: ADDRESSES[0], preset: Preset::default() }
    }
}

/// The trimming of one chip, from its registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names are the datasheet's")]
pub struct Trim {
    pub x1: i8,
    pub y1: i8,
    pub x2: i8,
    pub y2: i8,
    pub z1: u16,
    pub z2: i16,
    pub z3: i16,
    pub z4: i16,
    pub xy1: u8,
    pub xy2: i8,
    pub xyz1: u16,
}

impl Trim {
    /// From the 21 bytes behind [`TRIM`].
    pub const fn of(bytes: [u8; 21]) -> Self {
        let [x1, y1, _, _, _, z4l, z4h, x2, y2, _, _, z2l, z2h, z1l, z1h, xyz1l, xyz1h, z3l, z3h, xy2, xy1] =
            bytes;
        Self {
            x1: x1 as i8,
            y1: y1 as i8,
            x2: x2 as i8,
            y2: y2 as i8,
            z1: u16::from_le_bytes([z1l, z1h]),
            z2: i16::from_le_bytes([z2l, z2h]),
            z3: i16::from_le_bytes([z3l, z3h]),
            z4: i16::from_le_bytes([z4l, z4h]),
            xy1,
            xy2: xy2 as i8,
            xyz1: u16::from_le_bytes([xyz1l, xyz1h]) & 0x7fff,
        }
    }

    /// Whether the chip was trimmed at all.
    pub const fn is_there(&self) -> bool {
        self.z1 != 0 && self.z2 != 0 && self.xyz1 != 0
    }

    /// x or y in sixteenths of a µT, from its count, its two factors and the Hall resistance.
    fn horizontal(&self, count: i16, first: i8, second: i8, hall: u16) -> i32 {
        let hall = if hall == 0 { self.xyz1 } else { hall };
        // How far the resistance, and with it the temperature, is from that of the trimming, 2¹⁴ to one.
        let off = (i64::from(self.xyz1) << 14).checked_div(i64::from(hall)).unwrap_or(1 << 14) - (1 << 14);
        let bend = i64::from(self.xy2) * ((off * off) >> 7) + off * (i64::from(self.xy1) << 7);
        let gain = (((bend >> 9) + 0x10_0000) * (i64::from(second) + 0xa0)) >> 12;
        clamped(((i64::from(count) * gain) >> 13) + (i64::from(first) << 3))
    }

    /// z in sixteenths of a µT.
    fn vertical(&self, count: i16, hall: u16) -> i32 {
        let drift = (i64::from(self.z3) * (i64::from(hall) - i64::from(self.xyz1))) >> 2;
        let gain = i64::from(self.z2) + ((i64::from(self.z1) * (i64::from(hall) << 1) + (1 << 15)) >> 16);
        let field = ((i64::from(count) - i64::from(self.z4)) << 15) - drift;
        // A gain of nothing is no trimming of any chip: the end of the range says that it is no measurement.
        clamped(field.checked_div(gain).unwrap_or(i64::MAX))
    }

    /// The compensated field of these counts and this Hall resistance, sixteenths of a µT.
    pub fn compensate(&self, [x, y, z]: [i16; 3], hall: u16) -> [i32; 3] {
        [
            self.horizontal(x, self.x1, self.x2, hall),
            self.horizontal(y, self.y1, self.y2, hall),
            self.vertical(z, hall),
        ]
    }
}

fn clamped(value: i64) -> i32 {
    value.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

/// A configuration with the trimming of the chip at hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Trimmed {
    /// What was asked for.
    pub config: Config,
    /// What the chip holds.
    pub trim: Trim,
}

impl Chip for Trimmed {
    const IDENTITY: Identity = Identity { register: CHIP_ID, bytes: &[IDENTITY] };
    const STATUS: (u8, u8) = (RHALL_L, DRDY);
    const OUTPUT: u8 = DATA_X_L;
    const DROPPED: u8 = 1;
    type Output = [u8; 8];
    type Writes = [Write; 3];

    fn address(&self) -> u8 {
        self.config.address
    }

    fn writes(&self) -> [Write; 3] {
        let (_, xy, z) = self.config.preset.figures();
        [
            Write::kept(REPETITIONS_XY, xy / 2),
            Write::kept(REPETITIONS_Z, z - 1),
            Write::kept(OPERATION, self.config.preset.operation()),
        ]
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "BMM150",
            ut_per_count: [1.0 / 16.0; 3],
            axes: AxisMap::IDENTITY,
            rate_hz: f32::from(self.config.preset.figures().0),
            full_scale_counts: i16::MAX as u16,
            bits: 16,
            shift: 0,
        }
    }

    fn decode(&self, &[xl, xh, yl, yh, zl, zh, hl, hh]: &[u8; 8]) -> Reading {
        let x = i16::from_le_bytes([xl, xh]) >> 3;
        let y = i16::from_le_bytes([yl, yh]) >> 3;
        let z = i16::from_le_bytes([zl, zh]) >> 1;
        let hall = u16::from_le_bytes([hl, hh]) >> 2;
        let overflow = [x == OVERFLOW_XY, y == OVERFLOW_XY, z == OVERFLOW_Z || hall == 0];
        Reading::carried(self.trim.compensate([x, y, z], hall), 0, overflow)
    }
}
