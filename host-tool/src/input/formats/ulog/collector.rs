//! From the messages of one topic to a stream.

use crate::input::formats::feed::u64_at;
use crate::input::formats::stream::{Between, Stream};
use crate::input::formats::ulog::layout::{Field, Kind, Layout};

/// More changes of the device than any flight has.
const MOST_CHANGES: usize = 10_000;

/// One field that is wanted of a topic.
#[derive(Debug, Clone)]
pub struct Want {
    /// Its path in the message.
    pub path: String,
    /// The column's name in the log.
    pub name: String,
    /// Its unit in the file.
    pub unit: &'static str,
    /// From there to the log's unit.
    pub scale: f64,
    /// A value that stands for none.
    pub none: Option<f64>,
    /// A field in µs that it is divided by: sums over an interval.
    pub over_us: Option<&'static str>,
    /// How it is read between two samples.
    pub between: Between,
}

/// One field that is read.
#[derive(Debug, Clone)]
struct Reading {
    field: Field,
    scale: f64,
    none: Option<f64>,
    over_us: Option<Field>,
}

/// Collects one instance of a topic.
#[derive(Debug, Clone)]
pub struct Collector {
    /// The topic.
    pub topic: String,
    /// The instance.
    pub instance: u8,
    /// What was collected.
    pub stream: Stream,
    /// The device that the samples are of, where the messages name it; 0 where they do not.
    pub device_id: u32,
    /// Rows from which on the samples are of another device.
    devices: Vec<(usize, u32)>,
    /// Whether the messages say that the sensor is external.
    pub external: Option<bool>,
    /// Whether the messages carry counts next to the values: then the driver had corrected the values already.
    pub with_counts: bool,
    readings: Vec<Reading>,
    time: usize,
    time_sample: Option<usize>,
    device: Option<Field>,
    is_external: Option<Field>,
    /// A message shorter than this is broken.
    least_bytes: usize,
    row: Vec<f64>,
}

impl Collector {
    /// For a topic of this layout; `None` where it has no time or none of what is wanted.
    pub fn new(topic: &str, instance: u8, layout: &Layout, wants: &[Want]) -> Option<Self> {
        let micros = |path: &str| layout.field(path).filter(|f| f.kind == Kind::U64).map(|f| f.at);
        let time = micros("timestamp")?;
        let mut stream = Stream::new(format!("{topic}[{instance}]"));
        let mut readings = Vec::new();
        for want in wants {
            let Some(field) = layout.field(&want.path) else { continue };
            let over_us = match want.over_us {
                Some(path) => match layout.field(path) {
                    Some(field) => Some(field),
                    None => continue,
                },
                None => None,
            };
            if stream.column(&want.name).is_some() {
                continue;
            }
            let source = format!("{}.{}", stream.name, want.path);
            stream = stream.scaled(&want.name, &source, want.unit, want.scale.abs(), want.between);
            readings.push(Reading { field, scale: want.scale, none: want.none, over_us });
        }
        (!readings.is_empty()).then(|| Collector {
            topic: topic.to_string(),
            instance,
            row: vec![0.0; readings.len()],
            least_bytes: readings.iter().map(|reading| reading.field.end()).max().unwrap_or(0),
            readings,
            stream,
            device_id: 0,
            devices: Vec::new(),
            external: None,
            with_counts: layout.field("x_raw").is_some(),
            time,
            time_sample: micros("timestamp_sample"),
            device: layout.field("device_id"),
            is_external: layout.field("is_external"),
        })
    }

    /// The same, apart by device: PX4 goes on in one topic with another sensor where the first fails.
    pub fn by_device(self) -> Vec<Self> {
        let mut ids: Vec<u32> = self.devices.iter().map(|(_, id)| *id).collect();
        ids.sort_unstable();
        ids.dedup();
        if ids.len() < 2 {
            return vec![self];
        }
        let of_row = |row: usize| {
            let change = self.devices.iter().rev().find(|(from, _)| *from <= row);
            change.or(self.devices.first()).map_or(0, |(_, id)| *id)
        };
        let of_rows: Vec<u32> = (0..self.stream.time_s.len()).map(of_row).collect();
        ids.iter()
            .map(|id| {
                let mut one = self.clone();
                let keep = |values: &mut Vec<f64>| {
                    let mut rows = of_rows.iter();
                    values.retain(|_| rows.next() == Some(id));
                };
                keep(&mut one.stream.time_s);
                one.stream.columns.iter_mut().for_each(|column| keep(&mut column.values));
                (one.device_id, one.devices) = (*id, vec![(0, *id)]);
                one
            })
            .collect()
    }

    /// Takes one message; `start_us` is the beginning of the log. Gives its time.
    pub fn push(&mut self, data: &[u8], start_us: u64) -> Option<f64> {
        if data.len() < self.least_bytes {
            return None;
        }
        let stamp = u64_at(data, self.time)?;
        let sampled = self.time_sample.and_then(|at| u64_at(data, at)).filter(|time| *time > 0);
        let seconds = |time: u64| time.wrapping_sub(start_us).cast_signed() as f64 / 1e6;
        if let Some(device) = self.device.map(|field| field.value(data) as u32).filter(|id| *id != 0)
            && self.devices.last().is_none_or(|(_, last)| *last != device)
            && self.devices.len() < MOST_CHANGES
        {
            self.devices.push((self.stream.time_s.len(), device));
            if self.device_id == 0 {
                self.device_id = device;
            }
        }
        if self.external.is_none() {
            self.external = self.is_external.map(|field| field.value(data) > 0.0);
        }
        for (value, reading) in self.row.iter_mut().zip(&self.readings) {
            *value = reading.field.value(data);
            if Some(*value) == reading.none {
                *value = f64::NAN;
            }
            *value *= reading.scale;
            if let Some(over) = reading.over_us {
                *value /= over.value(data) / 1e6;
            }
        }
        self.stream.push(seconds(sampled.unwrap_or(stamp)), &self.row);
        Some(seconds(stamp))
    }
}
