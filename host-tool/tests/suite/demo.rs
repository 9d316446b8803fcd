//! The demo, on the simulated and on the emulated board: with the feature `demo`, which the workspace's tests switch on.

use crate::common::ironout;

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

#[test]
fn the_demo_tells_its_story_without_an_emulator() {
    let run = ironout(["demo", "--no-qemu", "--json"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let object = run.json();
    assert_eq!(object["emulated"], false);
    assert!(number(&object["before_percent"]) > 100.0, "{object}");
    for key in ["after_percent", "after_restart_percent"] {
        assert!(number(&object[key]) <= 0.3, "{object}");
    }
    let words = ironout(["demo", "--no-qemu"]).stdout;
    for word in ["cal start", "verdict=accepted", "cal show", "calibrated=1", "after the power cut"] {
        assert!(words.contains(word), "no {word} in {words}");
    }
}

/// The figures of a hidden effect's story: named first, learnt, kept over the power cut, and missed again once removed.
fn hidden(effect: &str, id: &str, options: &[&str], emulated: bool) {
    let run = ironout(["demo", "--json", "--hidden", effect].iter().chain(options));
    assert_eq!(run.status, 0, "{effect}: {} {}", run.stdout, run.stderr);
    let object = run.json();
    assert_eq!((&object["emulated"], &object["named_first"]), (&emulated.into(), &id.into()), "{object}");
    let floor = number(&object["floor_ut"]);
    for key in ["learnt_ut", "after_restart_ut"] {
        assert!(number(&object[key]) <= 1.35 * floor, "{key}: {object}");
    }
    for key in ["before_ut", "removed_ut"] {
        assert!(number(&object[key]) >= 2.0 * number(&object["learnt_ut"]), "{key}: {object}");
    }
}

#[test]
fn a_hidden_effect_is_named_learnt_and_kept() {
    for (effect, id) in [("temperature", "offset:temp_c"), ("current", "offset:current_a"), ("step", "step")]
    {
        hidden(effect, id, &["--no-qemu"], false);
    }
    let words = ironout(["demo", "--no-qemu", "--hidden", "temperature"]).stdout;
    for word in [
        "> why",
        "> effect add offset:temp_c",
        "> effect remove offset:temp_c",
        "error without it",
        "after the power cut",
    ] {
        assert!(words.contains(word), "no {word} in {words}");
    }
}

#[cfg(all(unix, feature = "emulated"))]
#[test]
fn the_firmware_names_a_temperature_that_its_chip_feels() {
    if let Some(_turn) = ironout_rig::qemu::turn("demo --hidden") {
        hidden("temperature", "offset:temp_c", &[], true);
    }
}

#[cfg(all(unix, feature = "emulated"))]
#[test]
fn the_demo_runs_the_firmware_on_the_emulated_board() {
    let Some(_turn) = ironout_rig::qemu::turn("demo") else { return };
    let run = ironout(["demo", "--json"]);
    assert_eq!(run.status, 0, "{} {}", run.stdout, run.stderr);
    let object = run.json();
    assert_eq!(object["emulated"], true);
    for key in ["after_percent", "after_restart_percent"] {
        assert!(number(&object[key]) <= 0.3, "{object}");
    }
}
