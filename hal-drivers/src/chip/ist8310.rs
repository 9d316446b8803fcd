//! iSentek IST8310: ±1600 µT on x and y, ±2500 µT on z, measures when told, 166 times a second at most.
//!
//! From the datasheet (version 1.2 and later) as quoted by the register lists of PX4 (16-bit outputs, averages, pulse) and by
//! DJI's and Taproot's drivers.
//!
//! | what | where |
//! |---|---|
//! | address | 0x0c to 0x0f by its pins, as a rule 0x0e |
//! | identity | WAI 0x00 = 0x10 |
//! | output | 0x03 to 0x08, low byte first; 1320 counts per gauss with 16-bit outputs |
//! | status | STAT1 0x02: bit 0 DRDY, bit 1 DOR |
//! | measurement | CNTL1 0x0a = 1 starts a single one |
//! | temperature | a register (0x1c) whose scale could not be checked; not offered here |
//! | self-test | STR 0x0c bit 6 turns the sign of the outputs around |

use super::description::{Chip, Identity, Write};
use super::self_test::{Good, Plan, SelfTest};
use ironout_sensor::{AxisMap, Reading, Sensor};

/// All addresses, by the levels of pins CAD0 and CAD1.
pub const ADDRESSES: [u8; 4] = [0x0c, 0x0d, 0x0e, 0x0f];
/// The address of most boards.
pub const USUAL_ADDRESS: u8 = 0x0e;
/// Who it is.
pub const WAI: u8 = 0x00;
/// What [`WAI`] reads.
pub const IDENTITY: u8 = 0x10;
/// Data ready (bit 0), data skipped (1).
pub const STAT1: u8 = 0x02;
/// The first of the six output bytes.
pub const DATA_X_L: u8 = 0x03;
/// Mode: 1 is a single measurement.
pub const CNTL1: u8 = 0x0a;
/// Self-test (bit 6).
pub const STR: u8 = 0x0c;
/// 16-bit outputs (bits 6–4, one an axis).
pub const CNTL3: u8 = 0x0d;
/// Averages of y (bits 5–3), of x and z (2–0).
pub const AVGCNTL: u8 = 0x41;
/// Duration of the pulses (bits 7–6).
pub const PDCNTL: u8 = 0x42;
/// [`STAT1`]: a set of data waits.
pub const DRDY: u8 = 1 << 0;
/// [`CNTL1`]: a single measurement.
pub const SINGLE: u8 = 1;
/// [`STR`]: self-test.
pub const SELF_TEST: u8 = 1 << 6;
/// [`CNTL3`]: 16 bits on every axis.
pub const ALL_16_BIT: u8 = 7 << 4;
/// [`AVGCNTL`]: averages of sixteen on every axis.
pub const AVERAGE_16: u8 = 4 << 3 | 4;
/// [`PDCNTL`]: "normal (please use this setting)".
pub const PULSE_NORMAL: u8 = 3 << 6;
/// Counts per gauss with 16-bit outputs.
pub const COUNTS_PER_GAUSS: f32 = 1320.0;
/// The largest measurement of each axis in counts: 1600 µT on x and y, 2500 µT on z.
pub const FULL_SCALE: [i16; 3] = [21_120, 21_120, 32_767];

/// The whole configuration. The default: address 0x0e.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// One of [`ADDRESSES`].
    pub address: u8,
}

impl Default for Config {
    fn default() -> Self {
        Self { address: USUAL_ADDRESS }
    }
}

impl Chip for Config {
    const IDENTITY: Identity = Identity { register: WAI, bytes: &[IDENTITY] };
    const STATUS: (u8, u8) = (STAT1, DRDY);
    const OUTPUT: u8 = DATA_X_L;
    // What was measured before the configuration may wait.
    const DROPPED: u8 = 1;
    const TRIGGER: Option<Write> = Some(Write::unread(CNTL1, SINGLE));
    // Up to and with the resolution: a chip that lost it after a dip of its supply would go on measuring when told, with a quarter of
    // the counts.
    type Output = [u8; 11];
    type Writes = [Write; 4];

    fn address(&self) -> u8 {
        self.address
    }

    fn writes(&self) -> [Write; 4] {
        [
            Write::kept(STR, 0),
            Write::kept(CNTL3, ALL_16_BIT),
            Write::kept(AVGCNTL, AVERAGE_16),
            Write::kept(PDCNTL, PULSE_NORMAL),
        ]
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "IST8310",
            ut_per_count: [100.0 / COUNTS_PER_GAUSS; 3],
            axes: AxisMap::IDENTITY,
            // Sixteen averages take 6 ms; each measurement is started when the one before was read.
            rate_hz: 160.0,
            full_scale_counts: i16::MAX as u16,
            bits: 16,
            shift: 0,
        }
    }

    fn lost(&self, &[.., resolution]: &[u8; 11]) -> Option<(u8, u8, u8)> {
        (resolution & ALL_16_BIT != ALL_16_BIT).then_some((CNTL3, ALL_16_BIT, resolution))
    }

    fn decode(&self, &[xl, xh, yl, yh, zl, zh, ..]: &[u8; 11]) -> Reading {
        let counts @ [x, y, z] = [[xl, xh], [yl, yh], [zl, zh]].map(i16::from_le_bytes);
        let [fx, fy, fz] = FULL_SCALE;
        let beyond = |count: i16, most: i16| count.unsigned_abs() >= most.unsigned_abs();
        Reading { counts, overflow: [beyond(x, fx), beyond(y, fy), beyond(z, fz)] }
    }
}

impl SelfTest for Config {
    /// The outputs turn around; what does not is the chip's own offset. 33 µT are allowed for it, which a dead axis in a field
    /// below 16 µT would pass too: the figure is ours, the datasheet as quoted gives none.
    fn plan(&self) -> Plan<[Write; 4]> {
        Plan {
            before: self.writes(),
            start: Write::kept(STR, SELF_TEST),
            settling_ms: 10,
            samples: 8,
            patience_ms: 50,
            good: Good::Inverted(435),
        }
    }
}
