//! What a log is taken for before anything is searched: a turning board, a resting one, one of a sensor that was calibrated.

use ironout_analysis::outcome::outcome::{Status, Verdict};
use ironout_analysis::{Diagnosis, Options, Table, diagnose};
use ironout_simulation::{EffectSpec, World, WorldOptions};

/// Columns of a log, by name.
type Columns = Vec<(&'static str, Vec<f64>)>;

fn study(columns: &Columns) -> (Diagnosis, Vec<String>) {
    let table = Table::from_columns(columns.iter().map(|(name, values)| (*name, values.as_slice())));
    let found =
        diagnose(&table.expect("columns"), &Options { search: true, ..Options::default() }).expect("a log");
    let named = found.steps.iter().filter_map(|step| step.added.clone()).collect();
    (found, named)
}

/// Noise of about 1, without a generator: sums of incommensurate phases.
fn noise(row: usize, channel: usize) -> f64 {
    let hash = |k: u64| {
        let mut x = (row as u64 * 1_000_003 + channel as u64 * 7919 + k).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x ^= x >> 31;
        x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (x >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..6).map(hash).sum::<f64>() * 2.0_f64.sqrt()
}

/// Readings along `direction`, of a field of 45 µT, without accelerometer and gyro; beside them columns of time.
fn log(
    seconds: f64,
    offset_ut: [f64; 3],
    direction: impl Fn(f64) -> [f64; 3],
    added_ut: impl Fn(&[f64]) -> [f64; 3],
    columns: &[(&'static str, &dyn Fn(f64) -> f64)],
) -> Columns {
    let rows = (75.0 * seconds) as usize;
    let time: Vec<f64> = (0..rows).map(|row| row as f64 / 75.0).collect();
    let beside: Columns =
        columns.iter().map(|(name, of)| (*name, time.iter().map(|t| of(*t)).collect())).collect();
    let mut field: [Vec<f64>; 3] = Default::default();
    for (row, t) in time.iter().enumerate() {
        let values: Vec<f64> = beside.iter().map(|(_, values)| values[row]).collect();
        let (h, added) = (direction(*t), added_ut(&values));
        for axis in 0..3 {
            field[axis].push(45.0 * h[axis] + offset_ut[axis] + added[axis] + 0.2 * noise(row, axis));
        }
    }
    let [x, y, z] = field;
    let mut list: Columns = vec![("t_s", time), ("mx_ut", x), ("my_ut", y), ("mz_ut", z)];
    list.extend(beside);
    list
}

/// A slow swing of some 40°, about two axes.
fn swing(t: f64) -> [f64; 3] {
    let (a, b) = (0.7 * (0.5 * t).sin(), 0.5 * (0.8 * t + 0.4).sin());
    [a.cos() * b.cos(), a.sin() * b.cos(), b.sin()]
}

#[test]
fn slow_columns_beside_a_slow_motion_do_not_make_a_board_rest() {
    let slow: [(&'static str, &dyn Fn(f64) -> f64); 3] = [
        ("wind_mps", &|t| 3.0 + (0.45 * t).sin()),
        ("batt_pct", &|t| 90.0 - 2.0 * t),
        ("imu_temp_c", &|t| 25.0 + 3.0 * (1.0 - (-0.2 * t).exp())),
    ];
    let (found, named) = study(&log(9.0, [90.0, -40.0, 30.0], swing, |_| [0.0; 3], &slow));
    assert_ne!(found.residual, "vector", "it turned");
    assert!(named.is_empty() && found.verdict != Verdict::Complete, "{:?} {named:?}", found.verdict);
}

#[test]
fn a_board_that_rests_is_one_without_a_gyro_too() {
    let beside: [(&'static str, &dyn Fn(f64) -> f64); 2] = [
        ("current_a", &|t| if ((t / 1.7) as u64).is_multiple_of(2) { 0.0 } else { 4.0 + (0.9 * t).sin() }),
        ("batt_pct", &|t| 90.0 - 0.5 * t),
    ];
    let still = |_: f64| [0.6, 0.0, 0.8];
    let moved = |values: &[f64]| [2.0, -1.0, 0.5].map(|one| one * values[0]);
    let (found, named) = study(&log(30.0, [9.0, -4.0, 3.0], still, moved, &beside));
    assert_eq!((found.residual, named), ("vector", vec!["offset:current_a".to_string()]));
}

#[test]
fn a_sensor_with_an_offset_of_its_own_is_not_taken_as_calibrated_before() {
    let beside: [(&'static str, &dyn Fn(f64) -> f64); 2] =
        [("humidity_pct", &|t| 40.0 + (0.7 * t + 1.0).sin()), ("cell_v", &|t| 3.9 - 0.01 * t)];
    for offset_ut in [[11.0, -4.0, 6.0], [6.0, 9.0, -3.0], [-7.0, 3.0, 9.0]] {
        let (found, named) = study(&log(9.0, offset_ut, swing, |_| [0.0; 3], &beside));
        assert!(named.is_empty(), "an offset of {offset_ut:?} µT: {named:?}");
        assert!(matches!(found.verdict, Verdict::Undetermined | Verdict::Complete), "{:?}", found.verdict);
    }
}

#[test]
fn a_magnetometer_that_hangs_is_said_to_and_blames_no_column() {
    let beside: [(&'static str, &dyn Fn(f64) -> f64); 1] = [("current_a", &|t| 2.0 + t.sin())];
    let mut columns = log(20.0, [9.0, -4.0, 3.0], swing, |_| [0.0; 3], &beside);
    for (name, values) in &mut columns {
        if name.ends_with("_ut") {
            let first = values[0];
            values.fill(first);
        }
    }
    let (found, named) = study(&columns);
    assert_eq!((found.verdict, named.len()), (Verdict::Undetermined, 0));
    assert!(found.reasons[0].contains("The sensor is stuck"), "{:?}", found.reasons);
    let blamed = found.candidates.iter().find(|row| row.why.contains("constant"));
    assert!(blamed.is_none(), "{blamed:?}");
}

#[test]
fn a_clock_that_stands_still_tells_no_time() {
    let log = World::new(WorldOptions { seed: 12, seconds: 60.0, ..WorldOptions::default() }).run();
    let mut columns: Vec<(&str, Vec<f64>)> =
        log.named().map(|(name, values)| (name, values.to_vec())).collect();
    columns.iter_mut().filter(|(name, _)| *name == "t_s").for_each(|(_, time)| time.fill(3.0));
    let table = Table::from_columns(columns.iter().map(|(name, values)| (*name, values.as_slice())));
    let found =
        diagnose(&table.expect("columns"), &Options { search: true, ..Options::default() }).expect("a log");
    for id in ["drift", "step", "periodic"] {
        let row = found.candidates.iter().find(|row| row.id == id).expect("its row");
        assert_eq!(row.status, Status::Untestable, "{id}");
    }
}

#[test]
fn an_effect_that_was_asked_for_and_is_not_shown_is_no_missing_one() {
    let log =
        World::new(WorldOptions { seed: 5, seconds: 90.0, noise_ut: 0.2, ..WorldOptions::default() }).run();
    let table = Table::from_columns(log.named()).expect("columns");
    for id in ["offset:current_a", "step", "offset:temp_c^2"] {
        let options = Options { search: true, add: vec![id.into()], ..Options::default() };
        let found = diagnose(&table, &options).expect("a log");
        assert_eq!((found.verdict, found.effects.len()), (Verdict::Complete, 0), "{id} {:?}", found.reasons);
        let row = found.candidates.iter().find(|row| row.id == id).expect("its row");
        assert!(row.status == Status::NotNeeded && row.why.starts_with("requested"), "{}", row.why);
    }
    let effects = vec![EffectSpec::parse("offset:current_a=4").expect("an effect")];
    let log = World::new(WorldOptions {
        seed: 5,
        seconds: 90.0,
        noise_ut: 0.2,
        effects,
        ..WorldOptions::default()
    })
    .run();
    let table = Table::from_columns(log.named()).expect("columns");
    let options = Options { search: true, add: vec!["offset:current_a".into()], ..Options::default() };
    let found = diagnose(&table, &options).expect("a log");
    assert_eq!((found.verdict, found.effects.len()), (Verdict::Missing, 1));
}

#[test]
fn the_chance_of_an_effect_is_that_beside_all_others() {
    let effects = ["offset:current_a=20", "nonlinearity=4", "drift=3"];
    let effects = effects.map(|one| EffectSpec::parse(one).expect("an effect")).to_vec();
    let log = World::new(WorldOptions { seed: 31, seconds: 90.0, effects, ..WorldOptions::default() }).run();
    let table = Table::from_columns(log.named()).expect("columns");
    let found = diagnose(&table, &Options { search: true, ..Options::default() }).expect("a log");
    let ids: Vec<&str> = found.effects.iter().map(|effect| effect.id.as_str()).collect();
    assert_eq!(ids.len(), 3, "{ids:?}");
    for id in ids {
        let row = found.candidates.iter().find(|row| row.id == id).expect("its row");
        // By the spread of the coefficients over forty parts of the log, times the number of candidates.
        assert!(row.p_value.is_some_and(|p| p < 1e-4), "{id}: {:?}", row.p_value);
    }
}

#[test]
fn attitude_that_lacks_little_still_tells_a_cause_that_is_certain() {
    // Some 60° about two axes: enough for an error of the base model of one to two percent of the field.
    let wide = |t: f64| {
        let (a, b) = (1.1 * (0.5 * t).sin(), 0.9 * (0.83 * t + 0.4).sin());
        [a.cos() * b.cos(), a.sin() * b.cos(), b.sin()]
    };
    let pump = |t: f64| if ((t / 1.3) as u64).is_multiple_of(2) { 0.3 } else { 6.0 + (2.1 * t).sin() };
    let beside: [(&'static str, &dyn Fn(f64) -> f64); 2] =
        [("pump_a", &pump), ("cell_v", &|t| 3.9 + 0.2 * (1.9 * t).sin())];
    let moved = |values: &[f64]| [0.9, -0.5, 0.7].map(|one| one * values[0]);
    for seconds in [14.0, 20.0] {
        let offset_ut = [21.0, -14.0, 16.0];
        let (found, named) = study(&log(seconds, offset_ut, wide, moved, &beside));
        assert_eq!((found.verdict, named), (Verdict::Unexplained, vec!["offset:pump_a".to_string()]));
        // The calibration is not sure, and nothing else is wrong.
        assert!(found.reasons.len() == 1 && found.reasons[0].contains("orientations"), "{:?}", found.reasons);
        assert!(found.fit_refuses.is_some(), "{seconds} s");
        let (found, named) = study(&log(seconds, offset_ut, wide, |_| [0.0; 3], &beside));
        assert_eq!((found.verdict, named.len()), (Verdict::Undetermined, 0), "{seconds} s");
    }
}
