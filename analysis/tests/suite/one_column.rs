//! What one column does, in its simplest form: where one axis' gain follows a temperature, no sum of effects that cancel is put in
//! its place, and the correction holds in the cold. A board that is strapped down while its current rises counts, too.

use ironout_analysis::calibration::EffectEntry;
use ironout_analysis::outcome::outcome::Verdict;
use ironout_analysis::{Corrector, Diagnosis, Options, Table, diagnose, effects::calibrated};
use ironout_simulation::{EffectSpec, Log, World, WorldOptions};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// A log of a sensor whose gain along one axis changes by so much per °C, about 25 °C; `colder` shifts the temperature, °C.
fn log(seed: u64, axis: &str, per_c: f64, colder: f64) -> Log {
    let mut log = World::new(WorldOptions { seed, ..WorldOptions::default() }).run();
    let temp = log.position("temp_c").unwrap();
    log.columns[temp].iter_mut().for_each(|temp_c| *temp_c -= colder);
    let temp_c = log.columns[temp].clone();
    let position = log.position(axis).unwrap();
    for (reading_ut, temp_c) in log.columns[position].iter_mut().zip(temp_c) {
        *reading_ut *= 1.0 + per_c * (temp_c - 25.0);
    }
    log
}

fn diagnosed(log: &Log) -> Diagnosis {
    let options = Options { search: true, ..Options::default() };
    diagnose(&Table::from_columns(log.named()).unwrap(), &options).unwrap()
}

fn named(found: &Diagnosis) -> Vec<String> {
    found.steps.iter().filter_map(|step| step.added.clone()).collect()
}

#[test]
fn the_gain_of_one_axis_is_a_gain_and_holds_in_the_cold() {
    for (seed, axis) in [(1, "mz_ut"), (2, "mz_ut"), (3, "my_ut"), (4, "mx_ut")] {
        for per_c in [0.004, 0.008] {
            let found = diagnosed(&log(seed, axis, per_c, 0.0));
            let names = named(&found);
            assert_eq!(names, ["gain:temp_c"], "{seed} {axis} {per_c}: {:?}", found.verdict);

            let entries: Vec<EffectEntry> = found.effects.iter().map(Into::into).collect();
            let cold = log(seed, axis, per_c, 17.0);
            let [with, without] = [&entries[..], &[]].map(|entries| rms_ut(&cold, &found, entries));
            // The correction is held beyond a range's own width, so that it is not whole; but it never makes an error of its own.
            assert!(with < 0.75 * without, "{seed} {axis} {per_c}: {with} of {without} µT");
        }
    }
}

/// Rms error of the magnitude of a log under a calibration with these effects, µT.
fn rms_ut(log: &Log, found: &Diagnosis, effects: &[EffectEntry]) -> f64 {
    let table = Table::from_columns(log.named()).unwrap();
    let calibration = found.calibration.unwrap();
    let corrector =
        Corrector::new(calibrated(calibration, effects, found.registry).unwrap(), &table).unwrap();
    let squares = (0..table.rows())
        .map(|row| corrector.correct(row).unwrap())
        .map(|h| (h.iter().map(|part| part * part).sum::<f64>().sqrt() - calibration.field_ut).powi(2));
    (squares.sum::<f64>() / table.rows() as f64).sqrt()
}

/// The log of a board that is turned with its motors idle, and then strapped down while their current rises and falls.
fn strapped(seed: u64, per_a_ut: [f64; 3]) -> Log {
    let mut log = World::new(WorldOptions { seed, ..WorldOptions::default() }).run();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = move |by: f64| by * (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
    let rows = log.columns[0].len();
    let position = |name: &str| log.position(name).unwrap();
    let (time, current) = (position("t_s"), position("current_a"));
    let gyro = ["gx_radps", "gy_radps", "gz_radps"].map(position);
    let field = ["mx_ut", "my_ut", "mz_ut"].map(position);
    log.columns[current].iter_mut().for_each(|current_a| *current_a = 0.4 + noise(0.02));
    // Its reading there without noise. A noisy reading that is repeated would be a step of the offset.
    let quiet = World::new(WorldOptions { seed, noise_ut: 0.0, ..WorldOptions::default() }).run();
    let held: Vec<f64> = log.columns.iter().map(|column| column[rows / 3]).collect();
    let held: Vec<f64> = (0..held.len())
        .map(|place| if field.contains(&place) { quiet.columns[place][rows / 3] } else { held[place] })
        .collect();
    let (end_s, step_s) = (log.columns[time][rows - 1], log.columns[time][1] - log.columns[time][0]);
    for row in 0..1500 {
        let along = f64::from(row) / 750.0;
        let current_a = 0.4 + 20.0 * (1.0 - (along - 1.0).abs()) + noise(0.1);
        for (place, column) in log.columns.iter_mut().enumerate() {
            let axis = field.iter().position(|own| *own == place);
            column.push(match axis {
                _ if place == time => end_s + step_s * f64::from(row + 1),
                _ if place == current => current_a,
                Some(axis) => held[place] + per_a_ut[axis] * (current_a - 0.4) + noise(0.25),
                None if gyro.contains(&place) => noise(0.01),
                None => held[place] + noise(0.01),
            });
        }
    }
    log
}

#[test]
fn a_board_that_is_strapped_down_shows_what_its_current_does() {
    for seed in 1..=3 {
        let log = strapped(seed, [0.5, -0.4, 0.3]);
        let found = diagnosed(&log);
        assert!(
            found.verdict != Verdict::Complete && found.verdict != Verdict::Undetermined,
            "seed {seed}: {:?}",
            found.verdict
        );
        // At one attitude a gain follows as well as an offset does, so that it is confounded, or not certain.
        assert!(
            !found.effects.is_empty() && found.effects.iter().all(|effect| effect.id.ends_with(":current_a")),
            "seed {seed}: {:?}",
            found.effects
        );
        assert_eq!(diagnosed(&strapped(seed, [0.0; 3])).verdict, Verdict::Complete, "seed {seed}");
    }
}

#[test]
fn a_column_with_a_value_in_every_fifteenth_row_is_named() {
    for seed in 1..4 {
        let effects = vec![EffectSpec::parse("offset:current_a=2").unwrap()];
        let mut log = World::new(WorldOptions { seed, effects, ..WorldOptions::default() }).run();
        let current = log.position("current_a").unwrap();
        let slow = |(row, value): (usize, &mut f64)| *value = if row % 15 == 0 { *value } else { f64::NAN };
        log.columns[current].iter_mut().enumerate().for_each(slow);
        let found = diagnosed(&log);
        // Between its values it is a mean of two of them, so that it may be taken as late or early.
        let names = named(&found);
        assert!(names.len() == 1 && names[0].starts_with("offset:current_a"), "{seed}: {names:?}");

        // With fewer than ten values nobody can say what it did.
        log.columns[current].iter_mut().skip(9 * 15).for_each(|value| *value = f64::NAN);
        let found = diagnosed(&log);
        assert!(!named(&found).iter().any(|id| id.contains("current_a")), "{seed}: {:?}", named(&found));
    }
}
