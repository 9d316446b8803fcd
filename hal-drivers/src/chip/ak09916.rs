//! AKM AK09916: 16 bits, ±4912 µT, 10 to 100 Hz. Alone, or in a TDK ICM-20948 (see [`icm20948`](crate::icm20948)).
//!
//! From the datasheet: register map, operating modes, self-test, sensitivity.
//!
//! | what | where |
//! |---|---|
//! | address | 0x0c |
//! | identity | WIA1 0x00 = 0x48 (AKM), WIA2 0x01 = 0x09 |
//! | output | HXL 0x11 to HZH 0x16, low byte first, 0.15 µT a count; ST2 0x18 must be read to end the measurement |
//! | status | ST1 0x10: bit 0 DRDY; ST2 0x18: bit 3 HOFL, the sum of the magnitudes of the axes is 4912 µT or more |
//! | temperature | none |
//! | self-test | CNTL2 = 0x10: −200 to 200 counts on x and y, −1000 to −200 on z |

use super::description::{Chip, Identity, Write};
use super::self_test::{Good, Plan, SelfTest};
use ironout_sensor::{AxisMap, Reading, Sensor};

/// The only address.
pub const ADDRESS: u8 = 0x0c;
/// The first of the two identification bytes.
pub const WIA1: u8 = 0x00;
/// What they read.
pub const IDENTITY: [u8; 2] = [0x48, 0x09];
/// Data ready (bit 0), data skipped (1).
pub const ST1: u8 = 0x10;
/// Overflow (bit 3).
pub const ST2: u8 = 0x18;
/// Mode.
pub const CNTL2: u8 = 0x31;
/// Reset (bit 0).
pub const CNTL3: u8 = 0x32;
/// [`ST1`]: a set of data waits.
pub const DRDY: u8 = 1 << 0;
/// [`ST2`]: overflow.
pub const HOFL: u8 = 1 << 3;
/// [`CNTL2`]: asleep.
pub const POWER_DOWN: u8 = 0;
/// [`CNTL2`]: self-test.
pub const SELF_TEST: u8 = 0x10;
/// The largest magnitude of a count.
pub const FULL_SCALE: u16 = 32_752;

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
    /// The byte for [`CNTL2`].
    pub const fn bits(self) -> u8 {
        (self as u8 + 1) << 1
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

/// The whole configuration. The default: 100 Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Measurements a second.
    pub rate: DataRate,
}

/// From asleep into a mode. Between the two the chip needs 100 µs: the reset register, written without a reset, takes 67 of
/// them at the fastest clock that the chip knows (400 kHz), and the mode itself as many.
fn woken(mode: u8) -> [Write; 3] {
    [Write::unread(CNTL2, POWER_DOWN), Write::unread(CNTL3, 0), Write::kept(CNTL2, mode)]
}

impl Chip for Config {
    const IDENTITY: Identity = Identity { register: WIA1, bytes: &IDENTITY };
    const STATUS: (u8, u8) = (ST1, DRDY);
    // From ST1 to ST2, which ends the measurement.
    const OUTPUT: u8 = ST1;
    type Output = [u8; 9];
    type Writes = [Write; 3];

    fn address(&self) -> u8 {
        ADDRESS
    }

    fn writes(&self) -> [Write; 3] {
        woken(self.rate.bits())
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "AK09916",
            ut_per_count: [0.15; 3],
            axes: AxisMap::IDENTITY,
            rate_hz: self.rate.hz(),
            full_scale_counts: FULL_SCALE,
            bits: 16,
            shift: 0,
        }
    }

    fn decode(&self, &[_, xl, xh, yl, yh, zl, zh, _, st2]: &[u8; 9]) -> Reading {
        let counts = [[xl, xh], [yl, yh], [zl, zh]].map(i16::from_le_bytes);
        // The limit is on the sum of all axes: no axis of it is known to be good.
        let beyond = counts.map(|count| count.unsigned_abs() > FULL_SCALE);
        Reading { counts, overflow: if st2 & HOFL != 0 { [true; 3] } else { beyond } }
    }
}

impl SelfTest for Config {
    fn plan(&self) -> Plan<[Write; 3]> {
        Plan {
            before: woken(POWER_DOWN),
            start: Write::unread(CNTL2, SELF_TEST),
            // One measurement takes 8.2 ms.
            settling_ms: 9,
            samples: 1,
            patience_ms: 50,
            good: Good::Level([(-200, 200), (-200, 200), (-1000, -200)]),
        }
    }
}
