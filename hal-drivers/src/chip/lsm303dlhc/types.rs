//! How the chip can be configured, with the figures that belong to each choice.

/// Measuring range (register CRB; sensitivities of datasheet table 75).
///
/// Hard iron adds to the Earth's field of 0.25–0.65 G, and an axis out of range gives no data: take the finest
/// range that holds both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Range {
    /// ±1.3 G (130 µT), the chip's default.
    #[default]
    Gauss1_3,
    /// ±1.9 G (190 µT).
    Gauss1_9,
    /// ±2.5 G (250 µT).
    Gauss2_5,
    /// ±4.0 G (400 µT).
    Gauss4_0,
    /// ±4.7 G (470 µT).
    Gauss4_7,
    /// ±5.6 G (560 µT).
    Gauss5_6,
    /// ±8.1 G (810 µT).
    Gauss8_1,
}

impl Range {
    /// All ranges, the finest first.
    pub const ALL: [Range; 7] = [
        Range::Gauss1_3,
        Range::Gauss1_9,
        Range::Gauss2_5,
        Range::Gauss4_0,
        Range::Gauss4_7,
        Range::Gauss5_6,
        Range::Gauss8_1,
    ];

    /// The byte for register CRB.
    pub const fn crb(self) -> u8 {
        let gn: u8 = match self {
            Range::Gauss1_3 => 1,
            Range::Gauss1_9 => 2,
            Range::Gauss2_5 => 3,
            Range::Gauss4_0 => 4,
            Range::Gauss4_7 => 5,
            Range::Gauss5_6 => 6,
            Range::Gauss8_1 => 7,
        };
        gn << 5
    }

    /// Counts per gauss of x and y, and of z.
    pub const fn counts_per_gauss(self) -> (u16, u16) {
        match self {
            Range::Gauss1_3 => (1100, 980),
            Range::Gauss1_9 => (855, 760),
            Range::Gauss2_5 => (670, 600),
            Range::Gauss4_0 => (450, 400),
            Range::Gauss4_7 => (400, 355),
            Range::Gauss5_6 => (330, 295),
            Range::Gauss8_1 => (230, 205),
        }
    }

    /// µT per count of x, y, z (1 G = 100 µT).
    pub fn ut_per_count(self) -> [f32; 3] {
        let (xy, z) = self.counts_per_gauss();
        let (xy, z) = (100.0 / f32::from(xy), 100.0 / f32::from(z));
        [xy, xy, z]
    }
}

/// Output data rate (register CRA, datasheet table 72).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DataRate {
    /// 0.75 Hz.
    Hz0_75,
    /// 1.5 Hz.
    Hz1_5,
    /// 3 Hz.
    Hz3,
    /// 7.5 Hz.
    Hz7_5,
    /// 15 Hz.
    Hz15,
    /// 30 Hz.
    Hz30,
    /// 75 Hz: the first above the 50 samples a second that the firmware takes.
    #[default]
    Hz75,
    /// 220 Hz.
    Hz220,
}

impl DataRate {
    /// The data-rate bits of register CRA.
    pub const fn cra_bits(self) -> u8 {
        let d_o: u8 = match self {
            DataRate::Hz0_75 => 0,
            DataRate::Hz1_5 => 1,
            DataRate::Hz3 => 2,
            DataRate::Hz7_5 => 3,
            DataRate::Hz15 => 4,
            DataRate::Hz30 => 5,
            DataRate::Hz75 => 6,
            DataRate::Hz220 => 7,
        };
        d_o << 2
    }

    /// Measurements a second.
    pub const fn hz(self) -> f32 {
        match self {
            DataRate::Hz0_75 => 0.75,
            DataRate::Hz1_5 => 1.5,
            DataRate::Hz3 => 3.0,
            DataRate::Hz7_5 => 7.5,
            DataRate::Hz15 => 15.0,
            DataRate::Hz30 => 30.0,
            DataRate::Hz75 => 75.0,
            DataRate::Hz220 => 220.0,
        }
    }
}

/// Where the 12 bits of the temperature (8 counts per °C) stand in its two registers.
///
/// The chip and the emulated chip of QEMU disagree, and reading one as the other is wrong by a factor of 16
/// without any error: hence an explicit choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TemperatureFormat {
    /// Left-justified, the low four bits empty: the real chip (datasheet table 88).
    #[default]
    LeftJustified,
    /// Right-justified and sign-extended: QEMU's `lsm303dlhc_mag`.
    RightJustified,
}

impl TemperatureFormat {
    /// °C from the two register bytes, high byte first.
    ///
    /// The datasheet gives the slope only: the zero is uncalibrated and differs from chip to chip by several
    /// degrees. For temperature *effects* only differences count.
    pub fn celsius(self, bytes: [u8; 2]) -> f32 {
        let raw = i16::from_be_bytes(bytes);
        let counts = match self {
            TemperatureFormat::LeftJustified => raw >> 4,
            TemperatureFormat::RightJustified => raw,
        };
        f32::from(counts) / 8.0
    }
}

/// The whole configuration of the magnetic half.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Measuring range.
    pub range: Range,
    /// Measurements a second.
    pub rate: DataRate,
    /// Whether the temperature sensor runs.
    pub temperature: bool,
    /// How the temperature registers are read.
    pub temperature_format: TemperatureFormat,
}

impl Default for Config {
    /// ±1.3 G, 75 Hz, temperature on, the real chip's temperature format.
    fn default() -> Self {
        Self {
            range: Range::default(),
            rate: DataRate::default(),
            temperature: true,
            temperature_format: TemperatureFormat::default(),
        }
    }
}

impl Config {
    /// The byte for register CRA.
    pub const fn cra(&self) -> u8 {
        let temperature = if self.temperature { super::register::CRA_TEMP_EN } else { 0 };
        temperature | self.rate.cra_bits()
    }
}
