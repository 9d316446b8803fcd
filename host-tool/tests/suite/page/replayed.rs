//! Logs that are replayed to a simulated board.

use crate::common::{folder, simulate, text};
use crate::page::board::live;
use crate::page::browser::{number, scenario, turn, words};
use crate::page::emulated::assert_learned;
use serde_json::json;

/// What noise leaves with the effect in the model, µT: a replayed log's columns are fed ten times a second, so each is a little old.
const FLOOR_UT: f64 = 0.76;
/// The page draws at most so often.
const MOST_UPDATES_PER_S: f64 = 30.0;

#[test]
fn a_refused_calibration_is_asked_why_and_made_with_what_was_missing() {
    let Some(_turn) = turn("live --replay") else { return };
    let here = folder("page-replay");
    // So strong that offset and matrix only are refused.
    let log =
        simulate(&here, "log.csv", &["--seed", "17", "--seconds", "240", "--effect", "offset:current_a=12"]);
    let (_program, address) = live(&["--replay", text(&log), "--speed", "8"]);
    let hidden = json!({"id": "offset:current_a", "noise_ut": FLOOR_UT});
    let seen = scenario("replay", json!({"address": address, "hidden": hidden}));
    // Before anything was started there is nothing to ask for; the keyboard stays where it was.
    assert_eq!((&seen["idle"], &seen["held"]), (&json!(true), &json!("cal-start")), "{seen}");
    assert!(words(&seen["judged"]).contains("Refused"), "{seen}");
    assert_learned(&seen, "offset:current_a", FLOOR_UT);
    assert!(words(&seen["hint"]).starts_with("a calibration is in use"), "{seen}");
}

#[test]
fn a_board_that_streams_costs_the_page_few_updates_and_layouts() {
    let Some(_turn) = turn("the cost of live") else { return };
    let here = folder("page-load");
    let log = simulate(&here, "log.csv", &["--seed", "17", "--seconds", "600"]);
    let (program, address) = live(&["--replay", text(&log)]);
    let seen = scenario("load", json!({"address": address, "seconds": 6, "server": program.id()}));
    // What is counted is the same on every machine. What it costs in seconds of a processor is printed, and is in docs/page.md.
    for state in ["collecting", "calibrated"] {
        let rate = |key: &str| number(&seen[state][key]);
        let updates = rate("updates");
        assert!(updates > 0.0 && rate("samples") > 0.0, "{seen}");
        assert!(updates < 1.1 * MOST_UPDATES_PER_S, "{state}: {updates} updates per second: {seen}");
        for (what, most) in [("LayoutCount", 2.0), ("RecalcStyleCount", 3.0), ("Nodes", 0.5)] {
            let each = rate(what) / updates;
            assert!(each < most, "{state}: {each} {what} per update: {seen}");
        }
    }
    println!("{seen}");
}
