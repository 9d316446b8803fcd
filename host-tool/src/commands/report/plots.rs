//! The plots of a look, each as a file.

use crate::chart::{BLUE, Chart, GREEN, GREY, ORANGE, Series};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().into_iter().flatten().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
}

fn pairs(x: &[f64], y: &[f64]) -> Vec<[f64; 2]> {
    x.iter().zip(y).map(|(x, y)| [*x, *y]).collect()
}

fn line(label: &str, x: &[f64], y: &[f64], colour: &'static str) -> Series {
    Series { label: label.into(), points: pairs(x, y), colour, dots: false, dashed: false }
}

/// Least and greatest of each piece, one after the other: a line that fills the band.
fn band(label: &str, at: &[f64], band: &Value, add: f64, colour: &'static str) -> Series {
    let (low, high) = (numbers(&band["low"]), numbers(&band["high"]));
    let points =
        at.iter().zip(low.iter().zip(&high)).flat_map(|(x, (low, high))| [[*x, low + add], [*x, high + add]]);
    Series { label: label.into(), points: points.collect(), colour, dots: false, dashed: false }
}

fn chart(title: &str, x: &str, y: &str, series: Vec<Series>) -> Chart {
    Chart { title: title.into(), x: x.into(), y: y.into(), log: false, square: false, series }
}

/// Letters and digits of a column's name.
fn file_name(name: &str) -> String {
    let safe: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).take(40).collect();
    safe.trim_matches('-').to_string()
}

/// Each plot: the name of its file, and its text.
pub fn plots(look: &Value) -> Vec<(String, String)> {
    let picture = &look["picture"];
    let field = picture["field_ut"].as_f64().unwrap_or(0.0);
    let effects = look.pointer("/fit/effects").and_then(Value::as_array).is_some_and(|all| !all.is_empty());
    let floor = look.pointer("/figures/floor_ut").and_then(Value::as_f64);
    let base = "offset and matrix only";
    let whole = if effects { "with the effects" } else { "offset and matrix" };
    let mut charts: Vec<(String, Chart)> = Vec::new();
    let time = &picture["timeline"];
    let at = numbers(&time["at_s"]);
    if !at.is_empty() {
        let magnitude = vec![
            band("measured", &at, &time["measured_ut"], 0.0, ORANGE),
            band("corrected", &at, &time["residual_ut"], field, BLUE),
        ];
        charts.push(("magnitude".into(), chart("Magnitude", "time, s", "µT", magnitude)));
        let mut residual = Vec::new();
        if effects {
            residual.push(band(base, &at, &time["without_ut"], 0.0, ORANGE));
        }
        residual.push(band(whole, &at, &time["residual_ut"], 0.0, BLUE));
        charts.push(("error".into(), chart("Error of the corrected magnitude", "time, s", "µT", residual)));
        for (key, name, title) in [
            ("dip_deg", "dip", "Dip of the corrected field"),
            ("heading_error_deg", "heading", "Heading minus its reference"),
        ] {
            if time[key].is_object() {
                let series = vec![band("", &at, &time[key], 0.0, GREEN)];
                charts.push((name.into(), chart(title, "time, s", "°", series)));
            }
        }
    }
    for bins in picture["against"].as_array().into_iter().flatten() {
        let name = bins["name"].as_str().unwrap_or_default();
        let at = numbers(&bins["at"]);
        let dots = |series: Series| Series { dots: true, ..series };
        let mut series = vec![dots(line(base, &at, &numbers(&bins["without_ut"]), ORANGE))];
        if effects {
            series.push(line("with the effects", &at, &numbers(&bins["effect_ut"]), GREY));
            series.push(dots(line(whole, &at, &numbers(&bins["rms_ut"]), BLUE)));
        }
        if let Some(floor) = floor {
            let noise = line("noise alone", &at, &vec![floor; at.len()], GREY);
            series.push(Series { dashed: true, ..noise });
        }
        let place = charts.len();
        let title = format!("Error against {name}");
        charts.push((
            format!("against-{place:02}-{}", file_name(name)),
            chart(&title, name, "rms, µT", series),
        ));
    }
    let spectrum = &picture["spectrum"];
    let hz = numbers(&spectrum["hz"]);
    if !hz.is_empty() {
        let mut series = vec![line(base, &hz, &numbers(&spectrum["without"]), ORANGE)];
        if effects {
            series.push(line(whole, &hz, &numbers(&spectrum["with"]), BLUE));
        }
        if let Some(noise) = spectrum["noise"].as_f64() {
            series.push(Series { dashed: true, ..line("noise alone", &hz, &vec![noise; hz.len()], GREY) });
        }
        let spectrum = chart("Spectrum of the error", "Hz", "µT/√Hz", series);
        charts.push(("spectrum".into(), Chart { log: true, ..spectrum }));
    }
    let bars = &picture["histogram"];
    let at = numbers(&bars["at_ut"]);
    if !at.is_empty() {
        let mut series = vec![line(base, &at, &numbers(&bars["without"]), ORANGE)];
        if effects {
            series.push(line(whole, &at, &numbers(&bars["with"]), BLUE));
        }
        let noise = numbers(&bars["noise"]);
        if !noise.is_empty() {
            series.push(Series { dashed: true, ..line("noise alone", &at, &noise, GREY) });
        }
        charts.push(("histogram".into(), chart("Size of the error", "µT", "share", series)));
    }
    let cloud = |key: &str, axis: usize| numbers(&picture["cloud"][key][axis]);
    for (name, first, second) in [("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2)] {
        let dots = |label: &str, key: &str, colour: &'static str| Series {
            dots: true,
            ..line(label, &cloud(key, first), &cloud(key, second), colour)
        };
        let series = vec![dots("measured", "measured_ut", ORANGE), dots("corrected", "corrected_ut", BLUE)];
        let [x, y] = [first, second].map(|axis| format!("{}, µT", ["x", "y", "z"][axis]));
        let sphere = chart(&format!("The sphere, {name}"), &x, &y, series);
        charts.push((format!("sphere-{name}"), Chart { square: true, ..sphere }));
    }
    let drawn = charts.into_iter().filter_map(|(name, chart)| Some((format!("{name}.svg"), chart.svg()?)));
    drawn.collect()
}
