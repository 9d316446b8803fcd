//! From messages of ArduPilot, however they were written, to streams and parameters.

use crate::input::formats::dataflash::definition::Definition;
use crate::input::formats::dataflash::units::{Units, Written};
use crate::input::formats::dataflash::wanted::{Message, wanted};
use crate::input::formats::inventory::Inventory;
use crate::input::formats::parameters::Parameters;
use crate::input::formats::stream::Stream;
use std::collections::BTreeMap;

/// More sensors of one kind than any vehicle has.
const MOST_INSTANCES: u8 = 64;

/// What is read of one kind of message, and where it stands there.
#[derive(Debug, Clone)]
pub enum Plan {
    /// A parameter: fields of time, name and value.
    Parameter(Option<usize>, usize, usize),
    /// A line of text: its field.
    Words(usize),
    /// Units of the fields of a message: fields of number, units, multipliers.
    FieldUnits(usize, usize, usize),
    /// What a letter of a multiplier stands for: fields of letter and value.
    Multiplier(usize, usize),
    /// What a letter of a unit stands for: fields of letter and label.
    UnitLabel(usize, usize),
    /// Samples.
    Samples(Samples),
}

/// Samples of a sensor.
#[derive(Debug, Clone)]
pub struct Samples {
    /// The message without the number at its end.
    base: String,
    place: u8,
    all: bool,
    time: usize,
    time_scale: f64,
    /// The field that numbers the sensor from 0, or the number at the end of the message's name.
    instance: Result<usize, u8>,
    fields: Vec<Written>,
}

impl Plan {
    /// For a message as it is defined; `None` where it is not read.
    pub fn of(definition: &Definition) -> Option<Self> {
        let label = |names: &[&str]| names.iter().find_map(|name| definition.label(name));
        let micros = label(&["TimeUS"]).map(|field| (field, 1e-6));
        let time = micros.or(label(&["TimeMS", "T"]).map(|field| (field, 1e-3)));
        match definition.name.as_str() {
            "PARM" => {
                let (name, value) = (label(&["Name"])?, label(&["Value"])?);
                return Some(Plan::Parameter(micros.map(|(field, _)| field), name, value));
            }
            "FMTU" => {
                return Some(Plan::FieldUnits(
                    label(&["FmtType"])?,
                    label(&["UnitIds"])?,
                    label(&["MultIds"])?,
                ));
            }
            "MULT" => return Some(Plan::Multiplier(label(&["Id"])?, label(&["Mult"])?)),
            "UNIT" => return Some(Plan::UnitLabel(label(&["Id"])?, label(&["Label"])?)),
            "MSG" => return Some(Plan::Words(label(&["Message", "Msg"])?)),
            _ => {}
        }
        let base = definition.name.trim_end_matches(|c: char| c.is_ascii_digit());
        let Message { fields, place, all } = wanted(base)?;
        let number: u8 = definition.name.get(base.len()..).and_then(|rest| rest.parse().ok()).unwrap_or(1);
        // A filter numbers its cores.
        let numbers: &[&str] = if base.ends_with("KQ") { &["C"] } else { &["I", "Inst", "Instance"] };
        let instance = label(numbers).ok_or(number.saturating_sub(1));
        let (time, time_scale) = time?;
        let mut found: Vec<Written> = Vec::new();
        for field in fields {
            if let Some(at) = definition.label(field.label)
                && at != time
                && !found.iter().any(|known| known.field.name == field.name)
            {
                let letter = definition.letter(at).unwrap_or(0);
                let (kind, field) = (definition.kind, field.clone());
                found.push(Written { kind, at, letter, field, printed: 0, pointed: false });
            }
        }
        (!found.is_empty()).then(|| {
            Plan::Samples(Samples {
                base: base.into(),
                place,
                all,
                time,
                time_scale,
                instance,
                fields: found,
            })
        })
    }
}

/// All that was collected.
#[derive(Debug, Default)]
pub struct Collected {
    /// By place of the message and instance.
    pub streams: BTreeMap<(u8, u8), Stream>,
    /// How the columns of each stream were written, and the units that the log states.
    written: BTreeMap<(u8, u8), Vec<Written>>,
    units: Units,
    /// Whether the log is text.
    printed: bool,
    /// The parameters.
    pub parameters: Parameters,
    /// The first words of the log that name a vehicle and its version.
    pub firmware: Option<String>,
    /// Messages by name.
    pub inventory: Inventory,
    row: Vec<f64>,
}

impl Collected {
    /// Of a log that is text.
    pub fn printed() -> Self {
        Collected { printed: true, ..Collected::default() }
    }

    /// Takes one message whose fields `number` and `text` give.
    pub fn take(&mut self, plan: &Plan, number: impl Fn(usize) -> f64, text: impl Fn(usize) -> String) {
        match plan {
            Plan::Parameter(time, name, value) => {
                let time = time.map_or(f64::NEG_INFINITY, |time| number(time) * 1e-6);
                let value = number(*value);
                if value.is_finite() {
                    self.parameters.set(&text(*name), time, value);
                }
            }
            Plan::Words(field) => {
                if self.firmware.is_none() {
                    let words = text(*field);
                    // "ArduCopter V4.5.7 (2a3dc4b7)"
                    let version = words.split_whitespace().nth(1).is_some_and(|word| word.starts_with('V'));
                    self.firmware =
                        version.then(|| words.chars().filter(|c| !c.is_control()).take(40).collect());
                }
            }
            Plan::FieldUnits(kind, units, multipliers) => {
                self.units.of_fields(number(*kind) as u8, &text(*units), &text(*multipliers));
            }
            Plan::Multiplier(letter, value) => self.units.multiplier(number(*letter) as u8, number(*value)),
            Plan::UnitLabel(letter, label) => self.units.label(number(*letter) as u8, text(*label)),
            Plan::Samples(samples) => self.sample(samples, number, text),
        }
    }

    fn sample(&mut self, samples: &Samples, number: impl Fn(usize) -> f64, text: impl Fn(usize) -> String) {
        let instance = match samples.instance {
            Ok(field) => number(field) as u8,
            Err(number) => number,
        };
        if instance >= MOST_INSTANCES || (instance > 0 && !samples.all) {
            return;
        }
        self.row.clear();
        self.row.extend(samples.fields.iter().map(|written| number(written.at)));
        let time_s = number(samples.time) * samples.time_scale;
        let key = (samples.place, instance);
        let stream =
            self.streams.entry(key).or_insert_with(|| empty(&samples.base, instance, &samples.fields));
        stream.push(time_s, &self.row);
        let written = self.written.entry(key).or_insert_with(|| samples.fields.clone());
        for one in written.iter_mut().filter(|one| self.printed && one.by_letter() && !one.pointed) {
            one.printed += 1;
            one.pointed = text(one.at).contains('.');
        }
    }

    /// Brings every column to the log's unit: units may be stated behind the first messages.
    pub fn scaled(&mut self) {
        for (key, stream) in &mut self.streams {
            let Some(written) = self.written.get(key) else { continue };
            for (column, written) in stream.columns.iter_mut().zip(written) {
                let finite = column.values.iter().filter(|value| value.is_finite());
                let most = finite.fold(0.0_f64, |most, value| most.max(value.abs()));
                column.scale = written.scale(&self.units, most);
                column.values.iter_mut().for_each(|value| *value *= column.scale);
            }
            stream.attitude_of_angles();
        }
    }
}

fn empty(base: &str, instance: u8, fields: &[Written]) -> Stream {
    let number = u16::from(instance) + 1;
    let name = format!("{base}[{instance}]");
    fields.iter().map(|written| &written.field).fold(Stream::new(name.as_str()), |stream, field| {
        let column = if field.name.contains("_#") {
            field.name.replace('#', &number.to_string())
        } else if instance == 0 {
            field.name.replace('#', "")
        } else {
            field.name.replace('#', &format!("_{number}"))
        };
        stream.with(&column, &format!("{name}.{}", field.label), field.unit, field.between)
    })
}
