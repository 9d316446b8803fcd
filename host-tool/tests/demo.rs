//! The demo, on the simulated and on the emulated board: with the feature `demo`, which the workspace's tests switch on.

mod common;

use common::ironout;

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

#[cfg(unix)]
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
