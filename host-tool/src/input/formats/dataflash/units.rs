//! From the number in a field to the log's unit.
//!
//! The letters `c`, `C`, `e`, `E` of a format stand for hundredths and `L` for ten-millionths; the messages FMTU, UNIT and MULT of
//! newer logs say the unit of each field and its multiplier, which for these letters is the letter's own. Before ArduPilot 3.3
//! CURR held hundredths of a volt and of an ampere in plain integers.

use crate::input::formats::dataflash::wanted::Field;
use crate::input::unit::{Quantity, Unit};
use std::collections::HashMap;

/// Numbers printed without a point are hundredths only beyond this: a column of whole degrees stays below.
const MIN_PRINTED_HUNDREDTHS: f64 = 200.0;
/// Fewest printed numbers that tell.
const MIN_PRINTED: u64 = 5;

/// Units and multipliers that a log states.
#[derive(Debug, Clone, Default)]
pub struct Units {
    /// By the number of the message: a unit and a multiplier a field, by their letters.
    fields: HashMap<u8, (Vec<u8>, Vec<u8>)>,
    multipliers: HashMap<u8, f64>,
    labels: HashMap<u8, String>,
}

impl Units {
    /// `FMTU`.
    pub fn of_fields(&mut self, kind: u8, units: &str, multipliers: &str) {
        self.fields.insert(kind, (units.bytes().collect(), multipliers.bytes().collect()));
    }

    /// `MULT`.
    pub fn multiplier(&mut self, letter: u8, value: f64) {
        self.multipliers.insert(letter, value);
    }

    /// `UNIT`.
    pub fn label(&mut self, letter: u8, label: String) {
        self.labels.insert(letter, label);
    }

    /// Unit and multiplier of a field; `None` where the log does not state both.
    fn stated(&self, kind: u8, field: usize, quantity: Quantity) -> Option<(Unit, f64)> {
        let (units, multipliers) = self.fields.get(&kind)?;
        let (unit, multiplier) = (*units.get(field)?, *multipliers.get(field)?);
        let label = self.labels.get(&unit)?;
        let unit = Unit::of(label, quantity)?;
        // `-` and `?` stand for what is not known.
        let known = !matches!(multiplier, b'-' | b'?');
        let value = self.multipliers.get(&multiplier).copied().filter(|_| known)?;
        (value.is_finite() && value > 0.0).then_some((unit, value))
    }
}

/// How one column of a stream was written.
#[derive(Debug, Clone)]
pub struct Written {
    /// Number of the message, place of the field in it.
    pub kind: u8,
    /// The place.
    pub at: usize,
    /// Letter of its format.
    pub letter: u8,
    /// What the field is.
    pub field: Field,
    /// Numbers that were printed, and whether one of them had a point.
    pub printed: u64,
    /// Whether one of them had a point.
    pub pointed: bool,
}

impl Written {
    /// Whether the letter scales the number.
    pub fn by_letter(&self) -> bool {
        matches!(self.letter, b'c' | b'C' | b'e' | b'E')
    }

    /// What the numbers are multiplied with; `most` is the greatest magnitude among them.
    pub fn scale(&self, units: &Units, most: f64) -> f64 {
        // Text is printed as scaled by its letter. A program that prints it unscaled prints no point.
        let unscaled = self.by_letter()
            && self.printed >= MIN_PRINTED
            && !self.pointed
            && most >= MIN_PRINTED_HUNDREDTHS;
        let letter = if unscaled { 0.01 } else { 1.0 };
        let own = match self.letter {
            b'h' | b'H' | b'i' | b'I'
                if matches!(quantity(&self.field), Some(Quantity::Current | Quantity::Voltage)) =>
            {
                0.01
            }
            _ => self.field.scale,
        };
        let stated = quantity(&self.field).and_then(|quantity| units.stated(self.kind, self.at, quantity));
        match stated {
            Some((unit, _)) if self.by_letter() => unit.factor() * letter,
            Some((unit, multiplier)) => unit.factor() * multiplier,
            None => own * letter,
        }
    }
}

/// What a field is of, by the name of its column.
fn quantity(field: &Field) -> Option<Quantity> {
    let name = field.name;
    let starts = |heads: &[&str]| heads.iter().any(|head| name.starts_with(head));
    match name.rsplit('_').next() {
        _ if starts(&["offset_", "motor_"]) => Some(Quantity::Field),
        Some("ut") => Some(Quantity::Field),
        Some("mps2") => Some(Quantity::Acceleration),
        Some("radps") => Some(Quantity::Rate),
        Some("a") => Some(Quantity::Current),
        Some("v") => Some(Quantity::Voltage),
        Some("c") => Some(Quantity::Temperature),
        _ => None,
    }
}
