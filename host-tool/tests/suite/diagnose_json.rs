//! `diagnose --json`: every key of the contract with its type, for each verdict; exit statuses; bad input.

use crate::common::{Run, folder, ironout, write};
use ironout_simulation::{Motion, World, WorldOptions};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn simulated(name: &str, arguments: &[&str]) -> PathBuf {
    let log = folder(name).join("log.csv");
    let path = log.to_str().expect("a path of text");
    let run = ironout(["simulate", "-o", path, "--seconds", "80", "--rate", "50"].iter().chain(arguments));
    assert_eq!(run.status, 0, "{}", run.stderr);
    log
}

fn diagnose(log: &Path, options: &[&str]) -> Run {
    let path = log.to_str().expect("a path of text");
    ironout(["diagnose", path, "--json"].iter().chain(options))
}

fn number_or_null(value: &Value) -> bool {
    value.is_null() || value.as_f64().is_some_and(f64::is_finite)
}

/// Checks the whole object against the contract; gives it back with the exit status.
fn checked(run: &Run) -> Value {
    let object = run.json();
    let verdict = object["verdict"].as_str().expect("a verdict");
    assert!(["complete", "missing", "confounded", "unexplained", "undetermined"].contains(&verdict));
    assert_eq!(run.status, i32::from(verdict == "undetermined"), "{verdict}");
    for key in ["noise_floor_ut", "residual_floor_ut"] {
        assert!(number_or_null(&object[key]) && object.get(key).is_some(), "{key}");
    }

    let steps = object["steps"].as_array().expect("steps");
    for (index, step) in steps.iter().enumerate() {
        assert_eq!(step["added"].is_null(), index == 0, "the base model first: {step}");
        assert!(step["added"].is_null() || step["added"].is_string());
        for key in ["rms_ut", "holdout_rms_ut", "dip_rms_deg"] {
            assert!(step.get(key).is_some_and(number_or_null), "{key} of {step}");
        }
    }

    let candidates = object["candidates"].as_array().expect("candidates");
    let mut ids: Vec<&str> = Vec::new();
    for candidate in candidates {
        let id = candidate["id"].as_str().expect("an id");
        assert!(!ids.contains(&id), "{id} twice");
        ids.push(id);
        assert!(candidate["name"].as_str().is_some_and(|name| !name.is_empty()));
        let status = candidate["status"].as_str().expect("a status");
        assert!(["missing", "not-needed", "confounded", "untestable"].contains(&status), "{status}");
        let residual = candidate["residual"].as_str().expect("a residual");
        assert!(["magnitude", "dip", "vector"].contains(&residual), "{residual}");
        for key in ["holdout_rms_ut", "p_value"] {
            assert!(candidate.get(key).is_some_and(number_or_null), "{key} of {id}");
        }
        if let Some(p) = candidate["p_value"].as_f64() {
            assert!((0.0..=1.0).contains(&p), "{id}: {p}");
        }
        let others = candidate["confounded_with"].as_array().expect("a list");
        assert!(others.iter().all(Value::is_string));
        assert_eq!(status == "confounded", !others.is_empty(), "{candidate}");
        assert!(candidate["why"].as_str().is_some_and(|why| !why.is_empty()), "{candidate}");
        if status == "missing" && id != "misalignment" {
            assert!(steps.iter().any(|step| step["added"] == id), "{id} is missing but in no step");
        }
    }
    for added in steps.iter().filter_map(|step| step["added"].as_str()) {
        assert!(added != "misalignment");
        let row = candidates.iter().find(|row| row["id"] == added).expect("a candidate for each step");
        assert_eq!(row["status"], "missing", "{added}");
    }
    assert_eq!(verdict == "missing", verdict == "missing" && steps.len() >= 2);

    for fault in object["data_faults"].as_array().expect("data_faults") {
        let kind = fault["kind"].as_str().expect("a kind");
        assert!(["clipping", "burst", "stuck", "gap", "copied-axis"].contains(&kind), "{kind}");
        assert!(number_or_null(&fault["from_s"]) && number_or_null(&fault["to_s"]));
        assert!(fault["samples"].as_u64().is_some());
        assert!(fault["columns"].as_array().is_some_and(|names| names.iter().all(Value::is_string)));
    }
    for shown in object["where"].as_array().expect("where") {
        assert!(shown["against"].is_string());
        assert!(number_or_null(&shown["explained"]) && number_or_null(&shown["p_value"]));
        if let Some(share) = shown["explained"].as_f64() {
            assert!((0.0..=1.0).contains(&share), "{shown}");
        }
    }
    for (group, keys) in [
        ("dip", &["rms_deg_before", "rms_deg_after", "misalignment_deg"][..]),
        ("heading", &["rms_deg_before", "rms_deg_after"]),
    ] {
        let value = object.get(group).expect(group);
        if !value.is_null() {
            keys.iter().for_each(|key| assert!(value.get(key).is_some_and(number_or_null), "{group} {key}"));
        }
    }
    object
}

fn status_of<'a>(object: &'a Value, id: &str) -> &'a str {
    let row = object["candidates"].as_array().and_then(|list| list.iter().find(|row| row["id"] == id));
    row.and_then(|row| row["status"].as_str()).unwrap_or("absent")
}

#[test]
fn complete() {
    let object = checked(&diagnose(&simulated("json_complete", &["--seed", "1"]), &[]));
    assert_eq!(object["verdict"], "complete");
    assert_eq!(object["steps"].as_array().map(Vec::len), Some(1));
    assert!(object["dip"]["rms_deg_after"].as_f64() < object["dip"]["rms_deg_before"].as_f64());
    assert!(object["heading"]["rms_deg_after"].is_f64());
}

#[test]
fn missing() {
    let log = simulated("json_missing", &["--seed", "2", "--effect", "offset:current_a=3"]);
    let object = checked(&diagnose(&log, &[]));
    assert_eq!(object["verdict"], "missing");
    assert_eq!(object["steps"][1]["added"], "offset:current_a");
    let (floor, held) = (&object["residual_floor_ut"], &object["steps"][1]["holdout_rms_ut"]);
    assert!(held.as_f64().expect("known") < 1.05 * floor.as_f64().expect("known"), "{held} {floor}");
    let effect = &object["effects"][0];
    assert_eq!(effect["id"], "offset:current_a");
    assert_eq!(effect["coefficients"].as_array().map(Vec::len), Some(3));
    assert_eq!(effect["std_errors"].as_array().map(Vec::len), Some(3));
    assert!(effect["reference"]["current_a"].is_f64());
}

#[test]
fn confounded() {
    let log = simulated("json_confounded", &["--seed", "13", "--effect", "offset:temp_c=3", "--ramp"]);
    let object = checked(&diagnose(&log, &[]));
    assert_eq!(object["verdict"], "confounded");
    assert_eq!(status_of(&object, "offset:temp_c"), "confounded");
    assert_eq!(status_of(&object, "drift"), "confounded");
}

#[test]
fn unexplained() {
    let hidden = ["--seed", "15", "--effect", "offset:temp_c=3", "--without", "temp_c"];
    let object = checked(&diagnose(&simulated("json_unexplained", &hidden), &[]));
    // The column is gone: nothing else is blamed with certainty, and the way to test it is named.
    assert!(["unexplained", "confounded", "missing"].contains(&object["verdict"].as_str().expect("text")));
    if object["verdict"] == "missing" {
        let added: Vec<&Value> =
            object["steps"].as_array().expect("steps").iter().skip(1).map(|step| &step["added"]).collect();
        assert_eq!(added, ["drift"], "the only honest proxy of a warm-up");
    }
    assert_eq!(status_of(&object, "offset:temp_c"), "untestable");
}

#[test]
fn undetermined() {
    let world = World::new(WorldOptions { seed: 5, motion: Motion::Planar, ..WorldOptions::default() });
    let path = folder("json_undetermined").join("planar.csv");
    let file = std::fs::File::create(&path).expect("a file");
    world.run().write_csv(file, "planar").expect("written");
    let run = diagnose(&path, &[]);
    let object = checked(&run);
    assert_eq!((run.status, &object["verdict"]), (1, &Value::from("undetermined")));
    assert!(
        object["reasons"][0].as_str().is_some_and(|reason| reason.contains("Record again with large tilts")),
        "{object}"
    );
}

#[test]
fn columns_that_cannot_be_tested_have_their_reason() {
    let log = simulated("json_untestable", &["--seed", "4"]);
    let text = std::fs::read_to_string(&log).expect("the log");
    let mut out = String::new();
    for (row, line) in text.lines().filter(|line| !line.starts_with('#')).enumerate() {
        out.push_str(line);
        out.push_str(match row {
            0 => ",steady_c,broken_a\n",
            7 => ",21.5,NaN\n",
            _ => ",21.5,3.25\n",
        });
    }
    let folder = folder("json_untestable_columns");
    let object = checked(&diagnose(&write(&folder, "log.csv", out), &[]));
    for (id, reason) in
        [("offset:steady_c", "constant"), ("gain:steady_c", "constant"), ("offset:broken_a", "NaN")]
    {
        let row = object["candidates"].as_array().and_then(|list| list.iter().find(|row| row["id"] == id));
        let row = row.unwrap_or_else(|| panic!("no {id}"));
        assert_eq!(row["status"], "untestable", "{row}");
        assert!(row["why"].as_str().is_some_and(|why| why.contains(reason)), "{row}");
    }
}

#[test]
fn an_unknown_effect_is_named_and_the_known_ones_are_listed() {
    let log = simulated("json_unknown", &["--seed", "4"]);
    let error = diagnose(&log, &["--add", "wobble"]).error();
    let message = error["message"].as_str().expect("text");
    for part in ["--add wobble", "unknown effect", "ironout effects LOG"] {
        assert!(message.contains(part), "no {part} in: {message}");
    }
    let error = diagnose(&log, &["--add", "temp"]).error();
    assert!(error["message"].to_string().contains("Did you mean offset:temp_c"), "{error}");
    let listed = ironout(["effects", log.to_str().expect("a path of text")]).stdout;
    for known in ["offset:temp_c", "gain:temp_c", "drift", "step", "nonlinearity", "periodic", "lag"] {
        assert!(listed.contains(known), "no {known} in: {listed}");
    }
}

#[test]
fn an_effect_whose_column_is_not_there_says_so() {
    let log = simulated("json_absent", &["--seed", "4", "--without", "temp_c"]);
    let error = diagnose(&log, &["--add", "offset:temp_c"]).error();
    assert!(error["message"].as_str().is_some_and(|text| text.contains("temp_c")), "{error}");
}

#[test]
fn an_effect_given_is_in_the_model_and_not_searched_again() {
    let log = simulated("json_given", &["--seed", "2", "--effect", "offset:current_a=3"]);
    let object = checked(&diagnose(&log, &["--add", "offset:current_a"]));
    let added: Vec<&str> = object["steps"]
        .as_array()
        .expect("steps")
        .iter()
        .filter_map(|step| step["added"].as_str())
        .filter(|id| *id == "offset:current_a")
        .collect();
    assert!(added.len() <= 1, "{object}");
    let last = object["steps"].as_array().and_then(|steps| steps.last()).expect("a step");
    assert!(last["rms_ut"].as_f64().expect("known") < 0.3, "{last}");
}

#[test]
fn a_log_too_short_or_at_rest_is_undetermined_without_a_crash() {
    let folder = folder("json_short");
    let short = write(&folder, "short.csv", "t_s,mx_ut,my_ut,mz_ut\n0,1,2,3\n1,2,3,4\n");
    assert_eq!(checked(&diagnose(&short, &[]))["verdict"], "undetermined");
    let rest: String =
        (0..500).map(|i| format!("{},20.1,-3.2,40.{}\n", f64::from(i) * 0.02, i % 3)).collect();
    let rest = write(&folder, "rest.csv", format!("t_s,mx_ut,my_ut,mz_ut\n{rest}"));
    checked(&diagnose(&rest, &[]));
}

#[test]
fn bad_input_is_named_with_its_place() {
    let folder = folder("json_bad");
    let text = write(&folder, "text.csv", "t_s,mx_ut,my_ut,mz_ut\n0,1,2,3\n1,2,oops,4\n");
    let error = diagnose(&text, &[]).error();
    assert_eq!((&error["line"], &error["column"]), (&Value::from(3), &Value::from("my_ut")));
    let error = diagnose(&folder.join("none.csv"), &[]).error();
    assert!(error["file"].as_str().is_some_and(|file| file.ends_with("none.csv")), "{error}");
    let no_prior = ["--prior", "no-such-cal.json"];
    let log = simulated("json_prior", &["--seed", "1"]);
    assert_eq!(diagnose(&log, &no_prior).status, 2);
}
