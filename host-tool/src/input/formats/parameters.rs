//! The parameters of an autopilot, as its log tells them, with their changes.

use std::collections::HashMap;

/// More changes than any flight has: beyond it a log is broken, and its parameters are not kept.
const MOST: usize = 200_000;

/// Values by name and time.
#[derive(Debug, Clone, Default)]
pub struct Parameters {
    values: HashMap<String, Vec<(f64, f64)>>,
    kept: usize,
}

impl Parameters {
    /// `name` is `value` from `time_s` on (−∞: from the beginning).
    pub fn set(&mut self, name: &str, time_s: f64, value: f64) {
        if self.kept >= MOST {
            return;
        }
        let values = match self.values.get_mut(name) {
            Some(values) => values,
            None => self.values.entry(name.to_string()).or_default(),
        };
        if values.last().is_none_or(|(_, last)| *last != value) {
            values.push((time_s, value));
            self.kept += 1;
        }
    }

    /// The value at a time: of the first known, if it is told later only.
    pub fn at(&self, name: &str, time_s: f64) -> Option<f64> {
        let values = self.values.get(name)?;
        let known = values.iter().rev().find(|(since, _)| *since <= time_s).or(values.first());
        known.map(|(_, value)| *value)
    }

    /// Whether it has this value at any time.
    pub fn is_ever(&self, name: &str, matches: impl Fn(f64) -> bool) -> bool {
        self.values.get(name).is_some_and(|values| values.iter().any(|(_, value)| matches(*value)))
    }

    /// The value it begins with.
    pub fn first(&self, name: &str) -> Option<f64> {
        self.values.get(name)?.first().map(|(_, value)| *value)
    }

    /// When parameters whose names pass `which` change, in order.
    pub fn changes(&self, which: impl Fn(&str) -> bool) -> Vec<f64> {
        let mut times: Vec<f64> = self
            .values
            .iter()
            .filter(|(name, _)| which(name))
            .flat_map(|(_, values)| values.iter().skip(1).map(|(time, _)| *time))
            .filter(|time| time.is_finite())
            .collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// Three parameters at a time; those not told are `unset`.
    pub fn three(&self, names: [String; 3], time_s: f64, unset: f64) -> [f64; 3] {
        names.map(|name| self.at(&name, time_s).unwrap_or(unset))
    }
}
