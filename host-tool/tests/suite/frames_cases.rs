//! Logs whose truth is known, and units of programs: the shared cases and small files of the test's own.

use crate::common::target::*;
use crate::common::{folder, ironout, text, write};
use crate::frames::numbers_of;
use crate::writers::ros::{Form, Message};
use crate::writers::sqlite::Sqlite;
use crate::writers::truth::{Truth, read_with};
use ironout_cli::input::{ReadOptions, read_log};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A file of the shared cases, or `None` (and a word about it) where they are not at hand.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/cases")).join(name);
    if path.exists() {
        return Some(path);
    }
    let _ = writeln!(std::io::stderr(), "SKIPPED: the case {name} is not here");
    None
}

fn near(found: &[f64], wanted: &[f64], most: f64) {
    assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= most), "{found:?} for {wanted:?}");
}

#[test]
fn known_offsets_come_back_in_the_numbers_of_their_source() {
    let here = folder("frames_known");
    let cal = here.join("cal.json");
    if let Some(log) = shared("e1_ros_flu_known_offset.mcap") {
        assert_eq!(ironout(["fit", text(&log), "-o", text(&cal)]).status, 0);
        let file = exported(&cal, "ros", &[]);
        let bias = ["x", "y", "z"].map(|axis| {
            let key = format!("initial_mag_bias_{axis}: ");
            rows(&file).find_map(|line| line.trim().strip_prefix(&key)?.parse().ok()).expect("a number")
        });
        near(&bias, &[7e-6, 8.3e-6, -1.2e-5], 4e-8);
    }
    for name in [
        "e2_blackbox_known_offset.bbl",
        "e3_blackbox_high_resolution.bbl",
        "e4_blackbox_3_1_protocol_name.bbl",
    ] {
        let Some(log) = shared(name) else { continue };
        let run = ironout(["fit", text(&log), "--ut-per-count", "0.0333", "-o", text(&cal)]);
        assert_eq!(run.status, 0, "{name}: {}", run.stderr);
        assert!(!run.said().contains("raw counts"), "{name}: {}", run.stderr);
        let file = exported(&cal, "betaflight", &["--ut-per-count", "0.0333"]);
        let line =
            rows(&file).find_map(|line| line.strip_prefix("set mag_calibration = ")).expect("an offset");
        near(&numbers_of(line), &[209.0, 249.0, -2.0], 1.0);
    }
}

#[test]
fn a_log_of_high_resolution_has_the_gyro_of_one_of_plain_resolution() {
    let paths = ["e2_blackbox_known_offset.bbl", "e3_blackbox_high_resolution.bbl"].map(shared);
    let [Some(plain), Some(fine)] = paths else { return };
    let gyro = |path: &Path| {
        let scale = ReadOptions { ut_per_count: Some([0.0333; 3]), ..ReadOptions::default() };
        read_log(path, &scale).expect("a log").gyro_radps.expect("a gyroscope")
    };
    let (plain, fine) = (gyro(&plain), gyro(&fine));
    let turns = plain.iter().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
    assert!(turns > 0.1, "{turns}");
    for (plain, fine) in plain.iter().zip(&fine) {
        // A degree a second, rounded.
        near(plain, fine, 0.6_f64.to_radians());
    }
}

#[test]
fn the_unit_of_a_binary_format_can_be_given() {
    let Some(log) = shared("e5_ros_in_microtesla.mcap") else { return };
    let refused = ironout(["fit", text(&log), "--json"]).error();
    let message = refused["message"].as_str().expect("a message");
    assert!(message.contains("48.0 µT") && message.contains("[uT]"), "{message}");
    let source = |axis: &str| format!("m{axis}_ut=/imu/mag.magnetic_field.{axis}[uT]");
    let map = ["x", "y", "z"].map(source).join(",");
    assert!(message.contains(&map), "{message}");
    let fit = ironout(["fit", text(&log), "--map", &map, "--json"]).json();
    assert!((fit["field_ut"].as_f64().expect("a field") - 48.0).abs() < 0.1, "{fit}");
    assert_eq!(fit["read_as"]["frame"]["ut_per_number"], serde_json::json!([1.0, 1.0, 1.0]));
    // One axis alone, another column for it, and a unit that is none.
    for (map, words) in [
        (source("x"), "all three"),
        ("mx_ut=/imu/mag.magnetic_field.y[uT]".into(), "not the x axis"),
        ("mx_ut=/imu/mag.magnetic_field.x[parsec]".into(), "unknown unit"),
    ] {
        let error = ironout(["fit", text(&log), "--map", &map, "--json"]).error();
        assert!(error["message"].as_str().is_some_and(|text| text.contains(words)), "{map}: {error}");
    }
}

#[test]
fn directions_in_a_bag_are_refused_and_a_field_is_not() {
    let truth = Truth::new("frames_directions");
    let here = folder("frames_directions_bag");
    for (name, length, is_direction) in
        [("ones.db3", 1.0, true), ("tesla.db3", 48e-6, true), ("field.db3", 0.0, false)]
    {
        let messages: Vec<(i64, i64, Vec<u8>)> = (0..600)
            .map(|row| {
                let ns = 1_700_000_000_000_000_000 + truth.micros(row) * 1000;
                let field = truth.field(row);
                let factor = if is_direction { length / norm(field) } else { 1e-6 };
                let message = Message::new(Form::Little, ns, "imu_link");
                (1, ns as i64, message.doubles(&field.map(|v| v * factor)).doubles(&[0.0; 9]).finish())
            })
            .collect();
        let bag = Sqlite::bag(&[("/imu/mag", "sensor_msgs/msg/MagneticField")], &messages);
        let path = write(&here, name, bag);
        let run = ironout(["fit", text(&path)]);
        let said = run.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(run.status, if is_direction { 2 } else { 0 }, "{name}: {said}");
        if is_direction {
            assert!(said.contains("directions"), "{name}: {said}");
            // Another unit, or a scale of its own, makes no field of it.
            let source = |axis: &str| format!("m{axis}_ut=/imu/mag.magnetic_field.{axis}[uT]");
            let map = ["x", "y", "z"].map(source).join(",");
            let run = ironout(["fit", text(&path), "--map", &map]);
            assert!(run.status == 2 && run.said().contains("directions"), "{name}: {}", run.stderr);
        }
    }
}

#[test]
fn old_logs_of_ardupilot_hold_hundredths_of_volts_and_amperes() {
    let Some(path) = shared("a1_ardupilot_3_2_curr.log") else { return };
    let log = read_log(&path, &ReadOptions::default()).expect("a log");
    let first = |name: &str| log.covariate(name).unwrap_or_else(|| panic!("no {name}")).values[0];
    near(&[first("voltage_v"), first("current_a")], &[12.39, 44.0], 1e-9);
}

/// A DataFlash text of one CURR field, with what stands before it.
fn curr(letter: char, before: &str, cells: &[&str]) -> Vec<f64> {
    let mut text = format!(
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\nFMT, 172, 31, MAG, Ihhh, TimeMS,MagX,MagY,MagZ\n\
         FMT, 164, 21, CURR, I{letter}, TimeMS,Curr\n{before}"
    );
    for (row, cell) in cells.iter().enumerate() {
        text += &format!("MAG, {0}, {1}, -113, 492\nCURR, {0}, {cell}\n", 100 * row, 82 + row);
    }
    let log =
        read_with(text.as_bytes(), &ReadOptions::default()).unwrap_or_else(|failure| panic!("{failure}"));
    log.covariate("current_a").expect("a current").values.clone()
}

#[test]
fn letters_and_stated_units_are_applied_once() {
    let fmtu = "FMT, 130, 44, FMTU, QBNN, TimeUS,FmtType,UnitIds,MultIds\nFMT, 131, 77, UNIT, QbZ, TimeUS,Id,Label\n\
                FMT, 132, 20, MULT, Qbd, TimeUS,Id,Mult\nUNIT, 1, 65, A\nMULT, 1, 67, 0.001\nMULT, 1, 66, 0.01\n";
    let milli = format!("{fmtu}FMTU, 1, 164, sA, CC\n");
    let hundredths = format!("{fmtu}FMTU, 1, 164, sA, CB\n");
    let whole = ["4400", "4410", "4420", "4430", "4440", "4450"];
    let printed = ["44.00", "44.10", "44.20", "44.30", "44.40", "44.50"];
    for (letter, before, cells) in [
        ('h', "", whole),
        ('c', "", printed),
        // A program that prints the stored number.
        ('c', "", whole),
        ('h', hundredths.as_str(), whole),
        ('c', hundredths.as_str(), printed),
        ('f', "", printed),
    ] {
        near(&curr(letter, before, &cells), &[44.0, 44.1, 44.2, 44.3, 44.4, 44.5], 1e-9);
    }
    near(&curr('h', &milli, &whole), &[4.4, 4.41, 4.42, 4.43, 4.44, 4.45], 1e-9);
}

#[test]
fn a_packed_file_is_read_as_what_is_in_it() {
    let truth = Truth::new("frames_packed");
    let plain = std::fs::read(&truth.csv).expect("a file");
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&plain).expect("memory");
    let packed = packed.finish().expect("memory");
    let log = read_with(&packed, &ReadOptions::default()).expect("a log");
    assert_eq!((log.rows, &log.field_ut), (truth.log.rows, &truth.log.field_ut));
    assert!(log.read_as.format.contains("gzip"));
    // Cut off: what is whole is read, and the cut is said.
    match read_with(&packed[..packed.len() / 2], &ReadOptions::default()) {
        Ok(log) => assert!(log.notices.iter().any(|notice| notice.contains("cut off")), "{:?}", log.notices),
        Err(failure) => assert!(failure.message.contains("cut off"), "{failure}"),
    }
}
