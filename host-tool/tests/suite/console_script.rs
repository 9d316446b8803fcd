//! The Python program that docs/console.md names, run as it stands, against the simulated and the emulated board.

use crate::common::{folder, text, write};
use ironout_rig::board::SimBoard;
use ironout_rig::served::Served;
use ironout_simulation::{Motion, World, WorldOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The program.
fn program(here: &Path) -> PathBuf {
    write(here, "calibrate.py", include_str!("../../../examples/console/calibrate.py"))
}

/// Whether Python is there; where it is required, it has to be.
fn python() -> bool {
    let there = Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success());
    if !there {
        assert!(std::env::var_os("IRONOUT_REQUIRE_QEMU").is_none(), "python3 is required, and not there");
        // Written directly: the test harness swallows eprintln!.
        let _ = writeln!(std::io::stderr(), "SKIPPED: python3 is not installed");
    }
    there
}

fn run(program: &Path, address: &str) -> Output {
    Command::new("python3").args([text(program), address]).output().expect("python3 starts")
}

fn calibrated(output: &Output) {
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said} {}", String::from_utf8_lossy(&output.stderr));
    for word in ["cal start -> ok", "samples", "verdict=accepted", "calibrated=1", "offset_ut=", "stored=1"] {
        assert!(said.contains(word), "no {word} in {said}");
    }
}

fn world(seed: u64, hard_iron_ut: [f64; 3]) -> World {
    World::new(WorldOptions {
        seed,
        motion: Motion::Sphere,
        hard_iron_ut: Some(hard_iron_ut),
        ..WorldOptions::default()
    })
}

#[test]
fn the_documented_program_calibrates_the_simulated_board() {
    if !python() {
        return;
    }
    let program = program(&folder("script-simulated"));
    let board = Served::start(|| {
        let world = world(71, [93.0, 40.0, -70.0]);
        let mut board = SimBoard::new(move |t_s| world.sensor_ut(t_s), 0.05, 71);
        board.run_ms(100);
        board
    })
    .expect("a port");
    calibrated(&run(&program, &board.address()));
    // A board that refuses ends it with a failure, and its reason.
    board.with(|bench| bench.board.command("cal start"));
    let refused = run(&program, &board.address());
    let said = String::from_utf8_lossy(&refused.stdout);
    assert!(refused.status.code() == Some(1) && said.contains("err state already collecting"), "{said}");
}

/// The firmware in QEMU: the program calibrates it, and then the tool sends, fetches and records. Its field turns by its own samples.
#[cfg(all(unix, feature = "emulated"))]
#[test]
fn the_emulated_board_is_calibrated_by_the_program_and_speaks_to_the_tool() {
    use ironout_rig::qemu::{self, Emulator, Firmware, Options};
    if !python() {
        return;
    }
    let Some(_turn) = qemu::turn("the console's program") else { return };
    let here = folder("script-emulated");
    let program = program(&here);
    let firmware = Firmware::build().unwrap_or_else(|error| panic!("{error}"));
    let mut board = Emulator::start(&firmware, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    // The emulated sensor knows no negative fields, and is in none at first, which is no attitude.
    let world = world(72, [93.0; 3]);
    board.wait_for_samples().expect("samples");
    board.set_field_ut(world.sensor_ut(0.0)).expect("a field");
    let clients = 5;
    let bridge = std::thread::spawn(move || {
        for _ in 0..clients {
            // Twice as fast as by hand.
            board
                .serve(&listener, |board, _, sample| {
                    board.set_field_ut(world.sensor_ut(sample as f64 * 0.04))
                })
                .expect("it is served");
        }
    });
    calibrated(&run(&program, &address));
    let (cal, back, log) = (here.join("cal.json"), here.join("back.json"), here.join("log.csv"));
    let tool = |arguments: &[&str]| {
        let run =
            crate::common::ironout(arguments.iter().copied().chain(["--tcp", &address, "--wait", "600"]));
        assert_eq!(run.status, 0, "{arguments:?}: {} {}", run.stdout, run.stderr);
        run
    };
    tool(&["fetch", "-o", text(&cal)]);
    tool(&["send", text(&cal)]);
    tool(&["fetch", "-o", text(&back)]);
    tool(&["record", "-o", text(&log), "--seconds", "10"]);
    bridge.join().expect("no panic");
    let read = |path: &Path| -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(path).expect("a file")).expect("JSON")
    };
    let (cal, back) = (read(&cal), read(&back));
    // In single precision on the way.
    let entries = |cal: &serde_json::Value| -> Vec<f64> {
        let rows = cal["information"]["matrix"].as_array().expect("the information matrix");
        rows.iter()
            .flat_map(|row| row.as_array().expect("a row"))
            .filter_map(serde_json::Value::as_f64)
            .collect()
    };
    let (sent, fetched) = (entries(&cal), entries(&back));
    assert_eq!((sent.len(), fetched.len()), (81, 81));
    for place in 0..81 {
        let scale = (sent[place / 9 * 10] * sent[place % 9 * 10]).sqrt();
        assert!(
            (sent[place] - fetched[place]).abs() < 1e-3 * scale,
            "{place}: {} {}",
            sent[place],
            fetched[place]
        );
    }
    for key in ["offset_ut", "matrix", "field_ut", "rms_ut", "noise_floor_ut", "samples_used"] {
        assert_eq!(cal[key], back[key], "{key}");
    }
    for (axis, offset) in cal["offset_ut"].as_array().expect("three").iter().enumerate() {
        assert!((offset.as_f64().expect("a number") - 93.0).abs() < 0.2, "{axis}: {offset}");
    }
    let content = std::fs::read_to_string(&log).expect("the log");
    assert!(content.lines().filter(|line| !line.starts_with('#')).count() > 250, "10 s of some 50 samples");
}
