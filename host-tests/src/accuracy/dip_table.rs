//! What only the dip sees: misalignment, swapped axes and pure delays in simulated logs whose truth is known.

use crate::accuracy::simulated::table_of;
use ironout_analysis::outcome::outcome::Status;
use ironout_analysis::{Options, diagnose};
use ironout_simulation::{EffectSpec, GRAVITY_MPS2, Log, World, WorldOptions};
use serde_json::{Value, json};

/// The rows: hidden effects, as `simulate --effect` takes them.
pub const CASES: [&str; 7] =
    ["", "misalignment=6", "axis-order", "lag=15ms", "lag=20ms", "lag=300ms", "misalignment=6,lag=20ms"];

/// What became of the logs of one kind.
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// Logs.
    pub logs: u32,
    /// Exactly what was hidden is stated, swapped axes with their order.
    pub named: u32,
    /// Spread of the dip before and after, degrees rms over the logs.
    pub dip_deg: [f64; 2],
    /// Spread after over what the sensors' noise makes of it: the largest.
    pub worst_over_floor: f64,
    /// Error of the delay, share of the delay: the largest.
    pub worst_delay: f64,
    /// Heading's error before and after, degrees rms over the logs.
    pub heading_deg: [f64; 2],
}

/// Spread of the dip that the noise of magnetometer and accelerometer alone makes, degrees: each has one direction in
/// the plane of field and gravity.
pub fn floor_deg(log: &Log, options: &WorldOptions) -> f64 {
    let magnetometer = log.truth.noise_ut / options.field_ut;
    let accelerometer = options.accel_noise_mps2 / GRAVITY_MPS2;
    magnetometer.hypot(accelerometer).to_degrees()
}

/// Runs `seeds` logs of one kind.
pub fn run(hidden: &str, seeds: u64) -> Row {
    let mut row = Row::default();
    let mut sums = [0.0; 4];
    for seed in 0..seeds {
        let items = hidden.split(',').filter(|item| !item.is_empty());
        let effects = items.filter_map(|item| EffectSpec::parse(item).ok()).collect();
        let options = WorldOptions { seed, effects, ..WorldOptions::default() };
        let log = World::new(options.clone()).run();
        let searched = Options { search: true, ..Options::default() };
        let Ok(found) = diagnose(&table_of(&log), &searched) else { continue };
        row.logs += 1;
        let steps: Vec<&str> = found.steps.iter().filter_map(|step| step.added.as_deref()).collect();
        let misaligned =
            found.candidates.iter().any(|one| one.id == "misalignment" && one.status == Status::Missing);
        let swapped = hidden.contains("axis-order");
        let wanted: Vec<&str> = [("lag", "lag"), ("axis-order", "axis-order")]
            .into_iter()
            .filter(|(word, _)| hidden.contains(word))
            .map(|(_, id)| id)
            .collect();
        let right = steps == wanted
            && (misaligned || !hidden.contains("misalignment"))
            && found.axis_order().map(|order| order.to_string()).as_deref() == swapped.then_some("y,x,z");
        row.named += u32::from(right);
        if let Some(dip) = found.dip {
            sums[0] += dip.rms_deg_before.powi(2);
            sums[1] += dip.rms_deg_after.powi(2);
            row.worst_over_floor = row.worst_over_floor.max(dip.rms_deg_after / floor_deg(&log, &options));
        }
        if let Some(heading) = found.heading {
            sums[2] += heading.rms_deg_before.powi(2);
            sums[3] += heading.rms_deg_after.powi(2);
        }
        for truth in log.truth.effects.iter().filter(|effect| effect.kind.id() == "lag") {
            let delay =
                found.effects.iter().find(|effect| effect.id == "lag").map_or(0.0, |lag| lag.coefficients[0]);
            row.worst_delay = row.worst_delay.max((delay / truth.coefficients()[0] - 1.0).abs());
        }
    }
    let [a, b, c, d] = sums.map(|sum| (sum / f64::from(row.logs.max(1))).sqrt());
    (row.dip_deg, row.heading_deg) = ([a, b], [c, d]);
    row
}

/// The heading of [`line()`].
pub const HEADING: &str = "seen by the dip alone      right  dip before  after  after/noise's  delay's error  heading before  after";

/// One line of the table.
pub fn line(hidden: &str, row: &Row) -> String {
    let delay = match hidden.contains("lag") {
        true => format!("{:.1} %", 100.0 * row.worst_delay),
        false => "-".into(),
    };
    format!(
        "{hidden:<25} {:>5.0}%  {:>9.2}°  {:>4.2}°  {:>13.2}  {delay:>13}  {:>13.1}°  {:>4.1}°",
        100.0 * f64::from(row.named) / f64::from(row.logs.max(1)),
        row.dip_deg[0],
        row.dip_deg[1],
        row.worst_over_floor,
        row.heading_deg[0],
        row.heading_deg[1],
    )
}

/// One row as an object.
pub fn json(hidden: &str, row: &Row) -> Value {
    json!({
        "hidden": hidden, "logs": row.logs, "right": row.named,
        "dip_deg_before": row.dip_deg[0], "dip_deg_after": row.dip_deg[1],
        "worst_dip_over_floor": row.worst_over_floor, "worst_delay_error": row.worst_delay,
        "heading_deg_before": row.heading_deg[0], "heading_deg_after": row.heading_deg[1],
    })
}
