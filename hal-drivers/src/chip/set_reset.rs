//! Chips whose SET and RESET turn the sensing direction around, which separates their own offset from the field. No bus.
//!
//! The driver measures after SET, after RESET and after SET again, and takes a quarter of first, twice the second and third for the
//! chip's offset: a field that turns evenly meanwhile cancels too. It does so at each configuration and every so many measurements,
//! because the offset moves with temperature.

use super::description::{Identity, Write};
use ironout_sensor::{Reading, Sensor};

/// [`SetReset::CONTROL`]: measure the field.
pub const TM_M: u8 = 1 << 0;
/// [`SetReset::CONTROL`]: measure the temperature.
pub const TM_T: u8 = 1 << 1;
/// [`SetReset::CONTROL`]: SET.
pub const SET: u8 = 1 << 3;
/// [`SetReset::CONTROL`]: RESET.
pub const RESET: u8 = 1 << 4;

/// A chip of MEMSIC's as configured: its register map, for [`Memsic`](crate::Memsic).
pub trait SetReset {
    /// Who it is.
    const IDENTITY: Identity;
    /// The only address.
    const ADDRESS: u8;
    /// The register that says what is measured.
    const STATUS: u8;
    /// In [`SetReset::STATUS`]: the field is measured.
    const FIELD_DONE: u8;
    /// In [`SetReset::STATUS`]: the temperature is measured.
    const TEMPERATURE_DONE: u8;
    /// The register that takes [`TM_M`], [`TM_T`], [`SET`] and [`RESET`].
    const CONTROL: u8;
    /// From SET or RESET to the next command, ms.
    const PULSE_MS: u32;
    /// The first of the output registers.
    const OUTPUT: u8;
    /// The register of the temperature.
    const TEMPERATURE: u8;
    /// Ends continuous measurements.
    const STOP: Write;
    /// Counts per gauss.
    const COUNTS_PER_GAUSS: f32;
    /// The output registers of one measurement, for one transaction.
    type Output: AsMut<[u8]> + Default;
    /// The configuration: an array.
    type Writes: AsRef<[Write]>;
    /// What starts continuous measurements: an array.
    type Start: AsRef<[Write]>;

    /// Whether the chip can be configured like this; the text says what it cannot do.
    ///
    /// # Errors
    /// What is wrong, and what to choose.
    fn check(&self) -> Result<(), &'static str>;
    /// The configuration. None of these registers can be read back.
    fn writes(&self) -> Self::Writes;
    /// What starts continuous measurements.
    fn start(&self) -> Self::Start;
    /// The chip as an application sees it, its axes taken for the board's.
    fn sensor(&self) -> Sensor;
    /// A measurement as the chip has it.
    fn raw(&self, output: &Self::Output) -> Raw;
    /// Measurements after which offset and temperature are measured anew; 0 for only at each configuration.
    fn refresh_every(&self) -> u16;

    /// A measurement less the chip's offset.
    fn reading(&self, raw: Raw, [ox, oy, oz]: [i32; 3]) -> Reading {
        let [x, y, z] = raw.counts;
        Reading::carried([x - ox, y - oy, z - oz], self.sensor().shift, raw.clipped)
    }
}

/// A measurement as the chip has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Raw {
    /// Counts from that of no field.
    pub counts: [i32; 3],
    /// Which of them are out of range.
    pub clipped: [bool; 3],
}

/// The chip's offset from measurements after SET, RESET and SET. An axis that was out of range keeps the `last` one.
pub fn bridge_offset(set: Raw, reset: Raw, again: Raw, last: [i32; 3]) -> [i32; 3] {
    let mut offset = last;
    let raws = set.counts.into_iter().zip(reset.counts).zip(again.counts);
    let clips = set.clipped.into_iter().zip(reset.clipped).zip(again.clipped);
    for ((offset, ((set, reset), again)), ((a, b), c)) in offset.iter_mut().zip(raws).zip(clips) {
        if !(a || b || c) {
            *offset = (set + 2 * reset + again) >> 2;
        }
    }
    offset
}

/// °C from the temperature's byte.
pub fn celsius(byte: u8) -> f32 {
    f32::from(byte) * 0.8 - 75.0
}
