//! Harder truths: a few logs of the kinds that `cargo truths` measures in full.

use ironout_host_tests::accuracy::truths::{MEASURED_ON, Outcome, TUNED_ON, run};
use ironout_simulation::truths::{Kind, draw};

/// Runs a few logs; at most `most` may come out otherwise than they should.
fn hold(kind: Kind, logs: u64, most: usize) {
    let list = run(kind, TUNED_ON, 0..logs, |_| {});
    let bad: Vec<String> =
        list.iter().filter(|one| !one.good(kind)).map(|one| one.line(kind.name())).collect();
    assert_eq!(list.len() as u64, logs);
    assert!(bad.len() <= most, "{}", bad.join("\n"));
}

#[test]
fn nobody_is_named_where_nothing_is_hidden_whatever_the_colour_of_the_noise() {
    hold(Kind::Nothing, 4, 0);
    hold(Kind::NothingFlicker, 6, 0);
}

#[test]
fn no_step_is_named_for_flicker_noise_that_wanders() {
    // A log whose noise takes a step with a chance of 3e-5 where it is held for a stationary error of the magnitude.
    let list = run(Kind::NothingFlicker, TUNED_ON, 31..32, |_| {});
    assert!(list.iter().all(|one| one.good(Kind::NothingFlicker)), "{}", list[0].line("nothing-flicker"));
}

#[test]
fn one_effect_under_flicker_noise_is_named_alone() {
    hold(Kind::OneFlicker, 3, 1);
}

#[test]
fn a_tone_is_found_behind_stamps_of_arrival() {
    hold(Kind::Arrival, 3, 0);
}

#[test]
fn a_cause_that_is_not_in_the_log_is_not_explained_away() {
    hold(Kind::Deleted, 4, 0);
}

#[test]
fn logs_that_are_measured_are_none_that_were_tuned_on_and_come_again() {
    for kind in Kind::ALL {
        let (tuned, measured) = (draw(kind, TUNED_ON, 0), draw(kind, MEASURED_ON, 0));
        assert_ne!(tuned.words, measured.words, "{kind:?}");
        assert_eq!(draw(kind, TUNED_ON, 0).words, tuned.words, "{kind:?}");
    }
    let again = |_: u64| -> Vec<Outcome> { run(Kind::NothingFlicker, TUNED_ON, 10..11, |_| {}) };
    assert_eq!(again(0)[0].verdict, again(1)[0].verdict);
}
