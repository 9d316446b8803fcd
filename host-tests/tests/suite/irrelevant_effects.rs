//! Effects that have nothing to do with a log do not make it look better than it is: a few logs of the table that
//! `cargo additions-accuracy` measures in full.

use ironout_host_tests::accuracy::irrelevant::{CASES, Kind, trials};
use ironout_host_tests::accuracy::irrelevant_table::{Irrelevant, wilson};

#[test]
fn an_irrelevant_effect_turns_no_refused_log_into_an_accepted_one() {
    let (mut refused, mut bad) = (0, Vec::new());
    // A hidden current, a hidden temperature: the fits of both are refused, and nothing in the log explains them.
    for case in CASES.iter().filter(|case| !case.without.is_empty()).take(3) {
        for trial in trials(case, 1, &["offset:walk^2", "offset:wave"]) {
            assert_eq!(trial.kind, Kind::Irrelevant);
            refused += u32::from(!trial.plain.accepted);
            if trial.is_turned() || trial.is_worse() {
                bad.push(format!(
                    "{} + {}: {:?} -> {:?}",
                    case.hidden, trial.addition, trial.plain, trial.with
                ));
            }
        }
    }
    assert!(refused >= 5, "only {refused} additions to refused logs");
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn the_effect_that_is_there_is_accepted() {
    let own = CASES.iter().filter(|case| case.without.is_empty() && !case.hidden.is_empty());
    let mut tried = 0;
    for case in own {
        for trial in trials(case, 1, &[]).iter().filter(|trial| trial.kind == Kind::Own) {
            tried += 1;
            assert!(trial.with.accepted, "{} + {}: {:?}", case.hidden, trial.addition, trial.with);
        }
    }
    assert!(tried >= 4, "only {tried}");
}

#[test]
fn wilsons_interval_is_known() {
    let near = |a: f64, b: f64| (a - b).abs() < 5e-4;
    let [low, high] = wilson(8, 40);
    assert!(near(low, 0.1050) && near(high, 0.3476), "{low} {high}");
    let [low, high] = wilson(0, 300);
    assert!(low == 0.0 && near(high, 0.0126), "{low} {high}");
    assert!(Irrelevant::snapshot_path().exists(), "run cargo additions-accuracy --accept");
}
