//! Calibrations onto a board and off it.

use crate::board_link::support::{
    HARD_IRON_UT, PATIENT, ask, cal_with_effects, calibrate, connect, on, read, turned,
};
use crate::common::{Run, folder, ironout, text, write};
use ironout_rig::board::SimBoard;
use ironout_rig::served::Served;
use serde_json::json;
use std::io::{BufRead, Read, Write};
use std::net::TcpStream;
use std::sync::{Arc, Mutex};

#[test]
fn a_calibration_sent_is_fetched_bit_for_bit_after_a_power_cut_too() {
    let here = folder("link-round-trip");
    let cal = cal_with_effects(&here);
    let board = turned(61);
    let sent = on(&board, &["send", text(&cal), "--json"]);
    assert_eq!(sent.status, 0, "{} {}", sent.stdout, sent.stderr);
    let sent = sent.json();
    assert_eq!(sent["effects"], json!(["offset:temp_c", "offset:current_a^2", "step"]));
    assert_eq!((&sent["sequence"], &sent["board"]), (&json!(1), &json!("simulated")));
    for attempt in ["at once", "after a power cut"] {
        let back = here.join("back.json");
        let fetched = on(&board, &["fetch", "-o", text(&back)]);
        assert_eq!(fetched.status, 0, "{attempt}: {}", fetched.stderr);
        assert!(fetched.stdout.contains("information is null"), "{}", fetched.stdout);
        let (cal, back) = (read(&cal), read(&back));
        for key in [
            "method",
            "samples_used",
            "field_ut",
            "offset_ut",
            "matrix",
            "rms_ut",
            "noise_floor_ut",
            "information",
        ] {
            assert_eq!(back[key], cal[key], "{attempt}: {key}");
        }
        for (back, sent) in
            back["effects"].as_array().expect("a list").iter().zip(cal["effects"].as_array().expect("a list"))
        {
            for key in ["id", "columns", "coefficients", "std_errors", "reference", "parameters", "range"] {
                assert_eq!(back[key], sent[key], "{attempt}: {} {key}", sent["id"]);
            }
        }
        board.with(|bench| {
            bench.board.restart();
            bench.board.run_ms(100);
        });
    }
    // What was fetched is sent to another board, and is the same there.
    let (other, again) = (turned(62), here.join("again.json"));
    assert_eq!(on(&other, &["send", text(&here.join("back.json"))]).status, 0);
    assert_eq!(on(&other, &["fetch", "-o", text(&again)]).status, 0);
    assert_eq!(read(&here.join("back.json")), read(&again));
}

#[test]
fn a_calibration_made_on_the_board_comes_with_its_information_and_a_log_builds_on_it() {
    let here = folder("link-information");
    let board = turned(63);
    calibrate(&board);
    let cal = here.join("board.json");
    let fetched = on(&board, &["fetch", "-o", text(&cal), "--json"]);
    assert_eq!(fetched.status, 0, "{}", fetched.stderr);
    assert_eq!(fetched.json()["information"], true);
    let log = here.join("log.csv");
    let recorded = on(&board, &["record", "-o", text(&log), "--seconds", "30", "--json"]);
    assert_eq!(recorded.status, 0, "{}", recorded.stderr);
    let recorded = recorded.json();
    assert_eq!((&recorded["lost"], &recorded["restarts"]), (&json!(0), &json!(0)));
    assert!(recorded["samples"].as_u64().is_some_and(|n| (1499..=1502).contains(&n)), "{recorded}");
    // The log is read without any option, by itself and on top of what the board knew.
    let alone = ironout(["fit", text(&log), "--json"]);
    assert_eq!(alone.status, 0, "{} {}", alone.stdout, alone.stderr);
    let both = ironout(["fit", text(&log), "--prior", text(&cal), "--json"]);
    assert_eq!(both.status, 0, "{} {}", both.stdout, both.stderr);
    let sigma = |run: &Run| run.json()["std_errors"]["offset_ut"][0].as_f64().expect("known");
    // What was known before is loosened by what a board changes between two sessions, which is more than this log leaves open.
    assert!(sigma(&both) < sigma(&alone), "{} {}", sigma(&both), sigma(&alone));
    for run in [&alone, &both] {
        for (axis, truth) in HARD_IRON_UT.iter().enumerate() {
            let offset = run.json()["offset_ut"][axis].as_f64().expect("known");
            assert!((offset - truth).abs() < 0.05, "{}", run.stdout);
        }
    }
    // A power cut takes neither the calibration nor the information: the record keeps it, in single precision.
    board.with(|bench| {
        bench.board.restart();
        bench.board.run_ms(100);
    });
    let later = here.join("later.json");
    assert_eq!(on(&board, &["fetch", "-o", text(&later)]).status, 0);
    let (first, later) = (read(&cal), read(&later));
    assert_eq!((&first["matrix"], &first["offset_ut"]), (&later["matrix"], &later["offset_ut"]));
    assert!(first["information"].is_object() && later["information"].is_object(), "{later}");
    let again = ironout(["fit", text(&log), "--prior", text(&here.join("later.json")), "--json"]);
    assert_eq!(again.status, 0, "{} {}", again.stdout, again.stderr);
    assert!((sigma(&again) / sigma(&both) - 1.0).abs() < 1e-3, "{} {}", sigma(&again), sigma(&both));
}

#[test]
fn an_effect_fitted_on_the_host_runs_on_the_board_to_the_printed_digits() {
    let here = folder("link-digits");
    let log = crate::common::simulate(
        &here,
        "hot.csv",
        &["--seed", "5", "--seconds", "120", "--effect", "offset:temp_c=8"],
    );
    let cal = here.join("cal.json");
    let fitted = ironout(["fit", text(&log), "--add", "offset:temp_c", "-o", text(&cal)]);
    assert_eq!(fitted.status, 0, "{} {}", fitted.stdout, fitted.stderr);
    // At rest in one field after the other, so that both streams see the same counts.
    let field_ut = Arc::new(Mutex::new([20.0, -10.0, 35.0]));
    let seen = Arc::clone(&field_ut);
    let board = Served::start(move || {
        let mut board = SimBoard::new(move |_| *seen.lock().expect("not poisoned"), 0.0, 5);
        board.run_ms(100);
        board
    })
    .expect("a port");
    let sent = on(&board, &["send", text(&cal)]);
    assert_eq!(sent.status, 0, "{} {}", sent.stdout, sent.stderr);
    assert!(sent.stdout.contains("offset:temp_c"), "{}", sent.stdout);
    assert!(!sent.stdout.contains("information"), "it goes along: {}", sent.stdout);
    let mut console = connect(&board);
    let scale: Vec<f64> = ask(&mut console, "version")
        .iter()
        .find_map(|line| line.strip_prefix("+ ut_per_count="))
        .expect("the scale")
        .split(',')
        .map(|word| f64::from(word.parse::<f32>().expect("a number")))
        .collect();
    // The third line of a stream: the field was there for two samples at least.
    let mut third = |command: &str| {
        ask(&mut console, command);
        let mut line = String::new();
        for _ in 0..3 {
            line.clear();
            console.read_line(&mut line).expect("a line");
        }
        ask(&mut console, "stream off");
        line.trim().split(',').skip(2).map(|word| word.parse().expect("a number")).collect::<Vec<f64>>()
    };
    let (mut rows, mut streamed) = ("t_s,mx_ut,my_ut,mz_ut,temp_c\n".to_string(), Vec::new());
    for (step, temp_c) in [12.5_f32, 25.0, 31.75, 44.0].into_iter().enumerate() {
        let turn = step as f64;
        *field_ut.lock().expect("not poisoned") = [30.0 * turn.cos(), 30.0 * turn.sin(), 40.0 - 20.0 * turn];
        third(&format!("cov temp_c={temp_c}\nstream raw"));
        let raw = third("stream raw");
        let [x, y, z] = [0, 1, 2].map(|axis| raw[axis] * scale[axis]);
        rows += &format!("{step},{x},{y},{z},{temp_c}\n");
        streamed.push(third("stream cal"));
    }
    let (rows, out) = (write(&here, "rows.csv", rows), here.join("out.csv"));
    let applied = ironout(["apply", text(&rows), "--cal", text(&cal), "-o", text(&out)]);
    // Four fields of different sizes: no calibration makes them one, and that is told.
    assert!(applied.status == 1 && applied.stdout.contains("WORSE"), "{} {}", applied.stdout, applied.stderr);
    let corrected = std::fs::read_to_string(&out).expect("a file");
    for (line, board) in corrected.lines().skip(1).zip(&streamed) {
        let host: Vec<f64> = line.split(',').skip(5).map(|word| word.parse().expect("a number")).collect();
        for (host, board) in host.iter().zip(board) {
            // The board writes three decimals, corrected in single precision.
            assert!((host - board).abs() < 0.0006 + 2e-6 * host.abs(), "{line} {board:?}");
        }
    }
    // What is compared moves with the temperature.
    assert!((streamed[0][3] - streamed[3][3]).abs() > 0.05, "{streamed:?}");
}

/// The serial port's own way, through a pseudo terminal.
#[cfg(unix)]
#[test]
fn a_serial_port_is_spoken_to_as_a_tcp_port_is() {
    use serialport::SerialPort;
    let here = folder("link-serial");
    let board = turned(68);
    calibrate(&board);
    let (mut near, far) = match serialport::TTYPort::pair() {
        Ok(pair) => pair,
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "SKIPPED: there is no pseudo terminal here ({error})");
            return;
        }
    };
    let name = far.name().expect("a name");
    near.set_timeout(std::time::Duration::from_millis(2)).expect("a time limit");
    let mut tcp = TcpStream::connect(board.address()).expect("the board");
    tcp.set_read_timeout(Some(std::time::Duration::from_millis(2))).expect("a time limit");
    let (done, ended) = std::sync::mpsc::channel::<()>();
    let bridge = std::thread::spawn(move || {
        // The far end is held open, so that the near one outlives those who open it by name.
        let _far = far;
        let mut chunk = [0; 256];
        while matches!(ended.try_recv(), Err(std::sync::mpsc::TryRecvError::Empty)) {
            if let Ok(count) = near.read(&mut chunk) {
                tcp.write_all(&chunk[..count]).expect("the board");
            }
            if let Ok(count) = tcp.read(&mut chunk) {
                near.write_all(&chunk[..count]).expect("the port");
            }
        }
    });
    let cal = here.join("cal.json");
    let run = ironout(["fetch", "-o", text(&cal), "--port", &name, "--wait", PATIENT, "--json"]);
    drop(done);
    bridge.join().expect("no panic");
    assert_eq!(run.status, 0, "{} {}", run.stdout, run.stderr);
    assert_eq!(run.json()["information"], true);
}
