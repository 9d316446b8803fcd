//! What the tests of the link share: boards behind a port, and the commands that speak to them.

use crate::common::{Run, ironout, write};
use ironout_rig::board::SimBoard;
use ironout_rig::served::Served;
use ironout_simulation::{Motion, World, WorldOptions};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};

pub const HARD_IRON_UT: [f64; 3] = [93.0, 40.0, -70.0];
pub const NOISE_UT: f64 = 0.05;
/// However long an answer takes on a busy machine: a test that waits fails for another reason.
pub const PATIENT: &str = "600";

/// A board that is turned all the time.
pub fn turned(seed: u64) -> Served {
    Served::start(move || {
        let options = WorldOptions {
            seed,
            motion: Motion::Sphere,
            hard_iron_ut: Some(HARD_IRON_UT),
            ..WorldOptions::default()
        };
        let world = World::new(options);
        let mut board = SimBoard::new(move |t_s| world.sensor_ut(t_s), NOISE_UT, seed);
        board.run_ms(100);
        board
    })
    .expect("a port")
}

/// One command over a connection of its own: all the lines of the answer.
pub fn ask(stream: &mut BufReader<TcpStream>, command: &str) -> Vec<String> {
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

pub fn connect(board: &Served) -> BufReader<TcpStream> {
    BufReader::new(TcpStream::connect(board.address()).expect("the board is there"))
}

/// Calibrates by the console as a person does, and accepts.
pub fn calibrate(board: &Served) {
    board.with(|bench| {
        for (command, run_ms) in [("cal start", 60_000), ("cal stop", 0), ("cal accept", 0)] {
            let answer = bench.board.command(command).pop().unwrap_or_default();
            assert!(answer.starts_with("ok"), "{command}: {answer}");
            bench.board.run_ms(run_ms);
        }
    });
}

/// The command with this board at its end.
pub fn on(board: &Served, arguments: &[&str]) -> Run {
    let address = board.address();
    ironout(arguments.iter().copied().chain(["--tcp", &address, "--wait", PATIENT]))
}

pub fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("a file")).expect("JSON")
}

/// A calibration file with effects of several kinds, every number of it to the last bit.
pub fn cal_with_effects(here: &Path) -> PathBuf {
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
