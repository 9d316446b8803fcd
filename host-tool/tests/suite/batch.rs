//! `batch`: a fleet with three planted faults, resumed runs, files that are no logs.

use crate::common::{Run, folder, ironout, text, write};
use crate::writers::ulog::{Ulog, floats};
use ironout_simulation::{EffectSpec, World, WorldOptions};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const VEHICLES: usize = 20;
const FLIGHTS: usize = 6;
const DRIFTS: usize = 3;
const CURRENT: usize = 5;
const SWAPPED: usize = 11;
/// Flights with the first sensor of the vehicle whose sensor is swapped.
const BEFORE_SWAP: usize = 3;
/// Slope of the drifting offset along x; flights are two days apart.
const DRIFT_UT_PER_DAY: f64 = 0.25;

/// One flight of one vehicle.
fn flight(vehicle: usize, flight: usize) -> String {
    let replaced = vehicle == SWAPPED && flight >= BEFORE_SWAP;
    let effects = if vehicle == CURRENT { vec!["offset:current_a=5"] } else { Vec::new() };
    let world = World::new(WorldOptions {
        seed: if replaced { 500 } else { vehicle as u64 + 1 },
        seconds: 30.0,
        effects: effects.iter().map(|text| EffectSpec::parse(text).expect("an effect")).collect(),
        drop_columns: vec!["heading_deg".into()],
        ..WorldOptions::default()
    });
    let mut log = world.recording(flight as u64 + 1).run();
    if vehicle == DRIFTS {
        let x = log.position("mx_ut").expect("the field");
        log.columns[x].iter_mut().for_each(|value| *value += DRIFT_UT_PER_DAY * 2.0 * flight as f64);
    }
    let mut csv = Vec::new();
    log.write_csv(&mut csv, "a flight").expect("into memory");
    String::from_utf8(csv).expect("text")
}

/// A folder per vehicle.
fn fleet(here: &Path) -> PathBuf {
    let logs = here.join("logs");
    for vehicle in 0..VEHICLES {
        let own = logs.join(format!("v{vehicle:02}"));
        std::fs::create_dir_all(&own).expect("a folder");
        for number in 0..FLIGHTS {
            write(&own, &format!("2026-03-{:02}_101500.csv", 1 + 2 * number), flight(vehicle, number));
        }
    }
    logs
}

fn batch(logs: &Path, table: &Path, more: &[&str]) -> Run {
    ironout(["batch", text(logs), "-o", text(table)].iter().chain(more))
}

fn rows(table: &Path) -> Vec<Value> {
    let lines = std::fs::read_to_string(table).expect("a table");
    lines.lines().map(|line| serde_json::from_str(line).expect("an object")).collect()
}

#[test]
fn the_summary_finds_three_planted_faults_and_no_other() {
    let here = folder("batch_fleet");
    let (logs, table) = (fleet(&here), here.join("fleet.jsonl"));
    write(&logs.join("v00"), "broken.csv", "t_s,mx_ut\n0,1\n");
    write(&logs, "readme.md", "no log");
    let run = batch(&logs, &table, &["--json"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let object = run.json();
    assert_eq!(
        (object["logs"].as_u64(), object["failed"].as_u64()),
        (Some((VEHICLES * FLIGHTS) as u64 + 1), Some(1))
    );
    let summary = &object["summary"];
    let apart = summary["effects_apart"].as_array().expect("a list");
    assert_eq!(apart.len(), 1, "{apart:?}");
    assert_eq!((&apart[0]["vehicle"], &apart[0]["effect"]), (&"v05".into(), &"offset:current_a".into()));
    for sensor in summary["sensors"].as_array().expect("a list") {
        let (vehicle, drift, change) =
            (sensor["vehicle"].as_str().expect("a name"), &sensor["drift"], &sensor["change"]);
        match vehicle {
            "v03" => {
                let (slope, std) = (drift["ut_per_day"][0].as_f64(), drift["std_ut_per_day"][0].as_f64());
                let off = slope.expect("a slope") - DRIFT_UT_PER_DAY;
                assert!(off.abs() < 0.02 && std.expect("an error") < 0.01, "{drift}");
            }
            "v11" => {
                assert_eq!(change["gains_changed"], true, "{change}");
                let from = change["from_log"].as_str().expect("a log");
                assert!(from.ends_with("2026-03-07_101500.csv"), "{from}");
            }
            _ => assert!(drift.is_null() && change.is_null(), "{sensor}"),
        }
    }
    // A row per log in the order of their paths; the broken one with the words of the reader.
    let rows = rows(&table);
    assert_eq!(rows.len(), VEHICLES * FLIGHTS + 1);
    let broken = rows.iter().find(|row| row["verdict"] == "error").expect("the broken one");
    assert!(broken["error"].as_str().expect("words").contains("broken.csv:1"), "{broken}");
    assert_eq!((&broken["vehicle"], &broken["offset_ut"]), (&"v00".into(), &Value::Null));
    assert_eq!((&rows[0]["start"], &rows[0]["start_from"]), (&"2026-03-01T10:15:00Z".into(), &"name".into()));

    // The same digits as of the log by itself.
    let alone = ironout(["fit", rows[0]["log"].as_str().expect("a path"), "--json"]).json();
    assert_eq!(rows[0]["offset_ut"], alone["offset_ut"]);
    assert_eq!(rows[0]["base_rms_ut"], alone["rms_ut"]);

    // In words the same is found, without a study of what has not changed.
    let page = here.join("fleet.html");
    let words = batch(&logs, &table, &["--page", text(&page)]);
    assert!(words.stderr.contains("121 of 121 logs were studied before"), "{}", words.stderr);
    for found in [
        "v05: offset:current_a in 6 of 6 logs, in 0 of 114 logs of the other vehicles",
        "v03: drifts by +0.2",
        "v11: offset changed by",
        "another sensor or mounting",
    ] {
        assert!(words.stdout.contains(found), "{found}: {}", words.stdout);
    }
    // So on the page, with a chart for each sensor.
    let html = std::fs::read_to_string(&page).expect("a page");
    assert_eq!(html.matches("<svg").count(), VEHICLES);
    assert!(
        html.contains("v03: drifts by +0.2")
            && html.contains("another sensor or mounting")
            && !html.contains("NaN")
    );
}

#[test]
fn only_what_changed_is_studied_again() {
    let here = folder("batch_again");
    let logs = here.join("logs");
    std::fs::create_dir_all(&logs).expect("a folder");
    for number in 0..3 {
        let origin = "# vehicle: A7\n# sensor: m1\n# start: 2026-05-01T08:00:00+02:00\n";
        write(&logs, &format!("{number}.csv"), origin.to_string() + &flight(0, number));
    }
    let table = here.join("table.csv");
    let studied =
        |more: &[&str]| batch(&logs, &table, &[&["--json"], more].concat()).json()["studied"].as_u64();
    assert_eq!(studied(&[]), Some(3));
    let csv = std::fs::read_to_string(&table).expect("a table");
    assert!(csv.lines().nth(1).expect("a row").contains("0.csv,A7,m1,2026-05-01T06:00:00Z,log,"), "{csv}");
    assert_eq!(studied(&[]), Some(0));
    write(&logs, "1.csv", flight(1, 1));
    write(&logs, "3.csv", flight(1, 2));
    assert_eq!(studied(&[]), Some(2));
    // Other options give other rows; a line that was cut off counts as not written.
    assert_eq!(studied(&["--field", "50"]), Some(4));
    let state = here.join("table.csv.state");
    let lines = std::fs::read_to_string(&state).expect("a state");
    std::fs::write(&state, &lines[..lines.len() - 40]).expect("cut off");
    assert_eq!(studied(&["--field", "50"]), Some(1));
    assert_eq!(studied(&["--field", "50", "--again"]), Some(4));
    // Another version of the program may say something else.
    let lines = std::fs::read_to_string(&state).expect("a state");
    let version = format!("\"program\":\"{}\"", env!("CARGO_PKG_VERSION"));
    std::fs::write(&state, lines.replacen(&version, "\"program\":\"0.0.1\"", 2)).expect("a state");
    assert_eq!(studied(&["--field", "50"]), Some(2));
    // A pattern finds the same logs.
    let pattern = logs.join("?.csv");
    let run = batch(&pattern, &here.join("other.csv"), &["--json", "--vehicle-from", "{vehicle}.csv"]);
    let vehicles = run.json()["summary"]["vehicles"].as_u64();
    // Several folders, as a shell expands a pattern, name the vehicles as the folder above them does.
    let folders = ["u1", "u2"].map(|name| here.join("fleet").join(name));
    for own in &folders {
        std::fs::create_dir_all(own).expect("a folder");
        write(own, "a.csv", flight(1, 1));
    }
    let table = here.join("expanded.jsonl");
    let run = ironout(["batch", text(&folders[0]), text(&folders[1]), "-o", text(&table)]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let named: Vec<Value> = rows(&table).iter().map(|row| row["vehicle"].clone()).collect();
    assert_eq!(named, ["u1", "u2"]);
    assert_eq!(vehicles, Some(3), "A7 by two logs themselves, 1 and 3 by their names: {}", run.stdout);
}

#[test]
fn a_ulog_names_its_vehicle_and_sensor() {
    let here = folder("batch_ulog");
    let mut file = Ulog::new(1_000_000);
    file.info("sys_uuid", "0001000000003236");
    file.format(
        "sensor_mag:uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;",
    );
    file.subscribe(0, 1, "sensor_mag");
    for i in 0..600_u64 {
        let (tilt, turn) = (i as f64 * 0.013, i as f64 * 0.11);
        let field =
            [tilt.cos() * turn.cos(), tilt.cos() * turn.sin(), tilt.sin()].map(|part| 0.5 * part + 0.1);
        let time = (1_000_000 + 20_000 * i).to_le_bytes();
        file.data(1, &[&time, &time, &396_825_u32.to_le_bytes(), &floats(field)]);
    }
    let day = here.join("2026-03-01");
    std::fs::create_dir_all(&day).expect("a folder");
    write(&day, "10_11_12.ulg", &file.bytes);
    let table = here.join("table.jsonl");
    let run = batch(&day, &table, &["--json"]);
    let row = rows(&table).remove(0);
    assert_eq!(
        (&row["vehicle"], &row["sensor"]),
        (&"0001000000003236".into(), &"396825".into()),
        "{row} {}",
        run.stderr
    );
    assert_eq!(row["start"], "2026-03-01T10:11:12Z");
}

#[test]
fn what_cannot_be_is_refused_with_a_remedy() {
    let here = folder("batch_refused");
    let log = write(&here, "a.csv", flight(0, 0));
    for (arguments, words) in [
        (vec!["no-such-folder", "-o", "t.csv"], "no such file or folder"),
        (vec![text(&log), "-o", "-"], "name a file"),
        (vec![text(&log), "-o", "t.csv", "--vehicle-from", "{ship}/*"], "--vehicle-from"),
        (vec![text(&log), "-o", "t.csv", "--field", "-3"], "--field"),
    ] {
        let error = ironout(["batch", "--json"].into_iter().chain(arguments)).error();
        assert!(error["message"].as_str().expect("words").contains(words), "{error}");
    }
    // The table is no log, though it lies among them.
    let table = here.join("table.csv");
    for _ in 0..2 {
        assert_eq!(batch(&here, &table, &["--json"]).json()["logs"], 1);
    }
}

#[cfg(unix)]
#[test]
fn after_an_interrupt_the_rest_is_studied() {
    let here = folder("batch_interrupt");
    let logs = here.join("logs");
    std::fs::create_dir_all(&logs).expect("a folder");
    let one = flight(0, 0);
    (0..40).for_each(|number| drop(write(&logs, &format!("{number:02}.csv"), &one)));
    let table = here.join("table.jsonl");
    let mut child = Command::new(env!("CARGO_BIN_EXE_ironout"))
        .args(["batch", text(&logs), "-o", text(&table), "--jobs", "1"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command starts");
    // As soon as the first rows are kept.
    let kept =
        || std::fs::read_to_string(here.join("table.jsonl.state")).map_or(0, |text| text.lines().count());
    let began = Instant::now();
    while kept() < 3 && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let interrupted = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(interrupted.success());
    assert_eq!(child.wait().expect("it ends").code(), Some(1));
    let done = rows(&table).len();
    assert!((3..40).contains(&done), "{done}");
    let rest = batch(&logs, &table, &["--json"]).json();
    assert_eq!((rest["studied"].as_u64(), rest["done"].as_u64()), (Some(40 - done as u64), Some(40)));
    assert_eq!(rows(&table).len(), 40);
}
