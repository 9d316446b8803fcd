//! A board's stream as a log, whatever happens to the cable.

use crate::board_link::support::{PATIENT, turned};
use crate::common::{folder, ironout, text};
use serde_json::{Value, json};

#[test]
fn a_board_is_recorded_through_a_pulled_cable_a_restart_and_lost_samples() {
    let here = folder("link-pulled");
    let board = turned(64);
    let (log, address) = (here.join("log.csv"), board.address());
    // By the board's clock, which runs while somebody records: the cable after ten seconds, for two seconds of the board …
    board.with(|bench| {
        bench.plan(10_000, |bench| {
            bench.pull();
            bench.board.run_ms(2_000);
            bench.board.received();
            bench.plug();
        });
        // … then a column that was not there before, then a restart, which forgets it.
        bench.plan(20_000, |bench| {
            bench.board.device.on_column("vane_deg", 31.5, 0);
        });
        bench.plan(25_000, |bench| {
            bench.pull();
            bench.board.restart();
            bench.board.run_ms(1_000);
            bench.board.received();
            bench.plug();
        });
    });
    let arguments =
        ["record", "-o", text(&log), "--seconds", "60", "--json", "--tcp", &address, "--wait", PATIENT];
    let child = std::process::Command::new(env!("CARGO_BIN_EXE_ironout"))
        .args(arguments.into_iter().chain(["--patience", PATIENT]))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the command starts");
    let output = child.wait_with_output().expect("it ends by itself");
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{stdout} {stderr}");
    assert!(stderr.contains("waiting for it") && stderr.contains("the board is back"), "{stderr}");
    let object: Value = serde_json::from_str(stdout.trim()).expect("one object");
    assert_eq!((&object["reconnections"], &object["restarts"]), (&json!(2), &json!(1)), "{object}");
    // Two seconds at 50 samples a second, and those that were on the wire when it was pulled.
    let lost = object["lost"].as_u64().expect("a number");
    assert!((100..=400).contains(&lost), "{object}");
    assert_eq!(
        object["columns"].as_array().and_then(|names| names.last()),
        Some(&json!("vane_deg")),
        "{object}"
    );
    let content = std::fs::read_to_string(&log).expect("the log");
    let told = content.lines().filter(|line| line.ends_with(",31.5")).count();
    // Less what was on the wire when the cable was pulled.
    assert!((100..=250).contains(&told), "{told} rows with the column, of five seconds");
    assert!(
        content.contains(&format!("# lost {lost} samples")) && content.contains("# the board restarted"),
        "{object}"
    );
    let fitted = ironout(["fit", text(&log), "--json"]);
    assert_eq!(fitted.status, 0, "{} {}", fitted.stdout, fitted.stderr);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_with_a_whole_log() {
    let here = folder("link-interrupt");
    let board = turned(65);
    let (log, address) = (here.join("log.csv"), board.address());
    let child = std::process::Command::new(env!("CARGO_BIN_EXE_ironout"))
        .args(["record", "-o", text(&log), "--tcp", &address, "--wait", PATIENT])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the command starts");
    // Rows have come: whoever writes them listens to Ctrl-C.
    let rows = here.join(format!(".log.csv.{}.rows", child.id()));
    while std::fs::metadata(&rows).map_or(0, |metadata| metadata.len()) < 40_000 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("kill").success());
    let output = child.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said} {}", String::from_utf8_lossy(&output.stderr));
    let content = std::fs::read_to_string(&log).expect("the log");
    assert!(content.ends_with('\n') && content.lines().count() > 400, "{said}");
    let cells: Vec<usize> =
        content.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').count()).collect();
    assert!(cells[0] >= 4 && cells.iter().all(|count| *count == cells[0]), "{cells:?}");
    let left = std::fs::read_dir(&here).expect("a folder").count();
    assert_eq!(left, 1, "nothing is left beside the log");
}
