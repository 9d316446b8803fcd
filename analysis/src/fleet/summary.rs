//! The summary of a fleet.

use crate::fleet::apart::{EffectApart, FigureApart, by_effects, by_figures};
use crate::fleet::entry::FleetLog;
use crate::fleet::history::{History, history};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// How often something was said.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Count {
    /// A verdict, or the id of an effect.
    pub what: String,
    /// Logs of which it was said.
    pub logs: usize,
    /// Vehicles of which it was said.
    pub vehicles: usize,
}

/// A vehicle whose logs name several sensors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorsOfVehicle {
    /// The vehicle.
    pub vehicle: String,
    /// Its sensors, in the order of their first logs.
    pub sensors: Vec<String>,
}

/// The summary of a fleet.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fleet {
    /// Logs in all.
    pub logs: usize,
    /// Vehicles in all.
    pub vehicles: usize,
    /// Logs by verdict, the commonest first.
    pub verdicts: Vec<Count>,
    /// Named effects, the commonest first.
    pub effects: Vec<Count>,
    /// Effects that single vehicles show more often than the others.
    pub effects_apart: Vec<EffectApart>,
    /// Figures in which single vehicles differ from the others.
    pub figures_apart: Vec<FigureApart>,
    /// Vehicles whose logs name several sensors.
    pub several_sensors: Vec<SensorsOfVehicle>,
    /// The offset of each sensor over its logs.
    pub sensors: Vec<History>,
}

/// Summarizes the logs of a fleet.
pub fn summarize(logs: &[FleetLog]) -> Fleet {
    let studied: Vec<&FleetLog> = logs.iter().filter(|log| log.verdict != ERROR).collect();
    let mut series: BTreeMap<(&str, &str), Vec<&FleetLog>> = BTreeMap::new();
    for log in studied.iter().filter(|log| !log.vehicle.is_empty() || !log.sensor.is_empty()) {
        series.entry((&log.vehicle, &log.sensor)).or_default().push(log);
    }
    let sensors: Vec<History> = series.values().filter_map(|logs| history(logs, series.len())).collect();
    let vehicles: BTreeSet<&str> =
        logs.iter().map(|log| log.vehicle.as_str()).filter(|name| !name.is_empty()).collect();
    Fleet {
        logs: logs.len(),
        vehicles: vehicles.len(),
        verdicts: counts(logs.iter().map(|log| (log.verdict.as_str(), log.vehicle.as_str()))),
        effects: counts(studied.iter().flat_map(|log| {
            let effects: BTreeSet<&str> = log.effects.iter().map(String::as_str).collect();
            effects.into_iter().map(|effect| (effect, log.vehicle.as_str()))
        })),
        effects_apart: by_effects(&studied),
        figures_apart: by_figures(&studied),
        several_sensors: several_sensors(&studied),
        sensors,
    }
}

/// The verdict of a log that could not be studied.
pub const ERROR: &str = "error";

fn counts<'a>(said: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<Count> {
    let mut all: BTreeMap<&str, (usize, BTreeSet<&str>)> = BTreeMap::new();
    for (what, vehicle) in said {
        let entry = all.entry(what).or_default();
        entry.0 += 1;
        if !vehicle.is_empty() {
            entry.1.insert(vehicle);
        }
    }
    let mut counts: Vec<Count> = all
        .into_iter()
        .map(|(what, (logs, vehicles))| Count { what: what.to_string(), logs, vehicles: vehicles.len() })
        .collect();
    counts.sort_by(|a, b| b.logs.cmp(&a.logs).then_with(|| a.what.cmp(&b.what)));
    counts
}

fn several_sensors(logs: &[&FleetLog]) -> Vec<SensorsOfVehicle> {
    let mut in_turn: Vec<&&FleetLog> =
        logs.iter().filter(|log| !log.vehicle.is_empty() && !log.sensor.is_empty()).collect();
    in_turn.sort_by(|a, b| {
        let day = |log: &FleetLog| log.day.unwrap_or(f64::INFINITY);
        day(a).total_cmp(&day(b)).then_with(|| a.name.cmp(&b.name))
    });
    let mut vehicles: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for log in in_turn {
        let sensors = vehicles.entry(&log.vehicle).or_default();
        if !sensors.contains(&log.sensor) {
            sensors.push(log.sensor.clone());
        }
    }
    let several = vehicles.into_iter().filter(|(_, sensors)| sensors.len() > 1);
    several.map(|(vehicle, sensors)| SensorsOfVehicle { vehicle: vehicle.to_string(), sensors }).collect()
}
