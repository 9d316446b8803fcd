//! The summary in words.

use ironout_analysis::fleet::Fleet;
use ironout_analysis::fleet::history::History;
use jiff::Timestamp;

/// Lines of a list that are printed; the JSON object has all.
const SHOWN: usize = 10;

/// The summary as text.
pub(super) fn text(fleet: &Fleet) -> String {
    let mut out = format!(
        "{} of {}\n\nVerdicts\n",
        plural(fleet.logs, "log"),
        match fleet.vehicles {
            0 => "unknown vehicles (--vehicle-from names them)".to_string(),
            n => plural(n, "vehicle"),
        }
    );
    for count in &fleet.verdicts {
        out += &format!("  {:<13} {:>6}  {:>5.1} %\n", count.what, count.logs, share(count.logs, fleet.logs));
    }
    out += "\nMissing effects\n";
    if fleet.effects.is_empty() {
        out += "  none\n";
    }
    for count in fleet.effects.iter().take(SHOWN) {
        let vehicles = if count.vehicles > 0 {
            format!(", {}", plural(count.vehicles, "vehicle"))
        } else {
            String::new()
        };
        out += &format!(
            "  {:<28} {:>6}  ({:.1} %{vehicles})\n",
            count.what,
            plural(count.logs, "log"),
            share(count.logs, fleet.logs)
        );
    }
    out += &rest(fleet.effects.len());
    out += "\nVehicles apart from the fleet\n";
    let apart = apart(fleet);
    if apart.is_empty() {
        out += "  none\n";
    }
    apart.iter().take(2 * SHOWN).for_each(|line| out += &format!("  {line}\n"));
    if apart.len() > 2 * SHOWN {
        out += &format!("  … and {} more (--json lists all)\n", apart.len() - 2 * SHOWN);
    }
    out += "\nOffset over time\n";
    let (moved, still): (Vec<&History>, Vec<&History>) =
        fleet.sensors.iter().partition(|one| one.drift.is_some() || one.change.is_some());
    moved.iter().for_each(|one| out += &format!("  {}\n", history(one)));
    let tested = still.iter().filter(|one| one.logs >= 4).count();
    out += &format!("  {} without a significant change", plural(tested, "sensor"));
    let few = still.len() - tested;
    if few > 0 {
        out += &format!("; {} with too few logs", plural(few, "sensor"));
    }
    out + "\n"
}

/// Vehicles apart from the fleet, a line each.
pub(super) fn apart(fleet: &Fleet) -> Vec<String> {
    let effects = fleet.effects_apart.iter().map(|one| {
        format!(
            "{}: {} in {} of {}, in {} of {} of the others (p = {})",
            one.vehicle,
            one.effect,
            one.logs_with,
            plural(one.logs, "log"),
            one.others_with,
            one.others,
            p_value(one.p_value)
        )
    });
    let figures = fleet.figures_apart.iter().map(|one| {
        format!(
            "{}: {} {:.2}, the fleet {:.2} ({:+.0} robust σ)",
            one.vehicle, one.figure, one.median, one.fleet_median, one.deviations
        )
    });
    let several = fleet.several_sensors.iter().map(|one| {
        format!("{}: its logs name several sensors: {}", one.vehicle, one.sensors.join(", then "))
    });
    effects.chain(figures).chain(several).collect()
}

/// The offset of a sensor over time in one line.
pub(super) fn history(one: &History) -> String {
    let name = match (one.vehicle.is_empty(), one.sensor.is_empty()) {
        (false, false) => format!("{}, {}", one.vehicle, one.sensor),
        (true, _) => one.sensor.clone(),
        (_, true) => one.vehicle.clone(),
    };
    if let Some(drift) = &one.drift {
        let axis = |i: usize| format!("{:+.3} ±{:.3}", drift.ut_per_day[i], drift.std_ut_per_day[i]);
        return format!(
            "{name}: drifts by {}, {}, {} µT per day, {:.1} µT in {:.0} days ({}, p = {})",
            axis(0),
            axis(1),
            axis(2),
            drift.moved_ut,
            one.days,
            plural(one.logs, "log"),
            p_value(drift.p_value)
        );
    }
    let Some(change) = &one.change else { return name };
    let [x, y, z] = change.offset_shift_ut;
    let cause = if change.gains_changed {
        let [a, b, c] = change.gain_shift.map(|gain| 100.0 * gain);
        format!("and gains by {a:+.1}, {b:+.1}, {c:+.1} %: another sensor or mounting")
    } else {
        "with the same gains: a magnet, a new part or a moved cable".to_string()
    };
    let day = Timestamp::from_second((change.from_day * 86_400.0) as i64)
        .map_or(String::new(), |day| day.strftime(" on %Y-%m-%d").to_string());
    format!(
        "{name}: offset changed by {x:+.2}, {y:+.2}, {z:+.2} µT{day} {cause} (from {}, p = {})",
        change.from_log,
        p_value(change.p_value)
    )
}

fn rest(there: usize) -> String {
    match there.saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!("  … and {more} more (--json lists all)\n"),
    }
}

/// Per cent.
pub(super) fn share(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

/// A count with its noun.
pub(super) fn plural(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

fn p_value(value: f64) -> String {
    if value < 1e-99 { "0".into() } else { format!("{value:.0e}") }
}
