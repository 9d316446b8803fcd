//! Steps that lie close together, and a tone under stamps that come in bursts.

use crate::common::{folder, ironout, simulate, text, write};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// The log with `change` added to its field by the time, of its rows that `keep` holds.
fn changed(
    here: &Path,
    name: &str,
    log: &Path,
    keep: impl Fn(usize) -> bool,
    change: impl Fn(f64) -> [f64; 3],
) -> PathBuf {
    let content = std::fs::read_to_string(log).expect("text");
    let mut rows = content.lines().filter(|line| !line.starts_with('#'));
    let header = rows.next().expect("a header");
    let column = |name: &str| header.split(',').position(|own| own == name).expect("the column");
    let (time, field) = (column("t_s"), ["mx_ut", "my_ut", "mz_ut"].map(column));
    let rows = rows.enumerate().filter(|(place, _)| keep(*place)).map(|(_, row)| {
        let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
        let more = change(cells[time].parse().expect("a time"));
        for (place, more) in field.into_iter().zip(more) {
            cells[place] = format!("{:.4}", cells[place].parse::<f64>().expect("a field") + more);
        }
        cells.join(",")
    });
    let rows: Vec<String> = rows.collect();
    write(here, name, format!("{header}\n{}\n", rows.join("\n")))
}

/// The effects that a diagnosis names, in the order in which it adds them.
fn named(log: &Path) -> Vec<String> {
    let study = ironout(["diagnose", text(log), "--json"]).json();
    let steps = study["steps"].as_array().expect("steps");
    steps.iter().filter_map(|step| step["added"].as_str()).map(str::to_owned).collect()
}

#[test]
fn two_steps_in_one_tenth_of_the_log_are_both_found() {
    let here = folder("close_steps");
    let log = simulate(&here, "bare.csv", &["--seed", "7", "--seconds", "200"]);
    let size = |from: f64, t: f64| f64::from(u8::from(t >= from));
    // From 82 s to 94 s: within the fifth block of twenty seconds.
    let change = |t: f64| [2.0 * size(82.0, t), 2.5 * size(94.0, t), 1.0 * size(94.0, t)];
    let log = changed(&here, "steps.csv", &log, |_| true, change);
    assert_eq!(named(&log), ["step", "step#2"]);
}

#[test]
fn a_tone_that_goes_by_stamps_in_bursts_is_found_and_applied() {
    let here = folder("burst_tone");
    let log = simulate(&here, "bare.csv", &["--seed", "8", "--seconds", "60", "--rate", "400"]);
    let tone = |t: f64| [2.0, -1.0, 1.5].map(|size| size * (TAU * 61.3 * t).sin());
    let log = changed(&here, "tone.csv", &log, |row| row % 40 < 8, tone);
    assert_eq!(named(&log), ["periodic"]);
    let cal = here.join("cal.json");
    let fit = ironout(["fit", text(&log), "--add", "periodic", "-o", text(&cal), "--json"]);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    let out = here.join("out.csv");
    let applied = ironout(["apply", text(&log), "--cal", text(&cal), "-o", text(&out)]);
    assert_eq!(applied.status, 0, "{}", applied.stderr);
    let content = std::fs::read_to_string(&out).expect("text");
    let mut rows = content.lines().filter(|line| !line.starts_with('#'));
    let at =
        rows.next().expect("a header").split(',').position(|own| own == "residual_ut").expect("residuals");
    let residuals: Vec<f64> = rows.filter_map(|row| row.split(',').nth(at)?.parse().ok()).collect();
    let rms = (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt();
    // Unapplied, or by another clock, the tone leaves over 1 µT.
    assert!(rms < 0.6, "{rms}");
}
