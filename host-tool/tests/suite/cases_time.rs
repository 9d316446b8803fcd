//! Clocks as loggers write them: shared by several rows, in two columns, with months by their names; and no chain of remedies ends in a
//! dead end.

use crate::common::{case, folder, ironout, text, write};
use std::path::Path;

/// Seconds from the first row to the last, and the rows.
fn span(log: &Path, options: &[&str]) -> (Option<f64>, usize) {
    let here =
        folder(&format!("cases_time_{}", log.file_stem().and_then(|name| name.to_str()).unwrap_or_default()));
    let out = here.join("own.csv");
    let run = ironout(["import", text(log), "-o", text(&out)].iter().chain(options));
    assert_eq!(run.status, 0, "{}: {}", log.display(), run.stderr);
    let content = std::fs::read_to_string(&out).expect("written");
    let mut rows = content.lines().filter(|line| !line.starts_with('#'));
    let header = rows.next().expect("a header");
    let first: Vec<f64> =
        rows.map(|row| row.split(',').next().and_then(|cell| cell.parse().ok()).expect("a number")).collect();
    let timed = header.starts_with("t_s,");
    assert!(!timed || first.is_sorted(), "{}", log.display());
    (timed.then(|| first.last().expect("rows") - first.first().expect("rows")), first.len())
}

#[test]
fn clocks_have_their_step() {
    for (name, step_s) in [
        ("t1_clock_whole_seconds.txt", 0.125),
        ("t2_time_of_three_digits.csv", 0.25),
        ("t3_seconds_and_milliseconds.csv", 0.4),
        ("t4_month_by_name.csv", 0.015),
        ("t5_two_times_disagree.csv", 45.5),
    ] {
        let Some(log) = case(name) else { return };
        let (seconds, rows) = span(&log, &[]);
        let found = seconds.expect("a time") / (rows - 1) as f64;
        assert!((found / step_s - 1.0).abs() < 0.01, "{name}: {found} s per row");
    }
}

#[test]
fn seconds_and_nanoseconds_are_one_time_and_no_cause() {
    let Some(log) = case("15_ros2_echo_drift.txt") else { return };
    let run = ironout(["diagnose", text(&log), "--json"]);
    let json = run.json();
    let added: Vec<&str> =
        json["steps"].as_array().expect("steps").iter().filter_map(|step| step["added"].as_str()).collect();
    assert_eq!(added, ["drift"], "{}", run.stdout);
    let run = ironout(["diagnose", text(&log)]);
    assert!(!(run.stdout + &run.stderr).contains("offset:sec"));
}

/// Rows of a sensor that turns over the whole sphere, the readings in microtesla and a time written as it comes.
fn log(here: &Path, name: &str, header: &str, row: impl Fn(usize) -> String) -> std::path::PathBuf {
    let mut content = if header.is_empty() { String::new() } else { format!("{header}\n") };
    for i in 0..240 {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / 240.0;
        let (r, turn) = ((1.0 - z * z).sqrt(), i as f64 * 0.31);
        let [x, y, z] = [48.0 * r * turn.cos() + 9.0, 48.0 * r * turn.sin() - 12.0, 48.0 * z + 5.0];
        content.push_str(&row(i).replace("{m}", &format!("{x:.3},{y:.3},{z:.3}")));
        content.push('\n');
    }
    write(here, name, content)
}

/// The options that a question prints, one set a line.
fn remedies(stderr: &str) -> Vec<Vec<String>> {
    let lines = stderr.lines().map(str::trim).filter(|line| line.starts_with("--map"));
    let words = |line: &str| {
        let value = line.trim_start_matches("--map").trim();
        let (quoted, rest) = match value.strip_prefix('\'').and_then(|inner| inner.split_once('\'')) {
            Some((inner, rest)) => (inner.to_string(), rest),
            None => {
                value.split_once(' ').map_or((value.to_string(), ""), |(map, rest)| (map.to_string(), rest))
            }
        };
        let rest = rest
            .split_once("   (")
            .map_or(rest, |(rest, _)| rest)
            .replace("--ut-per-count UT", "--ut-per-count 1");
        ["--map".to_string(), quoted].into_iter().chain(rest.split_whitespace().map(String::from)).collect()
    };
    lines.map(words).collect()
}

#[test]
fn every_remedy_of_every_question_about_time_leads_to_a_read_log() {
    let here = folder("cases_time_questions");
    let mut logs = Vec::new();
    for (step, digits) in [
        (1.0, 0),
        (2.0, 0),
        (1000.0, 0),
        (45.0, 0),
        (45.5, 3),
        (700.0, 0),
        (5e4, 0),
        (1e7, 0),
        (3e-5, 9),
        (0.25, 2),
    ] {
        for (kind, header) in [
            ("time", "time,mx,my,mz"),
            ("timestamps", "timestamps,mx,my,mz"),
            ("none", ""),
            ("t_s", "t_s,mx_ut,my_ut,mz_ut"),
        ] {
            let name = format!("step_{step}_{kind}.csv");
            logs.push(log(&here, &name, header, |i| format!("{:.digits$},{{m}}", 100.0 + step * i as f64)));
        }
    }
    logs.push(log(&here, "shared.csv", "time,mx,my,mz", |i| format!("{},{{m}}", 100 + i / 2)));
    logs.push(log(&here, "backward.csv", "time,mx,my,mz", |i| format!("{}.5,{{m}}", (i * 7) % 240)));
    logs.push(log(&here, "parts.csv", "sec,msec,mx,my,mz", |i| format!("{},{},{{m}}", i / 4, (i % 4) * 250)));
    logs.push(log(&here, "parts_wrong.csv", "sec,nsec,mx,my,mz", |i| {
        format!("{},{},{{m}}", i, (i * 7919) % 1000)
    }));
    logs.push(log(&here, "two.csv", "millis,unix_time,mx,my,mz", |i| {
        format!("{},{},{{m}}", 20 * i, 1_700_000_000 + i / 50)
    }));
    logs.push(log(&here, "minutes.csv", "", |i| format!("{},{},{{m}}", (50 + i / 2) % 60, (i % 2) * 500)));
    let (mut asked, mut tried) = (0, 0);
    for path in &logs {
        let run = ironout(["fit", text(path)]);
        let mut open = vec![(Vec::<String>::new(), run)];
        for depth in 0..3 {
            let mut next = Vec::new();
            for (options, run) in open.drain(..).filter(|(_, run)| run.status == 2) {
                asked += 1;
                let found = remedies(&run.stderr);
                assert!(
                    !found.is_empty() && depth < 2,
                    "{} {options:?}: a dead end: {}",
                    path.display(),
                    run.stderr
                );
                for remedy in found {
                    tried += 1;
                    let again = ironout(["fit".to_string(), text(path).into()].iter().chain(&remedy));
                    // One remedy is enough where time was the question.
                    assert!(
                        again.status != 2 || !remedy[1].contains("t_s"),
                        "{} {remedy:?}: {}",
                        path.display(),
                        again.stderr
                    );
                    next.push((remedy, again));
                }
            }
            open = next;
        }
    }
    println!("{} logs, {asked} questions, {tried} remedies tried", logs.len());
    assert!(asked > 3);
}

#[test]
fn what_cannot_be_a_time_is_said_and_the_log_is_read_without() {
    let here = folder("cases_time_without");
    for (name, told, row) in [
        (
            "backward.csv",
            "it decreases in",
            Box::new(|i: usize| format!("{}.5,{{m}}", (i * 7) % 240)) as Box<dyn Fn(usize) -> String>,
        ),
        (
            "slow.csv",
            "reads the log without time",
            Box::new(|i: usize| format!("{},{{m}}", 1e13 + 1e13 * i as f64)),
        ),
    ] {
        let path = log(&here, name, "time,mx,my,mz", row);
        let run = ironout(["fit", text(&path)]);
        assert!(run.status < 2 && run.said().contains("without time"), "{name}: {}", run.stderr);
        assert!(
            run.stderr.split_whitespace().collect::<Vec<_>>().join(" ").contains(told),
            "{name}: {}",
            run.stderr
        );
        assert_eq!(span(&path, &[]).0, None);
    }
}
