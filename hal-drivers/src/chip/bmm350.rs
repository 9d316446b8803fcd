//! Bosch BMM350: 21 bits, ±2000 µT, compensated by what each chip holds in its OTP memory; 25 to 400 Hz.
//!
//! From the datasheet (BST-BMM350-DS001) as Bosch's sensor API quotes it: registers, commands and their times, the words of the OTP
//! memory and the compensation; PX4 does the same.
//!
//! | what | where |
//! |---|---|
//! | address | 0x14, 0x15, by its pin |
//! | identity | 0x00 = 0x33 |
//! | reading | two bytes without a meaning come before those of the registers |
//! | output | 0x31 to 0x3c, three bytes each of x, y, z and temperature, low byte first |
//! | status | 0x30: bit 2 a set of data waits, if 0x2e bit 7 is set |
//! | temperature | in the same transaction; it corrects the field. Here with 16 bits of 24, 0.25 °C |
//! | OTP memory | words 0x0d to 0x16 and 0x18: offset, sensitivity, their coefficients of temperature, cross axis |
//! | self-test | for x and y only; not offered here |
//!
//! **Magnetic reset.** A strong field (Bosch names 400 mT) leaves an offset in the sensing elements that only a bit reset and a flux-guide
//! reset take out, and nothing says that it is there. The driver does both at each configuration, which takes 32 ms.

use super::description::{Chip, Identity, Thermometer, Write};
use ironout_sensor::{AxisMap, Reading, Sensor};

/// All addresses, by the level of its pin.
pub const ADDRESSES: [u8; 2] = [0x14, 0x15];
/// Who it is.
pub const CHIP_ID: u8 = 0x00;
/// What [`CHIP_ID`] reads.
pub const IDENTITY: u8 = 0x33;
/// Averaging (bits 5–4), rate (3–0).
pub const AGGREGATION: u8 = 0x04;
/// Which axes are measured.
pub const AXES: u8 = 0x05;
/// Commands of power.
pub const COMMAND: u8 = 0x06;
/// What the commands came to: the last one (bits 7–5), not possible (4), "normal" mode (3), busy (0).
pub const COMMAND_STATUS: u8 = 0x07;
/// Data-ready flag on (bit 7).
pub const INTERRUPTS: u8 = 0x2e;
/// Bit 2: a set of data waits.
pub const STATUS: u8 = 0x30;
/// The first of the twelve output bytes.
pub const DATA_X: u8 = 0x31;
/// The middle byte of the temperature.
pub const TEMPERATURE: u8 = 0x3b;
/// Reads a word of the OTP memory.
pub const OTP_COMMAND: u8 = 0x50;
/// High byte of the word.
pub const OTP_HIGH: u8 = 0x52;
/// Low byte of the word.
pub const OTP_LOW: u8 = 0x53;
/// Word read (bit 0), error (7–5).
pub const OTP_STATUS: u8 = 0x55;
/// Reset.
pub const RESET: u8 = 0x7e;

/// [`RESET`]: now.
pub const RESET_NOW: u8 = 0xb6;
/// After it, ms.
pub const RESET_MS: u32 = 24;
/// [`OTP_COMMAND`]: read the word of these low bits.
pub const OTP_READ: u8 = 0x20;
/// [`OTP_COMMAND`]: the memory's power off.
pub const OTP_OFF: u8 = 0x80;
/// [`OTP_STATUS`]: the word is read.
pub const OTP_DONE: u8 = 1 << 0;
/// [`OTP_STATUS`]: it could not be read.
pub const OTP_ERROR: u8 = 0xe0;
/// [`COMMAND`]: "normal" mode, measurements at the rate.
pub const NORMAL: u8 = 1;
/// From suspended to the first measurement, ms.
pub const NORMAL_MS: u32 = 38;
/// [`COMMAND`]: take over rate and averaging.
pub const UPDATE: u8 = 2;
/// How long it takes, ms.
pub const UPDATE_MS: u32 = 1;
/// [`COMMAND`]: flux-guide reset.
pub const FLUX_GUIDE_RESET: u8 = 5;
/// How long it takes, ms.
pub const FLUX_GUIDE_RESET_MS: u32 = 18;
/// [`COMMAND`]: bit reset.
pub const BIT_RESET: u8 = 7;
/// How long it takes, ms.
pub const BIT_RESET_MS: u32 = 14;
/// [`COMMAND_STATUS`]: the last command cannot be done in this mode.
pub const ILLEGAL: u8 = 1 << 4;
/// [`COMMAND_STATUS`]: in "normal" mode.
pub const IS_NORMAL: u8 = 1 << 3;
/// [`STATUS`]: a set of data waits.
pub const DRDY: u8 = 1 << 2;
/// The first word of the OTP memory that the compensation uses.
pub const FIRST_WORD: u8 = 0x0d;
/// The word of the temperature at which the compensation is none.
pub const REFERENCE_WORD: u8 = 0x18;

/// µT a count before compensation, x, y and z.
const UT_PER_COUNT: [f32; 3] = [0.007_069_979, 0.007_069_979, 0.007_174_964];
/// °C a count of the temperature.
const CELSIUS_PER_COUNT: f32 = 0.000_981_282;
/// °C where the temperature reads 0.
const CELSIUS_AT_ZERO: f32 = -25.49;
/// The specified range, µT.
const RANGE_UT: f32 = 2000.0;
/// Counts that are delivered per µT.
const CARRIED_PER_UT: f32 = 16.0;

/// Measurements a second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum DataRate {
    Hz400,
    Hz200,
    #[default]
    Hz100,
    Hz50,
    Hz25,
}

impl DataRate {
    /// The rate bits of [`AGGREGATION`].
    pub const fn bits(self) -> u8 {
        self as u8 + 2
    }

    /// Measurements a second.
    pub const fn hz(self) -> f32 {
        match self {
            DataRate::Hz400 => 400.0,
            DataRate::Hz200 => 200.0,
            DataRate::Hz100 => 100.0,
            DataRate::Hz50 => 50.0,
            DataRate::Hz25 => 25.0,
        }
    }

    /// The most averaging that the rate leaves time for.
    pub const fn most(self) -> Averaging {
        match self {
            DataRate::Hz400 => Averaging::None,
            DataRate::Hz200 => Averaging::Of2,
            DataRate::Hz100 => Averaging::Of4,
            DataRate::Hz50 | DataRate::Hz25 => Averaging::Of8,
        }
    }
}

/// How many measurements of the chip are one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Averaging {
    None,
    /// 0.19 µT of noise on x and y, 0.45 µT on z.
    #[default]
    Of2,
    Of4,
    Of8,
}

/// The whole configuration. The default: address 0x14, 100 Hz, averages of two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// One of [`ADDRESSES`].
    pub address: u8,
    /// Measurements a second.
    pub rate: DataRate,
    /// How many measurements of the chip are one.
    pub averaging: Averaging,
}

impl Default for Config {
    fn default() -> Self {
        Self { address: ADDRESSES[0], rate: DataRate::default(), averaging: Averaging::default() }
    }
}

/// What one chip holds in its OTP memory, in the units of the memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Otp {
    /// Offset of x, y, z, µT.
    pub offset: [i16; 3],
    /// Sensitivity of x, y, z, in 1/256.
    pub sensitivity: [i8; 3],
    /// Coefficient of temperature of the offset, in 1/32 µT/°C.
    pub offset_drift: [i8; 3],
    /// Coefficient of temperature of the sensitivity, in 1/16384 per °C.
    pub sensitivity_drift: [i8; 3],
    /// How much y is in x, x in y, x in z and y in z, in 1/800.
    pub cross: [i8; 4],
    /// Offset of the temperature, in 1/5 °C.
    pub celsius_offset: i8,
    /// Sensitivity of the temperature, in 1/512.
    pub celsius_sensitivity: i8,
    /// The temperature at which the compensation is none, in 1/512 °C from 23 °C.
    pub reference: i16,
}

/// The low 12 bits of a word as a signed number.
const fn signed_12(word: u16) -> i16 {
    ((word << 4) as i16) >> 4
}

impl Otp {
    /// From words 0x0d to 0x16, and word 0x18.
    pub const fn of(words: [u16; 10], reference: u16) -> Self {
        let [celsius, x, xy, z_x, yz, tx, ty, tz, flat, up] = words;
        let [celsius_offset, celsius_sensitivity] = celsius.to_le_bytes();
        let [_, sensitivity_x] = z_x.to_le_bytes();
        let [sensitivity_y, sensitivity_z] = yz.to_le_bytes();
        let [[ox, sx], [oy, sy], [oz, sz]] = [tx.to_le_bytes(), ty.to_le_bytes(), tz.to_le_bytes()];
        let [[y_in_x, x_in_y], [x_in_z, y_in_z]] = [flat.to_le_bytes(), up.to_le_bytes()];
        Self {
            offset: [
                signed_12(x),
                signed_12(((x & 0xf000) >> 4) | (xy & 0x00ff)),
                signed_12((xy & 0x0f00) | (z_x & 0x00ff)),
            ],
            sensitivity: [sensitivity_x as i8, sensitivity_y as i8, sensitivity_z as i8],
            offset_drift: [ox as i8, oy as i8, oz as i8],
            sensitivity_drift: [sx as i8, sy as i8, sz as i8],
            cross: [y_in_x as i8, x_in_y as i8, x_in_z as i8, y_in_z as i8],
            celsius_offset: celsius_offset as i8,
            celsius_sensitivity: celsius_sensitivity as i8,
            reference: reference as i16,
        }
    }

    /// °C from the temperature's count.
    pub fn celsius(&self, count: i32) -> f32 {
        let uncompensated = count as f32 * CELSIUS_PER_COUNT + CELSIUS_AT_ZERO;
        (1.0 + f32::from(self.celsius_sensitivity) / 512.0) * uncompensated
            + f32::from(self.celsius_offset) / 5.0
    }

    /// The compensated field of these counts at this temperature, µT.
    pub fn compensate(&self, counts: [i32; 3], celsius: f32) -> [f32; 3] {
        // Bosch's correction of what soldering does to every chip: sensitivity of y, and the coefficient of that of z.
        let soldered = [(0.0, 0.0), (0.01, 0.0), (0.0, -0.0001)];
        let warmer = celsius - (f32::from(self.reference) / 512.0 + 23.0);
        let mut field = [0.0; 3];
        let scales = self.sensitivity.into_iter().zip(self.sensitivity_drift).zip(soldered);
        let offsets = self.offset.into_iter().zip(self.offset_drift);
        let raws = counts.into_iter().zip(UT_PER_COUNT);
        for (((ut, ((scale, drift), (more, bent))), (offset, offset_drift)), (count, per_count)) in
            field.iter_mut().zip(scales).zip(offsets).zip(raws)
        {
            let scale = 1.0 + f32::from(scale) / 256.0 + more;
            let drift = f32::from(drift) / 16_384.0 + bent;
            let offset = f32::from(offset) + f32::from(offset_drift) / 32.0 * warmer;
            *ut = (count as f32 * per_count * scale + offset) / (1.0 + drift * warmer);
        }
        let [x, y, z] = field;
        let [y_in_x, x_in_y, x_in_z, y_in_z] = self.cross.map(|part| f32::from(part) / 800.0);
        let flat = 1.0 - x_in_y * y_in_x;
        let (true_x, true_y) = ((x - y_in_x * y) / flat, (y - x_in_y * x) / flat);
        [true_x, true_y, z - x_in_z * true_x - y_in_z * true_y]
    }
}

/// A configuration with the OTP memory of the chip at hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Trimmed {
    /// What was asked for.
    pub config: Config,
    /// What the chip holds.
    pub otp: Otp,
}

/// Counts, three bytes each, low byte first.
fn count(low: u8, middle: u8, high: u8) -> i32 {
    // Into the high bytes of a word and down again: the sign comes along.
    i32::from_le_bytes([0, low, middle, high]) >> 8
}

impl Chip for Trimmed {
    const IDENTITY: Identity = Identity { register: CHIP_ID, bytes: &[IDENTITY] };
    const STATUS: (u8, u8) = (STATUS, DRDY);
    const OUTPUT: u8 = DATA_X;
    const DUMMIES: u8 = 2;
    const DROPPED: u8 = 1;
    type Output = [u8; 12];
    type Writes = [Write; 3];

    fn address(&self) -> u8 {
        self.config.address
    }

    fn check(&self) -> Result<(), &'static str> {
        if self.config.averaging > self.config.rate.most() {
            return Err("BMM350: averaging takes longer than the rate leaves: fewer, or a lower rate");
        }
        Ok(())
    }

    fn writes(&self) -> [Write; 3] {
        [
            Write::kept(AGGREGATION, (self.config.averaging as u8) << 4 | self.config.rate.bits()),
            Write::kept(AXES, 7),
            Write::kept(INTERRUPTS, 1 << 7),
        ]
    }

    fn sensor(&self) -> Sensor {
        Sensor {
            name: "BMM350",
            ut_per_count: [1.0 / CARRIED_PER_UT; 3],
            axes: AxisMap::IDENTITY,
            rate_hz: self.config.rate.hz(),
            full_scale_counts: (RANGE_UT * CARRIED_PER_UT) as u16,
            bits: 21,
            shift: 0,
        }
    }

    fn decode(&self, &[x0, x1, x2, y0, y1, y2, z0, z1, z2, t0, t1, t2]: &[u8; 12]) -> Reading {
        let celsius = self.otp.celsius(count(t0, t1, t2));
        let counts = [count(x0, x1, x2), count(y0, y1, y2), count(z0, z1, z2)];
        let field = self.otp.compensate(counts, celsius);
        // A memory of nonsense gives infinities and no numbers: those are out of range too.
        let beyond = field.map(|ut| !((-RANGE_UT..=RANGE_UT).contains(&ut)));
        let carried = field.map(|ut| {
            let scaled = ut * CARRIED_PER_UT;
            // `as` saturates, and cuts off: half a count away from zero is rounding.
            (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i32
        });
        Reading::carried(carried, 0, beyond)
    }

    fn thermometer(&self) -> Thermometer {
        Thermometer::Burst(TEMPERATURE)
    }

    fn celsius(&self, [middle, high]: [u8; 2]) -> f32 {
        self.otp.celsius(count(0, middle, high))
    }
}
