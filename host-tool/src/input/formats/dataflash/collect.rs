//! From messages of ArduPilot, however they were written, to streams and parameters.

use crate::input::formats::dataflash::definition::Definition;
use crate::input::formats::dataflash::wanted::{Field, Message, wanted};
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
    fields: Vec<(usize, Field)>,
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
            "MSG" => return Some(Plan::Words(label(&["Message", "Msg"])?)),
            _ => {}
        }
        let base = definition.name.trim_end_matches(|c: char| c.is_ascii_digit());
        let Message { fields, place, all } = wanted(base)?;
        let number: u8 = definition.name.get(base.len()..).and_then(|rest| rest.parse().ok()).unwrap_or(1);
        let instance = label(&["I", "Inst", "Instance"]).ok_or(number.saturating_sub(1));
        let (time, time_scale) = time?;
        let mut found: Vec<(usize, Field)> = Vec::new();
        for field in fields {
            if let Some(at) = definition.label(field.label)
                && at != time
                && !found.iter().any(|(_, known)| known.name == field.name)
            {
                found.push((at, field.clone()));
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
    /// The parameters.
    pub parameters: Parameters,
    /// The first words of the log that name a vehicle and its version.
    pub firmware: Option<String>,
    /// Messages by name.
    pub inventory: Inventory,
    row: Vec<f64>,
}

impl Collected {
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
            Plan::Samples(samples) => self.sample(samples, number),
        }
    }

    fn sample(&mut self, samples: &Samples, number: impl Fn(usize) -> f64) {
        let instance = match samples.instance {
            Ok(field) => number(field) as u8,
            Err(number) => number,
        };
        if instance >= MOST_INSTANCES || (instance > 0 && !samples.all) {
            return;
        }
        self.row.clear();
        self.row.extend(samples.fields.iter().map(|(at, field)| number(*at) * field.scale));
        let time_s = number(samples.time) * samples.time_scale;
        let stream = self
            .streams
            .entry((samples.place, instance))
            .or_insert_with(|| empty(&samples.base, instance, &samples.fields));
        stream.push(time_s, &self.row);
    }
}

fn empty(base: &str, instance: u8, fields: &[(usize, Field)]) -> Stream {
    let number = u16::from(instance) + 1;
    let name = format!("{base}[{instance}]");
    fields.iter().fold(Stream::new(name.as_str()), |stream, (_, field)| {
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
