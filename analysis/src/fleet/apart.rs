//! Vehicles that differ from the rest of their fleet.

use crate::fleet::entry::FleetLog;
use crate::samples::series::median;
use serde::Serialize;
use std::collections::BTreeMap;

/// Probability of a false alarm in a whole summary, for each kind of test.
pub const MAX_P_VALUE: f64 = 1e-3;
/// Vehicles whose figures say what is usual.
const MIN_VEHICLES: usize = 5;
/// Robust standard deviations by which a vehicle's median stands apart …
const MIN_DEVIATIONS: f64 = 6.0;
/// … of at least this share of the fleet's median: a fleet of equal sensors has nearly no spread.
const MIN_SPREAD_SHARE: f64 = 0.05;
/// Standard deviation of a normal distribution over its median absolute deviation.
const SIGMA_OVER_MAD: f64 = 1.4826;
/// One log with an effect is not a habit of a vehicle.
const MIN_LOGS_WITH_EFFECT: usize = 2;

/// An effect that one vehicle shows more often than the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectApart {
    /// The vehicle.
    pub vehicle: String,
    /// Id of the effect.
    pub effect: String,
    /// Logs of the vehicle with the effect.
    pub logs_with: usize,
    /// Logs of the vehicle that were studied.
    pub logs: usize,
    /// Logs of the other vehicles with the effect.
    pub others_with: usize,
    /// Logs of the other vehicles.
    pub others: usize,
    /// Probability of as many by chance, all vehicles and effects counted.
    pub p_value: f64,
}

/// A figure in which one vehicle differs from the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FigureApart {
    /// The vehicle.
    pub vehicle: String,
    /// Name of the figure with its unit.
    pub figure: &'static str,
    /// Its median over the logs of the vehicle.
    pub median: f64,
    /// Median of the vehicles' medians.
    pub fleet_median: f64,
    /// Distance in robust standard deviations of the fleet.
    pub deviations: f64,
}

/// Effects that single vehicles show more often than the others (hypergeometric test, Bonferroni). An effect that several vehicles
/// have is named for each of them where the others still have it less.
pub fn by_effects(logs: &[&FleetLog]) -> Vec<EffectApart> {
    let vehicles = by_vehicle(logs);
    let mut effects: Vec<&str> = logs.iter().flat_map(|log| log.effects.iter().map(String::as_str)).collect();
    effects.sort_unstable();
    effects.dedup();
    let tests = (vehicles.len() * effects.len()) as f64;
    let mut found = Vec::new();
    if vehicles.len() < 2 {
        return found;
    }
    for effect in effects {
        let has = |log: &&&FleetLog| log.effects.iter().any(|one| one == effect);
        let all_with = logs.iter().filter(has).count();
        for (vehicle, own) in &vehicles {
            let with = own.iter().filter(has).count();
            let (others, others_with) = (logs.len() - own.len(), all_with - with);
            if with < MIN_LOGS_WITH_EFFECT || with * others <= others_with * own.len() {
                continue;
            }
            let p_value = (tests * hypergeometric_tail(with, own.len(), all_with, logs.len())).min(1.0);
            if p_value < MAX_P_VALUE {
                found.push(EffectApart {
                    vehicle: (*vehicle).to_string(),
                    effect: effect.to_string(),
                    logs_with: with,
                    logs: own.len(),
                    others_with,
                    others,
                    p_value,
                });
            }
        }
    }
    found.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    found
}

/// A figure of a log, with its name.
type Figure = (&'static str, fn(&FleetLog) -> Option<f64>);

/// Vehicles whose median noise or error lies far from the fleet's.
pub fn by_figures(logs: &[&FleetLog]) -> Vec<FigureApart> {
    let figures: [Figure; 2] = [
        ("error of the base model, % of the field", |log| log.error_share.map(|share| 100.0 * share)),
        ("noise of the sensor, µT", |log| log.noise_ut),
    ];
    let vehicles = by_vehicle(logs);
    let mut found = Vec::new();
    for (figure, value) in figures {
        let mut medians: Vec<(&str, f64)> = Vec::new();
        for (vehicle, own) in &vehicles {
            let mut values: Vec<f64> = own.iter().filter_map(|log| value(log)).collect();
            if !values.is_empty() {
                medians.push((vehicle, median(&mut values)));
            }
        }
        if medians.len() < MIN_VEHICLES {
            continue;
        }
        let centre = median(&mut medians.iter().map(|(_, value)| *value).collect::<Vec<_>>());
        let mut distances: Vec<f64> = medians.iter().map(|(_, value)| (value - centre).abs()).collect();
        let spread = (SIGMA_OVER_MAD * median(&mut distances)).max(MIN_SPREAD_SHARE * centre.abs());
        for (vehicle, value) in medians {
            let deviations = (value - centre) / spread;
            if deviations.abs() > MIN_DEVIATIONS {
                let vehicle = vehicle.to_string();
                found.push(FigureApart { vehicle, figure, median: value, fleet_median: centre, deviations });
            }
        }
    }
    found
}

fn by_vehicle<'a>(logs: &[&'a FleetLog]) -> BTreeMap<&'a str, Vec<&'a FleetLog>> {
    let mut vehicles: BTreeMap<&str, Vec<&FleetLog>> = BTreeMap::new();
    for log in logs.iter().filter(|log| !log.vehicle.is_empty()) {
        vehicles.entry(&log.vehicle).or_default().push(log);
    }
    vehicles
}

/// Probability of at least `hits` marked ones among `draws` of `all`, of which `marked` are.
fn hypergeometric_tail(hits: usize, draws: usize, marked: usize, all: usize) -> f64 {
    let most = draws.min(marked);
    let ln_all = ln_choose(all, draws);
    (hits..=most)
        .filter(|hit| draws - hit <= all - marked)
        .map(|hit| libm::exp(ln_choose(marked, hit) + ln_choose(all - marked, draws - hit) - ln_all))
        .sum::<f64>()
        .min(1.0)
}

fn ln_choose(n: usize, k: usize) -> f64 {
    let ln_factorial = |n: usize| libm::lgamma(n as f64 + 1.0);
    ln_factorial(n) - ln_factorial(k) - ln_factorial(n - k)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(vehicle: &str, effects: &[&str], noise_ut: f64) -> FleetLog {
        FleetLog {
            vehicle: vehicle.into(),
            effects: effects.iter().map(ToString::to_string).collect(),
            noise_ut: Some(noise_ut),
            ..FleetLog::default()
        }
    }

    #[test]
    fn the_tail_is_that_of_the_distribution() {
        // Three red of five drawn from ten with four red: (4·15 + 6) … by counting: C(4,3)C(6,2) + C(4,4)C(6,1) over C(10,5).
        assert!((hypergeometric_tail(3, 5, 4, 10) - 66.0 / 252.0).abs() < 1e-12);
        assert!((hypergeometric_tail(0, 5, 4, 10) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_habit_of_one_vehicle_is_named_and_a_chance_is_not() {
        let mut logs = Vec::new();
        for vehicle in 0..20 {
            for flight in 0..10 {
                let name = format!("v{vehicle:02}");
                let own = vehicle == 7 && flight < 9;
                // Every vehicle has the lag in one log of ten.
                let effects: &[&str] = if own {
                    &["offset:current_a"]
                } else if flight == 9 {
                    &["lag"]
                } else {
                    &[]
                };
                logs.push(log(
                    &name,
                    effects,
                    if vehicle == 3 { 0.9 } else { 0.25 + 0.01 * f64::from(flight) },
                ));
            }
        }
        let logs: Vec<&FleetLog> = logs.iter().collect();
        let found = by_effects(&logs);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((found[0].vehicle.as_str(), found[0].logs_with, found[0].others_with), ("v07", 9, 0));
        let figures = by_figures(&logs);
        assert_eq!(figures.len(), 1, "{figures:?}");
        assert_eq!(figures[0].vehicle, "v03");
    }
}
