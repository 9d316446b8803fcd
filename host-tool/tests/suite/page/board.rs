//! Boards that are simulated, and sketches of others: a cable is pulled, nothing comes.

use crate::common::{folder, ironout, text, write};
use crate::page::browser::{scenario, turn, words};
use ironout_rig::board::SimBoard;
use ironout_rig::served::Served;
use ironout_simulation::{World, WorldOptions};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};

/// The simulated board's seconds in one of the browser's.
const PACE: f64 = 8.0;

/// A program that is ended with the test.
pub struct Program(Child);

impl Program {
    /// Its number.
    pub fn id(&self) -> u32 {
        self.0.id()
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // As by Ctrl-C: it switches its board off. It may have ended by itself.
        let _ = Command::new("kill").args(["-TERM", &self.0.id().to_string()]).status();
        let _ = self.0.wait();
    }
}

/// `ironout live` beside this board, and where its page is.
pub fn live(board: &[&str]) -> (Program, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_ironout"))
        .args(["live", "--json", "--wait", "300"])
        .args(board)
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let out = child.stdout.take().expect("its output");
    let program = Program(child);
    let mut line = String::new();
    BufReader::new(out).read_line(&mut line).expect("it says where");
    let said: Value = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line:?}"));
    (program, words(&said["address"]).to_string())
}

/// Does with the board what the browser's side asks for, one word a line.
fn hands(board: Served) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    std::thread::spawn(move || {
        let Ok((browser, _)) = listener.accept() else { return };
        for word in BufReader::new(browser).lines().map_while(Result::ok) {
            board.with(move |bench| match word.as_str() {
                "pull" => bench.pull(),
                "plug" => bench.plug(),
                "deaf" => bench.deafen(true),
                "hear" => bench.deafen(false),
                word => panic!("no such word: {word}"),
            });
        }
    });
    address
}

#[test]
fn a_board_that_hangs_and_a_cable_that_is_pulled_are_told_and_waited_for() {
    let Some(_turn) = turn("live --tcp") else { return };
    let board = Served::start(|| {
        let world = World::new(WorldOptions { seed: 41, seconds: 900.0, ..WorldOptions::default() });
        SimBoard::new(move |t_s: f64| world.sensor_ut(t_s), 0.25, 41)
    })
    .expect("a port");
    board.with(|bench| {
        bench.board.run_ms(100);
        bench.pace(PACE);
    });
    let (_program, address) = live(&["--tcp", &board.address()]);
    let seen = scenario("cable", json!({"address": address, "hands": hands(board)}));
    for (key, part) in [
        ("silent", "no data from"),
        ("gone", "waiting for it"),
        ("back", "LSM303DLHC"),
        ("started", "done: cal start"),
    ] {
        assert!(words(&seen[key]).contains(part), "{key} without {part}: {seen}");
    }
}

/// Serves each that calls by `speak`, for as long as the test runs.
fn caller(speak: impl Fn(TcpStream) + Send + 'static) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    std::thread::spawn(move || {
        while let Ok((stream, _)) = listener.accept() {
            speak(stream);
        }
    });
    address
}

/// Names and words that would be markup, where a page took them for it.
const HOSTILE: &str = "<img/src=x/onerror=window.injected=1>";

/// A board that says nothing else.
fn hostile(stream: TcpStream) {
    let Ok(mut out) = stream.try_clone() else { return };
    let mut row = 0;
    for line in BufReader::new(stream).lines().map_while(Result::ok) {
        let answer = match line.trim() {
            "version" => format!(
                "+ board={HOSTILE}\n+ sensor=<b>bold</b>\nok ironout={HOSTILE} ut_per_count=0.1,0.1,0.1"
            ),
            "status" => {
                let columns = "t_ms,seq,mx,my,mz";
                let mut stream = format!("H,{columns},x,{HOSTILE}\n");
                for _ in 0..40 {
                    row += 1;
                    stream += &format!(
                        "L,{},{row},{},{},{},1,{}\n",
                        20 * row,
                        row % 17,
                        row % 13,
                        row % 11,
                        row % 7
                    );
                }
                format!(
                    "{stream}+ hint {HOSTILE}\nok state=collecting coverage=0.5 gap_deg=50 rms_ut={HOSTILE} noise_ut=1 n=5 calibrated=1"
                )
            }
            "why" => format!(
                "+ says {HOSTILE}\n+ base rms_ut={HOSTILE} holdout_rms_ut=1 noise_floor_ut=1\n\
                 + effect id={HOSTILE} status=missing before_ut={HOSTILE} after_ut=1 p=0 confounded_with={HOSTILE}\n\
                 ok verdict={HOSTILE}"
            ),
            "" => continue,
            _ => format!("err {HOSTILE}"),
        };
        if out.write_all(format!("{answer}\n").as_bytes()).is_err() {
            return;
        }
    }
}

#[test]
fn a_sketch_for_motioncal_is_recorded_and_a_hostile_board_is_only_text() {
    let Some(_turn) = turn("the page beside a sketch") else { return };
    let here = folder("page-sketch");
    let made = ironout(["web", "-o", text(&here)]);
    assert_eq!(made.status, 0, "{}", made.stderr);
    let options = WorldOptions { seed: 19, seconds: 60.0, rate_hz: 25.0, ..WorldOptions::default() };
    let world = World::new(options);
    let lines: Vec<String> = (0..1500)
        .map(|row| {
            let [x, y, z] = world.sensor_ut(f64::from(row) * 0.04).map(|ut| (10.0 * ut).round() as i32);
            format!("Raw:0,0,8192,0,0,0,{x},{y},{z}\r\n")
        })
        .collect();
    let raw: String = lines.concat();
    let sketch = caller(move |mut stream| {
        // As a sketch does, it hears nothing; and it goes on until the cable is pulled.
        for line in lines.chunks(25).cycle() {
            if stream.write_all(line.concat().as_bytes()).is_err() {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
    });
    let seen = scenario(
        "sketch",
        json!({"file": here.join("index.html"), "address": sketch, "rows": 1500, "hostile": caller(hostile), "name": HOSTILE}),
    );
    assert!(words(&seen["link"]).contains("a sketch that prints Raw: lines"), "{seen}");
    assert_eq!(seen["recording"], "raw.txt");
    // What was saved is what was sent, and the command line says of it what the page says.
    let log = words(&seen["log"]);
    assert!(log.lines().zip(raw.lines()).take(1500).all(|(own, sent)| own == sent), "{log}");
    let saved = write(&here, "recording.txt", log);
    let mut fit = Command::new(env!("CARGO_BIN_EXE_ironout"));
    let fit = fit
        .current_dir(&here)
        .args(["fit", "recording.txt", "-o", "cal.json", "-v"])
        .output()
        .expect("it runs");
    let printed = String::from_utf8_lossy(&fit.stdout);
    let printed: Vec<&str> = printed.lines().collect();
    assert_eq!(words(&seen["words"]).lines().collect::<Vec<_>>(), printed, "{}", saved.display());
    assert!(words(&seen["advice"]).contains("ready to export"), "{seen}");
    // The hostile one.
    assert_eq!((&seen["injected"], &seen["marked"]), (&json!([]), &json!(false)), "{seen}");
    for place in ["hostileLink", "hostileHint", "hostileWhy", "hostileSaved"] {
        assert!(words(&seen[place]).contains(HOSTILE), "{place}: {seen}");
    }
}
