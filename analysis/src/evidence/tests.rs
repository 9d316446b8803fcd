//! Known answers of the engine as a whole, on simulated logs.

use crate::evidence::verdict::{Evidence, judge};
use crate::outcome::outcome::Verdict;
use crate::outcome::request::Options;
use crate::table::Table;
use ironout_simulation::{EffectSpec, Log, World, WorldOptions};

fn log(effects: &[&str], drop: &[&str], seed: u64) -> Log {
    World::new(WorldOptions {
        seed,
        seconds: 60.0,
        rate_hz: 25.0,
        effects: effects.iter().map(|effect| EffectSpec::parse(effect).unwrap()).collect(),
        drop_columns: drop.iter().map(|name| (*name).to_owned()).collect(),
        ..WorldOptions::default()
    })
    .run()
}

fn judged(log: &Log) -> Evidence {
    let table = Table::from_columns(log.named()).unwrap();
    judge(&table, &Options { search: true, ..Options::default() }, false)
}

#[test]
fn each_form_of_a_term_is_named_by_itself() {
    for effect in [
        "offset:temp_c",
        "offset:current_a^2",
        "gain:temp_c",
        "step",
        "nonlinearity",
        "periodic",
        "field:height_m",
    ] {
        let found = judged(&log(&[&format!("{effect}=4")], &[], 11));
        assert_eq!(found.named, [effect], "{found:?}");
        assert_eq!(found.verdict, Verdict::Missing, "{effect}");
        assert!(found.rms_ut[1] < 0.6 * found.rms_ut[0], "{effect}: {:?}", found.rms_ut);
    }
}

#[test]
fn a_late_sensor_is_found_by_the_dip_with_its_delay() {
    let found = judged(&log(&["lag=40ms"], &[], 5));
    assert_eq!(found.named, ["lag"]);
    let late = found.lateness.unwrap();
    assert!((late.delay_s - 0.04).abs() < 0.004, "{late:?}");
}

#[test]
fn nothing_is_named_where_nothing_is_hidden() {
    for seed in 0..6 {
        let found = judged(&log(&[], &[], 100 + seed));
        assert!(found.named.is_empty() && found.confounded.is_empty(), "{found:?}");
        assert_eq!(found.verdict, Verdict::Complete);
    }
}

#[test]
fn a_cause_that_nobody_logged_is_told_with_its_size() {
    let found = judged(&log(&["offset:servo=5"], &["servo"], 3));
    assert!(found.named.is_empty(), "{:?}", found.named);
    assert_eq!(found.verdict, Verdict::Unexplained);
    let hidden = found.hidden.unwrap();
    assert!(!hidden.is_gain && hidden.size_ut > 0.5 && hidden.tau_s < 10.0, "{hidden:?}");
}

#[test]
fn two_effects_are_named_together() {
    let mut named = judged(&log(&["offset:current_a=4", "gain:temp_c=4"], &[], 8)).named;
    named.sort();
    assert_eq!(named, ["gain:temp_c", "offset:current_a"]);
}
