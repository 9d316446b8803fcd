//! An effect from outside the library is simulated, named, fitted, applied and exported as those of the library are.

use ironout::calibration::{Calibration, norm};
use ironout::effect::{Effect, Id, Registry};
use ironout::extended::Live;
use ironout_analysis::calibration::EffectEntry;
use ironout_analysis::effects::{Calibrated, calibrated, of_library};
use ironout_analysis::outcome::outcome::{Status, Verdict};
use ironout_analysis::{Corrector, Options, Table, diagnose, export, fit};
use ironout_simulation::{EffectSpec, Log, World, WorldOptions};
use own_effect::{REGISTRY, SimulatedServo};
use std::collections::BTreeMap;
use std::process::Command;

#[rustfmt::skip]
#[path = "fixtures/exported.rs"]
mod exported;

const ID: &str = "servo:servo_rad";
const COLUMN: &str = "servo_rad";

fn world(seed: u64, effects: &[&str]) -> World {
    let parse = |text: &&str| EffectSpec::parse_with(text, &[&SimulatedServo]).expect("a known effect");
    World::new(WorldOptions { seed, effects: effects.iter().map(parse).collect(), ..WorldOptions::default() })
}

fn table(log: &Log) -> Table<'_> {
    let columns = log.names.iter().zip(&log.columns);
    Table::from_columns(columns.map(|(name, values)| (name.as_str(), values.as_slice())))
        .expect("a whole log")
}

fn options(registry: Registry) -> Options {
    Options { field_ut: Some(50.0), search: true, registry, ..Options::default() }
}

fn fitted(log: &Log) -> Calibrated {
    let add = vec![ID.to_string()];
    let fitted = fit(&table(log), &Options { add, ..options(REGISTRY) }).expect("the log allows it");
    assert!(fitted.accepted, "{:?}", fitted.reasons);
    let solution = fitted.solution.expect("accepted");
    let entries: Vec<EffectEntry> = solution.effects.iter().map(EffectEntry::from).collect();
    calibrated(solution.calibration, &entries, REGISTRY).expect("what was fitted can be applied")
}

#[test]
fn it_is_named_first_and_alone() {
    for seed in 0..6 {
        let log = world(seed, &["servo:servo_rad=4"]).run();
        let found = diagnose(&table(&log), &options(REGISTRY)).expect("a diagnosis");
        let added: Vec<&str> = found.steps.iter().filter_map(|step| step.added.as_deref()).collect();
        assert_eq!((found.verdict, added), (Verdict::Missing, vec![ID]), "seed {seed}: {:?}", found.reasons);
        let effect = &found.effects[0];
        let truth = log.truth.effects[0].coefficients();
        for ((value, error), truth) in effect.coefficients.iter().zip(&effect.std_errors).zip(truth) {
            assert!((value - truth).abs() < 4.0 * error, "seed {seed}: {value} ± {error}, in truth {truth}");
        }
        // Without its family the same log is not explained so well.
        let without = diagnose(&table(&log), &options(Registry::BUILT_IN)).expect("a diagnosis");
        let left = |steps: &[ironout_analysis::outcome::outcome::StepRow]| {
            steps.last().and_then(|step| step.holdout_rms_ut).expect("a held-out error")
        };
        assert!(
            left(&found.steps) < left(&without.steps) || without.verdict != Verdict::Missing,
            "seed {seed}"
        );
    }
}

#[test]
fn it_is_not_named_where_it_is_not() {
    for (seed, hidden) in [(10, ""), (11, "offset:temp_c=4"), (12, "offset:servo_rad=4")] {
        let effects: Vec<&str> = Some(hidden).filter(|text| !text.is_empty()).into_iter().collect();
        let mut world = world(seed, &effects);
        if hidden.is_empty() {
            // The column is there all the same.
            world = self::world(seed, &["servo:servo_rad=0"]);
        }
        let log = world.run();
        let found = diagnose(&table(&log), &options(REGISTRY)).expect("a diagnosis");
        let added: Vec<&str> = found.steps.iter().filter_map(|step| step.added.as_deref()).collect();
        let wanted: Vec<&str> = hidden.split('=').next().filter(|id| !id.is_empty()).into_iter().collect();
        assert_eq!(added, wanted, "{hidden}: {:?}", found.reasons);
        if log.position(COLUMN).is_some() {
            let row = found.candidates.iter().find(|row| row.id == ID).expect("it was tested");
            assert_ne!(row.status, Status::Missing, "{hidden}");
        }
    }
}

#[test]
fn the_library_lists_it_and_refuses_what_the_log_lacks() {
    let log = world(1, &["offset:temp_c=3"]).run();
    let refused = fit(&table(&log), &Options { add: vec![ID.to_string()], ..options(REGISTRY) });
    let why = refused.expect_err("there is no such column").to_string();
    assert!(why.contains("no such column"), "{why}");
    let unknown = fit(&table(&log), &Options { add: vec!["srvo:temp_c".into()], ..options(REGISTRY) });
    let why = unknown.expect_err("there is no such effect").to_string();
    assert!(why.contains("Did you mean servo:temp_c"), "{why}");
    let foreign = fit(&table(&log), &Options { add: vec![ID.to_string()], ..options(Registry::BUILT_IN) });
    assert!(foreign.expect_err("a program that does not know it").to_string().contains("unknown effect"));
    let apart = |one, other| REGISTRY.parse(one).zip(REGISTRY.parse(other)).and_then(|(a, b)| a.apart(&b));
    let advice = apart("drift", ID).expect("advice").to_string();
    assert!(advice.contains(COLUMN) && !advice.contains('{'), "{advice}");
}

#[test]
fn it_is_fitted_and_applied_to_another_log() {
    let world = world(3, &["servo:servo_rad=4", "offset:temp_c=3"]);
    let log = world.run();
    let add = vec![ID.to_string(), "offset:temp_c".to_string()];
    let fit = fit(&table(&log), &Options { add, ..options(REGISTRY) }).expect("the log allows both");
    let solution = fit.solution.expect("a calibration");
    let entries: Vec<EffectEntry> = solution.effects.iter().map(EffectEntry::from).collect();
    let calibration = calibrated(solution.calibration, &entries, REGISTRY).expect("sound");
    assert!(calibration.is_sound());
    assert!(of_library(&calibration).is_none(), "the board's records hold the library's effects only");
    let second = world.recording(2).run();
    let table = table(&second);
    let corrector = Corrector::new(calibration, &table).expect("every column is there");
    let squares: f64 =
        (0..second.rows()).map(|row| (norm(corrector.correct(row).expect("a field")) - 50.0).powi(2)).sum();
    let rms = (squares / second.rows() as f64).sqrt();
    assert!(rms < 1.2 * second.truth.noise_ut, "{rms} µT against {} µT of noise", second.truth.noise_ut);
}

/// The calibration of the fixture: digits that do not depend on the machine.
fn fixed() -> Calibrated {
    let base = Calibration {
        offset_ut: [12.5, -7.25, 3.0],
        matrix: [[1.02, 0.015, -0.02], [0.0, 0.97, 0.03], [0.0, 0.0, 1.05]],
        field_ut: 50.0,
    };
    let entry = |id: &str, column: &str, coefficients: &[f64], reference: Option<f64>| EffectEntry {
        id: id.into(),
        name: String::new(),
        columns: vec![column.into()],
        coefficients: coefficients.to_vec(),
        std_errors: coefficients.iter().map(|_| Some(0.01)).collect(),
        unit: String::new(),
        reference: reference.map(|value| (column.to_string(), value)).into_iter().collect::<BTreeMap<_, _>>(),
        parameters: BTreeMap::new(),
        range: None,
        bends: Default::default(),
    };
    let entries = [
        entry(ID, COLUMN, &[2.5, -1.25], None),
        entry("offset:temp_c", "temp_c", &[0.3, -0.1, 0.2], Some(25.0)),
    ];
    calibrated(base, &entries, REGISTRY).expect("sound")
}

#[test]
fn it_is_exported_as_rust_and_the_code_corrects_alike() {
    let text = export::rust::text(&fixed(), &Default::default(), "an example");
    assert_eq!(text, include_str!("fixtures/exported.rs"), "the fixture is not what export writes:\n{text}");
    let mut host = Live::new(&exported::CALIBRATION_F64).expect("sound");
    let mut board = Live::new(&exported::CALIBRATION).expect("sound");
    let log = world(5, &["servo:servo_rad=4"]).run();
    let table = table(&log);
    let corrector = Corrector::new(fixed(), &table).expect("every column is there");
    for row in (0..log.rows()).step_by(37) {
        for name in [COLUMN, "temp_c"] {
            let value = log.column(name).expect("a column")[row];
            assert!(host.set(name, value) && board.set(name, value as f32));
        }
        let measured = table.field(row);
        let wanted = corrector.correct(row).expect("a field");
        let got = host.apply(measured, None).expect("a field");
        let single = board.apply(measured.map(|v| v as f32), None).expect("a field");
        for axis in 0..3 {
            assert!((got[axis] - wanted[axis]).abs() < 1e-12 * 50.0, "row {row}: {got:?}, {wanted:?}");
            assert!(
                (f64::from(single[axis]) - wanted[axis]).abs() < 1e-4,
                "row {row}: {single:?}, {wanted:?}"
            );
        }
    }
}

#[test]
fn it_is_exported_as_c_and_the_code_corrects_alike() {
    if Command::new("cc").arg("--version").output().is_err() {
        use std::io::Write;
        let _ = writeln!(std::io::stderr(), "SKIPPED: there is no C compiler `cc`");
        assert!(std::env::var_os("CI").is_none(), "CI has a C compiler");
        return;
    }
    let log = world(5, &["servo:servo_rad=4"]).run();
    let calibration = fitted(&log);
    let header = export::c::text(&calibration, &Default::default(), "an example").expect("C");
    let table = table(&log);
    let corrector = Corrector::new(calibration, &table).expect("every column is there");
    let folder = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let mut rows = String::new();
    let mut wanted = Vec::new();
    let angles = log.column(COLUMN).expect("the column");
    for row in (0..log.rows()).step_by(41) {
        let [x, y, z] = table.field(row);
        rows += &format!("{{{x:?}, {y:?}, {z:?}, {:?}}},\n", angles[row]);
        wanted.push(corrector.correct(row).expect("a field"));
    }
    let program = format!(
        "#include <stdio.h>\n#define IRONOUT_REAL double\n#include \"calibration.h\"\n\
         static const double rows[][4] = {{\n{rows}}};\n\
         int main(void) {{\n    for (unsigned n = 0; n < sizeof rows / sizeof rows[0]; n++) {{\n        double out[3];\n        \
         ironout_apply(rows[n], rows[n][3], out);\n        printf(\"%.17g %.17g %.17g\\n\", out[0], out[1], out[2]);\n    }}\n    \
         return 0;\n}}\n"
    );
    let (source, binary) = (folder.join("main.c"), folder.join("corrected"));
    std::fs::write(folder.join("calibration.h"), header).expect("the header");
    std::fs::write(&source, program).expect("the program");
    let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1"];
    let built =
        Command::new("cc").args(flags).arg(&source).arg("-o").arg(&binary).arg("-lm").output().expect("cc");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let out = Command::new(&binary).output().expect("the program");
    let text = String::from_utf8(out.stdout).expect("numbers");
    assert_eq!(text.lines().count(), wanted.len());
    for (line, wanted) in text.lines().zip(wanted) {
        for (got, wanted) in line.split(' ').map(|word| word.parse::<f64>().expect("a number")).zip(wanted) {
            assert!((got - wanted).abs() < 1e-10, "{line} against {wanted}");
        }
    }
}

#[test]
fn ids_are_read_and_printed() {
    let named = REGISTRY.parse(ID).expect("known");
    assert_eq!((named.family.kind(), named.column), ("servo", COLUMN));
    let calibration = fixed();
    let ids: Vec<String> = calibration.effects.iter().map(|fitted| Id(&fitted.effect).to_string()).collect();
    assert_eq!(ids, [ID, "offset:temp_c"]);
    let effect = own_effect::Servo { column: COLUMN };
    assert_eq!(Effect::<f64>::name(&effect), "servo magnet");
}
