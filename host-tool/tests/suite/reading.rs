//! A calibration is one of a scale, of a mounting and of what its columns mean: CAL.json knows them, other logs are read so
//! without being told, and what differs is said.

use crate::common::{Run, folder, ironout, write};
use std::path::{Path, PathBuf};

fn run(words: &[&str], paths: &[&Path]) -> Run {
    ironout(
        words.iter().map(AsRef::<std::ffi::OsStr>::as_ref).chain(paths.iter().map(|path| path.as_os_str())),
    )
}

/// A log in counts, and the folder it is in.
fn counts() -> (PathBuf, PathBuf) {
    let here = folder("reading");
    let log = here.join("ut.csv");
    assert_eq!(run(&["simulate", "--seed", "3", "-o"], &[&log]).status, 0);
    let text = std::fs::read_to_string(&log).expect("the log");
    let mut out = String::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split(',').collect();
        let row = match cells[1].parse::<f64>() {
            Err(_) => "t_s,mx_counts,my_counts,mz_counts".to_string(),
            Ok(_) => {
                let count = |cell: &str| (cell.parse::<f64>().expect("a number") / 0.05).round().to_string();
                format!("{},{},{},{}", cells[0], count(cells[1]), count(cells[2]), count(cells[3]))
            }
        };
        out.push_str(&row);
        out.push('\n');
    }
    (write(&here, "counts.csv", out), here)
}

#[test]
fn the_scale_and_the_mounting_of_a_calibration_are_kept() {
    let (log, here) = counts();
    let cal = here.join("cal.json");
    let fit = run(&["fit", "--ut-per-count", "0.05", "--rotate", "roll180", "-o"], &[&cal, &log]);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    for command in ["apply", "check"] {
        let run_with = |more: &[&str]| {
            let words = [&[command, "--json"], more, &["--cal"]].concat();
            run(&words, &[&cal, &log])
        };
        // Told or not, it is read as the calibration's log was.
        let told = run_with(&["--rotate", "roll180", "--ut-per-count", "0.05"]);
        assert_eq!(told.status, 0, "{command}: {} {}", told.stdout, told.stderr);
        for part in [&[][..], &["--rotate", "roll180"], &["--ut-per-count", "0.05"]] {
            let part = run_with(part);
            assert_eq!((part.status, &part.stdout), (0, &told.stdout), "{command}: {}", part.stderr);
        }
        let other_scale = run_with(&["--ut-per-count", "0.06"]).error();
        let message = other_scale["message"].as_str().expect("a message").to_string();
        assert!(message.contains("stored 0.05, here 0.06"), "{message}");
        let both = run_with(&["--ut-per-count", "0.06", "--rotate", "yaw90"]).error();
        let message = both["message"].as_str().expect("a message").to_string();
        assert!(message.contains("stored --rotate=roll180, here --rotate=yaw90"), "{message}");
        assert_eq!(
            message.lines().filter(|line| line.contains("stored ")).count(),
            2,
            "line by line: {message}"
        );
        // Said to stand in body axes already: believed.
        assert_ne!(run_with(&["--rotate", "none"]).status, 2);
    }
    for command in ["fit", "diagnose"] {
        let on_top = run(&[command, "--json", "--prior"], &[&cal, &log]);
        assert_eq!(on_top.status, 0, "{command}: {} {}", on_top.stdout, on_top.stderr);
        let turned = run(&[command, "--json", "--rotate", "yaw90", "--prior"], &[&cal, &log]).error();
        assert!(turned["message"].as_str().expect("a message").contains("roll180"), "{turned}");
    }
    // A fit on top of it keeps the same reading.
    let next = here.join("next.json");
    assert_eq!(run(&["fit", "--prior"], &[cal.as_path(), &log, Path::new("-o"), &next]).status, 0);
    let of = |path: &Path| -> serde_json::Value {
        let text = std::fs::read_to_string(path).expect("the calibration");
        serde_json::from_str(&text).expect("an object")
    };
    assert_eq!(of(&next)["reading"], of(&cal)["reading"]);
    // A file of an earlier program knows neither, and one before that only these two.
    let mut value = of(&cal);
    assert_eq!(value["reading"]["ut_per_count"], serde_json::json!([0.05, 0.05, 0.05]));
    value["reading"] = serde_json::json!({"ut_per_count": [0.05, 0.05, 0.05], "rotate": ["roll180"]});
    let older = write(&here, "older.json", value.to_string());
    assert_eq!(run(&["apply", "--json", "--cal"], &[&older, &log]).status, 0);
    value.as_object_mut().expect("an object").remove("reading");
    let old = write(&here, "old.json", value.to_string());
    // Read in the sensor's axes, which are not those that it was fitted in: worse, and told.
    let unturned = run(&["apply", "--json", "--ut-per-count", "0.05", "--cal"], &[&old, &log]);
    assert_eq!((unturned.status, &unturned.json()["worse"]), (1, &serde_json::json!(true)));
    let missing = run(&["apply", "--json", "--cal"], &[&old, &log]).error();
    assert!(missing["message"].as_str().expect("a message").contains("--ut-per-count"), "{missing}");
}

#[test]
fn the_columns_of_a_calibration_are_kept() {
    let here = folder("reading_map");
    let own = here.join("own.csv");
    assert_eq!(run(&["simulate", "--seed", "5", "-o"], &[&own]).status, 0);
    let text = std::fs::read_to_string(&own).expect("the log");
    let named = |x: &str, y: &str, z: &str| {
        text.replacen("mx_ut", x, 1).replacen("my_ut", y, 1).replacen("mz_ut", z, 1)
    };
    let theirs = write(&here, "theirs.csv", named("Foo X", "Foo Y", "Foo Z"));
    let others = write(&here, "others.csv", named("Bar X", "Bar Y", "Bar Z"));
    let cal = here.join("cal.json");
    let map = "mx_ut=Foo X,my_ut=Foo Y,mz_ut=Foo Z";
    let fit = run(&["fit", "--map", map, "-o"], &[&cal, &theirs]);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    let kept: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&cal).expect("text")).expect("an object");
    assert!(kept["reading"]["map"][0].as_str().is_some_and(|map| map.contains("mx_ut=Foo X")), "{kept}");
    for command in ["apply", "check"] {
        let told = run(&[command, "--json", "--map", map, "--cal"], &[&cal, &theirs]);
        let untold = run(&[command, "--json", "--cal"], &[&cal, &theirs]);
        assert_eq!((untold.status, &untold.stdout), (0, &told.stdout), "{command}: {}", untold.stderr);
        // The names of the format need no map, and that it was not used is said.
        let own = run(&[command, "--json", "--cal"], &[&cal, &own]);
        assert_eq!(own.status, 0, "{command}: {}", own.stderr);
        assert!(own.said().contains("the file's own column names"), "{}", own.stderr);
        let other = run(&[command, "--json", "--cal"], &[&cal, &others]).error();
        let message = other["message"].as_str().expect("a message").to_string();
        assert!(message.contains("stored  --map mx_ut=Foo X") && message.contains("here  "), "{message}");
        let mapped =
            run(&[command, "--map", "mx_ut=Bar X,my_ut=Bar Y,mz_ut=Bar Z", "--cal"], &[&cal, &others]);
        assert_eq!(mapped.status, 0, "{command}: {}", mapped.stderr);
    }
}

#[test]
fn a_dash_writes_to_standard_output_and_makes_no_file() {
    let here = folder("dash");
    let ironout = |words: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_ironout"));
        let output = command.args(words).current_dir(&here).output().expect("the command starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    let (status, log, words) = ironout(&["simulate", "-o", "-", "--seed", "2"]);
    assert_eq!(status, Some(0), "{words}");
    assert_eq!(ironout(&["simulate", "-o", "log.csv", "--seed", "2"]).0, Some(0));
    assert_eq!(std::fs::read_to_string(here.join("log.csv")).expect("text"), log);
    assert!(words.contains("the truth"), "{words}");
    let (status, cal, words) = ironout(&["fit", "log.csv", "-o", "-"]);
    assert!(status == Some(0) && words.contains("ACCEPTED"), "{words}");
    assert!(serde_json::from_str::<serde_json::Value>(&cal).is_ok_and(|cal| cal["version"] == 1), "{cal}");
    std::fs::write(here.join("cal.json"), &cal).expect("a file");
    let (status, corrected, words) = ironout(&["apply", "log.csv", "--cal", "cal.json", "-o", "-"]);
    assert!(status == Some(0) && words.contains("error after"), "{words}");
    assert_eq!(corrected.lines().count(), log.lines().count());
    let (status, header, _) = ironout(&["export", "cal.json", "--as", "c", "-o", "-"]);
    assert!(status == Some(0) && header.ends_with("#endif /* IRONOUT_CALIBRATION_H */\n"), "{header}");
    assert!(!header.contains("Besides it needs"), "{header}");
    let (status, error, _) = ironout(&["fit", "log.csv", "-o", "-", "--json"]);
    assert!(status == Some(2) && error.contains("--json"), "{error}");
    assert!(!here.join("-").exists());
}

#[test]
fn what_a_diagnosis_names_a_fit_takes_whatever_the_column_is_called() {
    let here = folder("called");
    let log = here.join("log.csv");
    let simulated = run(&["simulate", "--seed", "4", "--effect", "offset:current_a=3", "-o"], &[&log]);
    assert_eq!(simulated.status, 0, "{}", simulated.stderr);
    let text = std::fs::read_to_string(&log).expect("the log");
    let rows: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    for (header, name) in
        [("Motor Current [A]", "motor_current_a"), ("x^2", "x_2"), ("courant du moteur numéro trois (A)", "")]
    {
        let log = write(&here, "called.csv", rows.join("\n").replacen("current_a", header, 1));
        let found = run(&["diagnose", "--json"], &[&log]);
        let json = found.json();
        let id = json["steps"][1]["added"].as_str().unwrap_or_else(|| panic!("{header}: {json}"));
        assert!(id.starts_with("offset:") && id.ends_with(name), "{header}: {id}");
        let fitted = run(&["fit", "--json", "--add", id], &[&log]);
        assert_eq!(fitted.status, 0, "{header} as {id}: {}", fitted.stderr);
        assert!(run(&["diagnose"], &[&log]).said().contains(&format!("from {header}")), "it is said");
    }
}
