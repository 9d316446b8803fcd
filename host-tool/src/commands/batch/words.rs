//! The summary in words.

use ironout_analysis::fleet::Fleet;
use ironout_analysis::fleet::history::History;
use jiff::Timestamp;

/// Lines of a list that are printed; the JSON object has all.
const SHOWN: usize = 10;

/// Headings, the same on the page.
pub(super) const EFFECTS: &str = "Effects found";
pub(super) const APART: &str = "Vehicles that differ from the fleet";

/// A verdict as people read it; tables keep the value of the JSON object.
pub(super) fn verdict(value: &str) -> String {
    match value {
        "missing" => "missing: effect found".into(),
        other => other.into(),
    }
}

/// How many logs of how many vehicles.
pub(super) fn title(fleet: &Fleet) -> String {
    let vehicles = match fleet.vehicles {
        0 => "unknown vehicles (--vehicle-from names them)".to_string(),
        n => plural(n, "vehicle"),
    };
    format!("{} of {vehicles}", plural(fleet.logs, "log"))
}

/// The summary as text.
pub(super) fn text(fleet: &Fleet) -> String {
    let mut out = format!("{}\n\nVerdicts\n", title(fleet));
    for count in &fleet.verdicts {
        let verdict = verdict(&count.what);
        out += &format!("  {verdict:<21} {:>6}  {:>5.1} %\n", count.logs, share(count.logs, fleet.logs));
    }
    out += &format!("\n{EFFECTS}\n");
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
    out += &format!("\n{APART}\n");
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
            "{}: {} in {} of {}, in {} of {} of the other vehicles ({})",
            one.vehicle,
            one.effect,
            one.logs_with,
            plural(one.logs, "log"),
            one.others_with,
            plural(one.others, "log"),
            p_value(one.p_value)
        )
    });
    let figures = fleet.figures_apart.iter().map(|one| {
        let (name, unit) = one.figure.split_once(", ").unwrap_or((one.figure, ""));
        format!(
            "{}: {name} {:.2} {unit}; median of the fleet {:.2} {unit} ({:+.0} robust σ)",
            one.vehicle, one.median, one.fleet_median, one.deviations
        )
    });
    let several = fleet
        .several_sensors
        .iter()
        .map(|one| format!("{}: several sensors: {}", one.vehicle, one.sensors.join(", then ")));
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
        // As many decimals as give the smallest error two digits.
        let least = drift.std_ut_per_day.into_iter().filter(|std| *std > 0.0).fold(f64::INFINITY, f64::min);
        let decimals =
            if least.is_finite() { (1.0 - least.log10().floor()).clamp(3.0, 6.0) as usize } else { 3 };
        let axis =
            |i: usize| format!("{:+.decimals$} ±{:.decimals$}", drift.ut_per_day[i], drift.std_ut_per_day[i]);
        return format!(
            "{name}: drifts by {}, {}, {} µT per day (x, y, z; ±1σ), {:.1} µT in {:.0} days ({}, {})",
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
        format!("and gains by {a:+.1}, {b:+.1}, {c:+.1} %: probably another sensor or mounting")
    } else {
        "with the same gains: probably a magnet, a new part or a moved cable".to_string()
    };
    let day = Timestamp::from_second((change.from_day * 86_400.0) as i64)
        .map_or(String::new(), |day| day.strftime(" on %Y-%m-%d").to_string());
    format!(
        "{name}: offset changed by {x:+.2}, {y:+.2}, {z:+.2} µT (x, y, z){day} {cause} (first log {}, {})",
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
    if value < 1e-99 { "p < 1e-99".into() } else { format!("p = {value:.0e}") }
}
