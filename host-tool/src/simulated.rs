//! A log whose truth is known, from the options of `ironout simulate`.

use crate::cli::SimulateArgs;
use crate::failure::{Failure, Outcome};
use ironout_simulation::{EffectSpec, FaultSpec, Log, Motion, Temperature, World, WorldOptions};

/// More rows than this are a slip of the pen, not a log.
const MAX_ROWS: f64 = 2e7;

/// The simulated log, and its truth as the comment that is written into it.
///
/// # Errors
/// An option that cannot be.
pub fn simulated(arguments: &SimulateArgs) -> Outcome<(Log, String)> {
    let positive = |name: &str, value: f64, most: f64| {
        if value.is_finite() && value > 0.0 && value <= most {
            Ok(())
        } else {
            Err(Failure::usage(format!("--{name} {value}: expected a number above 0 and at most {most}")))
        }
    };
    positive("seconds", arguments.seconds, 1e7)?;
    positive("rate", arguments.rate, 1e5)?;
    if !(arguments.noise.is_finite() && (0.0..=1e3).contains(&arguments.noise)) {
        return Err(Failure::usage(format!(
            "--noise {}: expected microtesla, from 0 to 1000",
            arguments.noise
        )));
    }
    let rows = (arguments.seconds * arguments.rate).round();
    if !(1.0..=MAX_ROWS).contains(&rows) {
        return Err(Failure::usage(format!(
            "--seconds times --rate is {rows} rows: at least 1 and at most {MAX_ROWS} are written"
        )));
    }
    let mut effects = Vec::new();
    let mut faults = Vec::new();
    for text in &arguments.effect {
        match (EffectSpec::parse(text), FaultSpec::parse(text)) {
            (Ok(effect), _) => effects.push(effect),
            (_, Ok(fault)) => faults.push(fault),
            (Err(error), _) => {
                return Err(Failure::usage(format!(
                    "--effect {text}: {error}; faults of the data: burst, clipping, stuck, gap, copied-axis, repeats, \
                     bursty-arrival"
                )));
            }
        }
    }
    let motion = motion(&arguments.motion)?;
    let temperature = if arguments.ramp { Temperature::Ramp } else { Temperature::WarmUp };
    let world = World::new(WorldOptions {
        seed: arguments.seed,
        seconds: arguments.seconds,
        rate_hz: arguments.rate,
        noise_ut: arguments.noise,
        temperature,
        motion,
        effects,
        faults,
        ..WorldOptions::default()
    });
    let mut log = world.recording(arguments.recording).run();
    for name in &arguments.without {
        let Some(index) = log.position(name) else {
            return Err(Failure::usage(format!(
                "--without {name}: the log has no such column. It has {}",
                log.names.join(", ")
            )));
        };
        log.names.remove(index);
        log.columns.remove(index);
    }
    // A missing cell is NaN too, though never one of the magnetometer's.
    let is_missing = |name: &str, value: f64| value.is_nan() && !["mx_ut", "my_ut", "mz_ut"].contains(&name);
    let mut cells = log
        .names
        .iter()
        .zip(&log.columns)
        .flat_map(|(name, column)| column.iter().map(move |value| (name, *value)));
    if cells.any(|(name, value)| !value.is_finite() && !is_missing(name, value)) {
        return Err(Failure::usage(
            "--effect: values are not finite with this strength. Choose a smaller one",
        ));
    }
    let truth = truth(arguments, &log);
    Ok((log, truth))
}

/// The truth of a simulated log for `--json`.
pub fn truth_json(arguments: &SimulateArgs, log: &Log) -> serde_json::Value {
    serde_json::json!({
        "offset_ut": log.truth.hard_iron_ut, "soft_iron": log.truth.soft_iron,
        "field_ut": log.truth.field_ut, "noise_ut": log.truth.noise_ut,
        "effects": arguments.effect,
        "hidden": log.truth.effects.iter().map(|effect| effect.describe()).collect::<Vec<_>>(),
    })
}

fn motion(text: &str) -> Outcome<Motion> {
    let share = |text: &str| text.parse::<f64>().ok().filter(|share| *share > 0.0 && *share <= 1.0);
    match (text, text.strip_prefix("cap=").and_then(share)) {
        ("sphere", _) => Ok(Motion::Sphere),
        ("hand", _) => Ok(Motion::Hand),
        ("planar", _) => Ok(Motion::Planar),
        ("rest", _) => Ok(Motion::Rest),
        (_, Some(share)) => Ok(Motion::Cap(share)),
        _ => Err(Failure::usage(format!(
            "--motion {text}: expected sphere, hand, planar, rest, or cap=SHARE with a share of the sphere up to 1 (cap=0.3)"
        ))),
    }
}

fn truth(arguments: &SimulateArgs, log: &Log) -> String {
    let [x, y, z] = log.truth.hard_iron_ut;
    let mut text = format!(
        "ironout simulate --seed {} --seconds {} --rate {} --noise {}",
        arguments.seed, arguments.seconds, arguments.rate, arguments.noise
    );
    arguments.effect.iter().for_each(|effect| text.push_str(&format!(" --effect {effect}")));
    if arguments.recording > 1 {
        text.push_str(&format!(" --recording {}", arguments.recording));
    }
    if arguments.motion != "sphere" {
        text.push_str(&format!(" --motion {}", arguments.motion));
    }
    if arguments.ramp {
        text.push_str(" --ramp");
    }
    arguments.without.iter().for_each(|name| text.push_str(&format!(" --without {name}")));
    text.push_str(&format!("\noffset_ut = {x:.6}, {y:.6}, {z:.6}"));
    for (row, values) in log.truth.soft_iron.iter().enumerate() {
        let [a, b, c] = values;
        text.push_str(&format!("\nsoft_iron[{row}] = {a:.8}, {b:.8}, {c:.8}"));
    }
    text.push_str(&format!("\nfield_ut = {}", log.truth.field_ut));
    text.push_str(&format!("\nnoise_ut = {:.6} per axis, quantisation included", log.truth.noise_ut));
    for effect in &log.truth.effects {
        text.push_str(&format!("\neffect {}", effect.describe()));
    }
    text
}
