//! A board on a wire: a calibration onto it and off it, its stream as a log. The board is the device on the simulated bus,
//! behind a TCP port; its clock goes by what is said to it, so that nothing here depends on how fast the machine is.

mod common;

use common::{Run, folder, ironout, text, write};
use ironout_rig::board::SimBoard;
use ironout_rig::served::Served;
use ironout_simulation::{Motion, World, WorldOptions};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

const HARD_IRON_UT: [f64; 3] = [93.0, 40.0, -70.0];
const NOISE_UT: f64 = 0.05;
/// However long an answer takes on a busy machine: a test that waits fails for another reason.
const PATIENT: &str = "600";

/// A board that is turned all the time.
fn turned(seed: u64) -> Served {
    Served::start(move || {
        let options =
            WorldOptions { seed, motion: Motion::Sphere, hard_iron_ut: Some(HARD_IRON_UT), ..WorldOptions::default() };
        let world = World::new(options);
        let mut board = SimBoard::new(move |t_s| world.sensor_ut(t_s), NOISE_UT, seed);
        board.run_ms(100);
        board
    })
    .expect("a port")
}

/// One command over a connection of its own: all the lines of the answer.
fn ask(stream: &mut BufReader<TcpStream>, command: &str) -> Vec<String> {
    stream.get_mut().write_all(format!("{command}\n").as_bytes()).expect("sent");
    let mut lines = Vec::new();
    loop {
        let mut line = String::new();
        assert_ne!(stream.read_line(&mut line).expect("text"), 0, "the board has hung up after {lines:?}");
        let line = line.trim_end().to_string();
        let last = line == "ok" || line.starts_with("ok ") || line.starts_with("err ");
        lines.push(line);
        if last {
            return lines;
        }
    }
}

fn connect(board: &Served) -> BufReader<TcpStream> {
    BufReader::new(TcpStream::connect(board.address()).expect("the board is there"))
}

/// Calibrates by the console as a person does, and accepts.
fn calibrate(board: &Served) {
    board.with(|bench| {
        for (command, run_ms) in [("cal start", 60_000), ("cal stop", 0), ("cal accept", 0)] {
            let answer = bench.board.command(command).pop().unwrap_or_default();
            assert!(answer.starts_with("ok"), "{command}: {answer}");
            bench.board.run_ms(run_ms);
        }
    });
}

/// The command with this board at its end.
fn on(board: &Served, arguments: &[&str]) -> Run {
    let address = board.address();
    ironout(arguments.iter().copied().chain(["--tcp", &address, "--wait", PATIENT]))
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("a file")).expect("JSON")
}

/// A calibration file with effects of several kinds, every number of it to the last bit.
fn cal_with_effects(here: &Path) -> PathBuf {
    let third = 1.0 / 3.0;
    let effect = |id: &str, columns: &[&str], k: usize, reference: Value, parameters: Value, range: Value| {
        json!({
            "id": id, "name": "", "columns": columns, "unit": "",
            "coefficients": (0..k).map(|i| 0.01 / (i as f64 + 3.0)).collect::<Vec<_>>(),
            // Single precision is what a board keeps of standard errors.
            "std_errors": (0..k).map(|i| f64::from(0.001_f32 / (i as f32 + 3.0))).collect::<Vec<_>>(),
            "reference": reference, "parameters": parameters, "range": range,
        })
    };
    let cal = json!({
        "version": 1, "method": "adjusted", "samples_used": 2953, "samples_set_aside": 0,
        "field_ut": 48.123456789, "offset_ut": [93.0 + third, -1e-17, -70.1],
        "matrix": [[1.01, 0.02, -0.03], [0.001, 0.97, 0.1], [-0.002, 0.0, 1.1]],
        "effects": [
            effect("offset:temp_c", &["temp_c"], 3, json!({"temp_c": 25.1 + third}), json!({}), json!({"temp_c": [10.0, 35.5]})),
            effect("offset:current_a^2", &["current_a"], 3, json!({"current_a": third}), json!({}), json!({"current_a": [-2.0, 8.25]})),
            effect("step", &["t_s"], 3, json!({}), json!({"at_s": 61.7 + third}), json!({"t_s": [0.0, 120.0]})),
        ],
        "std_errors": null, "rms_ut": 0.26 + third, "holdout_rms_ut": 0.3, "noise_floor_ut": 0.25, "residual_floor_ut": 0.2,
        "heading_error_deg": null, "coverage": 0.99, "gap_deg": 20.0, "accepted": true, "reasons": [], "information": null,
    });
    write(here, "cal.json", serde_json::to_string_pretty(&cal).expect("JSON"))
}

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
        for key in ["method", "samples_used", "field_ut", "offset_ut", "matrix", "rms_ut", "noise_floor_ut", "information"] {
            assert_eq!(back[key], cal[key], "{attempt}: {key}");
        }
        for (back, sent) in back["effects"].as_array().expect("a list").iter().zip(cal["effects"].as_array().expect("a list")) {
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
    assert!(sigma(&both) < 0.8 * sigma(&alone), "{} {}", sigma(&both), sigma(&alone));
    for run in [&alone, &both] {
        for (axis, truth) in HARD_IRON_UT.iter().enumerate() {
            let offset = run.json()["offset_ut"][axis].as_f64().expect("known");
            assert!((offset - truth).abs() < 0.05, "{}", run.stdout);
        }
    }
    // A power cut takes the information, not the calibration.
    board.with(|bench| {
        bench.board.restart();
        bench.board.run_ms(100);
    });
    let later = here.join("later.json");
    assert_eq!(on(&board, &["fetch", "-o", text(&later)]).status, 0);
    let (first, later) = (read(&cal), read(&later));
    assert_eq!((&first["matrix"], &first["offset_ut"]), (&later["matrix"], &later["offset_ut"]));
    assert!(later["information"].is_null());
    let refused = ironout(["fit", text(&log), "--prior", text(&here.join("later.json"))]);
    assert!(refused.status == 2 && refused.stderr.contains("no information"), "{}", refused.stderr);
}

#[test]
fn an_effect_fitted_on_the_host_runs_on_the_board_to_the_printed_digits() {
    let here = folder("link-digits");
    let log = common::simulate(&here, "hot.csv", &["--seed", "5", "--seconds", "120", "--effect", "offset:temp_c=8"]);
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
    assert!(sent.stdout.contains("offset:temp_c") && sent.stdout.contains("information"), "{}", sent.stdout);
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
    assert_eq!(applied.status, 0, "{}", applied.stderr);
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

#[test]
fn a_board_is_recorded_through_a_pulled_cable_a_restart_and_lost_samples() {
    let here = folder("link-pulled");
    let board = turned(64);
    let (log, address) = (here.join("log.csv"), board.address());
    let arguments = ["record", "-o", text(&log), "--seconds", "60", "--json", "--tcp", &address, "--wait", PATIENT];
    let child = std::process::Command::new(env!("CARGO_BIN_EXE_ironout"))
        .args(arguments.into_iter().chain(["--patience", PATIENT]))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the command starts");
    let samples = |board: &Served| board.with(|bench| bench.board.clock.ms()).expect("the board runs");
    // By the board's clock, which runs while somebody records: the cable after ten seconds, for two seconds of the board …
    let until = |board: &Served, ms: u64| {
        while samples(board) < ms {
            std::thread::yield_now();
        }
    };
    until(&board, 10_000);
    board.with(|bench| {
        bench.pull();
        bench.board.run_ms(2_000);
        bench.board.received();
        bench.plug();
    });
    until(&board, 20_000);
    // … then columns that were not there before, then a restart.
    board.with(|bench| {
        // Only a calibration listens to columns: any one will do.
        for command in ["cal start", "cal stop"] {
            bench.board.command(command);
        }
        bench.pull();
        bench.board.restart();
        bench.board.run_ms(1_000);
        bench.board.received();
        bench.plug();
    });
    let output = child.wait_with_output().expect("it ends by itself");
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{stdout} {stderr}");
    assert!(stderr.contains("waiting for it") && stderr.contains("the board is back"), "{stderr}");
    let object: Value = serde_json::from_str(stdout.trim()).expect("one object");
    assert_eq!((&object["reconnections"], &object["restarts"]), (&json!(2), &json!(1)), "{object}");
    // Two seconds at 50 samples a second, and those that were on the wire when it was pulled.
    let lost = object["lost"].as_u64().expect("a number");
    assert!((100..=100 + 6000).contains(&lost), "{object}");
    let content = std::fs::read_to_string(&log).expect("the log");
    assert!(content.contains(&format!("# lost {lost} samples")) && content.contains("# the board restarted"), "{object}");
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
    // It streams: whoever asked for that listens to Ctrl-C.
    while !board.with(|bench| bench.board.clock.ms() > 10_000).expect("the board runs") {
        std::thread::yield_now();
    }
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("kill").success());
    let output = child.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said} {}", String::from_utf8_lossy(&output.stderr));
    let content = std::fs::read_to_string(&log).expect("the log");
    assert!(content.ends_with('\n') && content.lines().count() > 400, "{said}");
    assert!(content.lines().filter(|line| !line.starts_with('#')).all(|line| line.split(',').count() == 4));
    let left = std::fs::read_dir(&here).expect("a folder").count();
    assert_eq!(left, 1, "nothing is left beside the log");
}

#[test]
fn what_cannot_be_sent_is_refused_before_anything_is() {
    let here = folder("link-refused");
    let board = turned(66);
    let cal = cal_with_effects(&here);
    let change = |name: &str, change: &dyn Fn(&mut Value)| {
        let mut value = read(&cal);
        change(&mut value);
        write(&here, name, value.to_string())
    };
    let five = change("five.json", &|value| {
        let one = value["effects"][0].clone();
        value["effects"] = Value::Array(vec![one; 5]);
    });
    let unknown = change("unknown.json", &|value| value["effects"][0]["id"] = json!("servo"));
    let late = change("late.json", &|value| {
        let mut one = value["effects"][0].clone();
        one["parameters"] = json!({"delay_s": 1.5});
        value["effects"] = Value::Array(
            ["a_a", "b_a", "c_a"]
                .map(|column| {
                    one["id"] = json!(format!("offset:{column}@delay"));
                    one["columns"] = json!([column]);
                    one["reference"] = json!({column: 0.5});
                    one["range"] = json!({column: [0.0, 1.0]});
                    one.clone()
                })
                .to_vec(),
        );
    });
    let rotated = change("rotated.json", &|value| {
        value["reading"] = json!({"ut_per_count": null, "rotate": ["yaw90"]});
    });
    let scaled = change("scaled.json", &|value| {
        value["reading"] = json!({"ut_per_count": [0.5, 0.5, 0.5], "rotate": []});
    });
    for (file, words) in [
        (&five, "more than 4 effects"),
        (&unknown, "there is no effect servo"),
        (&late, "act late"),
        (&rotated, "--rotate"),
        (&scaled, "counts"),
    ] {
        let run = on(&board, &["send", text(file), "--json"]);
        let message = run.error()["message"].to_string();
        assert!(message.contains(words), "{words}: {message}");
    }
    let shown = board.with(|bench| bench.board.command("cal show").pop().unwrap_or_default());
    assert!(shown.expect("it runs").starts_with("err state"), "nothing was sent");
    // A board that collects says no, and goes on collecting.
    board.with(|bench| bench.board.command("cal start"));
    let run = on(&board, &["send", text(&cal)]);
    assert!(run.status == 1 && run.stderr.contains("samples are being collected"), "{}", run.stderr);
    let none = turned(67);
    let run = on(&none, &["fetch", "-o", text(&here.join("none.json"))]);
    assert!(run.status == 1 && run.stderr.contains("there is no calibration"), "{}", run.stderr);
    assert!(!here.join("none.json").exists());
}

#[test]
fn what_is_no_board_is_told_apart() {
    let here = folder("link-no-board");
    let cal = cal_with_effects(&here);
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    // Nobody listens any more at a port that was given back.
    let gone = {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        listener.local_addr().expect("an address").to_string()
    };
    let run = ironout(["send", text(&cal), "--tcp", &gone]);
    assert!(run.status == 2 && run.stderr.contains("nothing listens there"), "{}", run.stderr);
    let run = ironout(["fetch", "-o", "x.json", "--port", "/dev/no-such-port"]);
    assert!(run.status == 2 && run.stderr.contains("cannot open the serial port /dev/no-such-port"), "{}", run.stderr);
    let run = ironout(["fetch", "-o", "x.json"]);
    assert!(run.status == 2 && run.stderr.contains("--port"), "{}", run.stderr);
    // One that says nothing, one of another speed, one of another kind: each for one connection.
    let other = std::thread::spawn(move || {
        for said in [&b""[..], b"\xf0\x80\x00\xfe\n\x80\xff\n", b"HTTP/1.1 400 Bad Request\r\n"] {
            let (mut client, _) = listener.accept().expect("a client");
            client.write_all(said).expect("said");
            // Until it gives up.
            let _ = client.read_to_end(&mut Vec::new());
        }
    });
    for words in ["nothing has answered", "no text", "HTTP/1.1 400"] {
        let run = ironout(["send", text(&cal), "--tcp", &address, "--wait", "1"]);
        assert!(run.status == 2 && run.stderr.contains(words), "{words}: {}", run.stderr);
    }
    other.join().expect("no panic");
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
