//! Columns that move together: the one that predicts held-out time best is named, and of two that do it equally well the current.

use ironout_analysis::{Options, Table, diagnose};
use ironout_simulation::{EffectSpec, World, WorldOptions};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

#[test]
fn the_current_of_a_drone_is_named_before_its_throttle_and_outputs() {
    for (seed, hidden, expected) in [
        (1, "offset:current_a=2", "offset:current_a"),
        (2, "offset:current_a=0.8", "offset:current_a"),
        (3, "offset:current_a=0.8", "offset:current_a"),
        (4, "offset:current_a=4", "offset:current_a"),
    ] {
        let effects = vec![EffectSpec::parse(hidden).unwrap()];
        let log = World::new(WorldOptions { seed, effects, ..WorldOptions::default() }).run();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let current = log.column("current_a").unwrap();
        let most = current.iter().copied().fold(1.0, f64::max);
        let mut noisy = |column: &[f64], by: f64| -> Vec<f64> {
            column.iter().map(|value| value + by * rng.random_range(-1.0..1.0)).collect()
        };
        // Power goes with about the square of what is commanded; each output has its own share of the control.
        let throttle: Vec<f64> =
            current.iter().map(|current| (current / most).max(0.0).powf(1.0 / 1.8)).collect();
        let throttle = noisy(&throttle, 0.02);
        let outputs: Vec<Vec<f64>> = (0..4).map(|_| noisy(&throttle, 0.05)).collect();
        let mut columns: Vec<(&str, &[f64])> = log.named().collect();
        columns.insert(1, ("throttle", &throttle));
        let names = ["out1", "out2", "out3", "out4"];
        columns.extend(names.into_iter().zip(outputs.iter().map(Vec::as_slice)));
        let found =
            diagnose(&Table::from_columns(columns).unwrap(), &Options { search: true, ..Options::default() })
                .unwrap();
        let named: Vec<String> = found.steps.iter().filter_map(|step| step.added.clone()).collect();
        assert_eq!(named, [expected], "seed {seed}: {:?}", found.verdict);
    }
}
