//! The page in headless Chromium, driven by clicks and keys: a report, the page by itself, and a board beside it.
//!
//! Node's side is `host-tests/web` (`npm ci` there). A test waits for states of the page and never for a time, and says when it was
//! skipped; with `IRONOUT_REQUIRE_CHROMIUM=1` what is missing is a failure. `IRONOUT_SCREENSHOTS=DIR` keeps the pictures.

mod common;
mod corpus;
mod writers;

use common::{folder, ironout, simulate, text, write};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

const REQUIRE: &str = "IRONOUT_REQUIRE_CHROMIUM";

/// One browser at a time.
static TURN: Mutex<()> = Mutex::new(());

fn node_side() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-tests/web")
}

/// What is missing to drive a browser.
fn missing() -> Option<String> {
    let runs = |program: &str| {
        let run = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        run.is_ok_and(|status| status.success())
    };
    let browser = std::env::var("CHROMIUM").ok().filter(|program| runs(program)).is_some()
        || ["chromium", "chromium-browser", "google-chrome"].into_iter().any(runs);
    if !browser {
        Some("there is no Chromium (apt-get install chromium, or CHROMIUM=its path)".into())
    } else if !runs("node") {
        Some("there is no Node".into())
    } else if !node_side().join("node_modules/playwright-core").exists() {
        Some("its driver is not installed (npm ci in host-tests/web)".into())
    } else if !ironout_web::has_module() {
        Some("the target wasm32-unknown-unknown is not installed".into())
    } else {
        None
    }
}

/// The turn of a test, or `None` and a word where there is no browser.
fn turn(test: &str) -> Option<MutexGuard<'static, ()>> {
    if let Some(why) = missing() {
        assert!(std::env::var(REQUIRE).as_deref() != Ok("1"), "{REQUIRE}=1, but {why}");
        // Written directly: the test harness swallows eprintln!.
        let _ = writeln!(std::io::stderr(), "{test}: skipped: {why}");
        return None;
    }
    Some(TURN.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Runs a scenario; what the browser complained of fails the test.
fn scenario(name: &str, mut given: Value) -> Value {
    let shots = std::env::var("IRONOUT_SCREENSHOTS").ok();
    given["shots"] = shots.map_or(Value::Null, |dir| {
        Value::from(if name == "live" || name == "serial" { format!("{dir}/{name}") } else { dir })
    });
    let run = Command::new("node")
        .current_dir(node_side())
        .args(["run.js", name, &given.to_string()])
        .output()
        .expect("node runs");
    let said = String::from_utf8_lossy(&run.stdout);
    let seen: Value = serde_json::from_str(said.trim())
        .unwrap_or_else(|error| panic!("{name}: {error}: {said}\n{}", String::from_utf8_lossy(&run.stderr)));
    assert_eq!(seen["wrong"], json!([]), "{name}: the browser complains");
    for key in ["objections", "objectionsDark", "empty", "wide"] {
        if let Some(objections) = seen.get(key) {
            assert_eq!(*objections, json!([]), "{name}: {key}");
        }
    }
    seen
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn words(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

#[test]
fn a_report_shows_the_error_fall_when_the_missing_effect_is_switched_on() {
    let Some(_turn) = turn("a report") else { return };
    let here = folder("page-report");
    let log =
        simulate(&here, "log.csv", &["--seed", "17", "--seconds", "40", "--effect", "offset:current_a=3"]);
    let file = here.join("report.html");
    let run = ironout(["report", text(&log), "-o", text(&file), "--json"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let fitted = &run.json()["fit"];
    let seen = scenario("report", json!({"file": file, "effect": "offset:current_a"}));
    // The command line's own digits.
    assert!((number(&seen["base"]) - number(&fitted["rms_ut"])).abs() <= 5.01e-4, "{seen}");
    // The floor of the model that has the effect: without it, the noise is told from what is left.
    let (base, now, floor) = (number(&seen["base"]), number(&seen["now"]), number(&seen["floorNow"]));
    assert!(base > 2.0 * floor && now < 1.15 * floor, "{seen}");
    assert!(words(&seen["sentenceNow"]).contains("which is what the noise leaves"), "{seen}");
    let with = ironout(["fit", text(&log), "--add", "offset:current_a", "--json"]).json();
    assert!((now - number(&with["rms_ut"])).abs() <= 5.01e-4, "{now} {}", with["rms_ut"]);
    assert_eq!((&seen["turned"], &seen["checked"]), (&json!(true), &json!(true)));
    assert_eq!(seen["steps"].as_array().map(Vec::len), Some(2), "{seen}");
    assert_eq!(seen["download"], "calibration.h");
    assert!(words(&seen["exported"]).contains("current_a"), "{seen}");
    assert_eq!(seen["dark"], "dark");
    assert!(number(&seen["pages"]) >= 2.0, "{seen}");
}

#[test]
fn names_in_a_log_are_never_markup() {
    let Some(_turn) = turn("a hostile log") else { return };
    let here = folder("page-hostile");
    let log = simulate(&here, "log.csv", &["--seed", "3", "--seconds", "20"]);
    let names = [
        "<img src=x onerror=window.injected=1>",
        "</script><script>window.injected=1</script>",
        "__proto__",
        "'-alert(1)-'",
    ];
    let content = std::fs::read_to_string(&log).expect("the log");
    let lines = content.lines().filter(|line| !line.starts_with('#'));
    let hostile: String = lines
        .enumerate()
        .map(|(row, line)| match row {
            0 => format!("{line},{}\n", names.map(|name| format!("\"{name}\"")).join(",")),
            _ => format!("{line},{row},{},{},{}\n", row % 7, row % 11, row % 13),
        })
        .collect();
    let log = write(
        &here,
        "a<b onclick=alert(1)>.csv",
        format!("# </script><script>window.injected=1</script>\n{hostile}"),
    );
    let file = here.join("report.html");
    let run = ironout(["report", text(&log), "-o", text(&file), "--no-search"]);
    assert!(run.status < 2, "{}", run.stderr);
    let seen = scenario("hostile", json!({"file": file, "names": names}));
    assert_eq!((&seen["injected"], &seen["marked"]), (&json!([]), &json!(false)), "{seen}");
    assert_eq!(seen["seen"], json!(names));
    for name in names {
        assert!(seen["columns"].as_array().is_some_and(|all| all.contains(&name.into())), "{name}: {seen}");
    }
}

#[test]
fn a_long_log_stays_small() {
    let here = folder("page-long");
    let log = simulate(&here, "log.csv", &["--seed", "5", "--seconds", "1000", "--rate", "100"]);
    let file = here.join("report.html");
    let run = ironout(["report", text(&log), "-o", text(&file), "--no-search"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let bytes = std::fs::metadata(&file).expect("a report").len();
    assert!(bytes < 6_000_000, "{bytes}");
}

#[test]
fn each_plot_is_a_file_of_its_own() {
    let here = folder("page-plots");
    let log =
        simulate(&here, "log.csv", &["--seed", "17", "--seconds", "30", "--effect", "offset:current_a=3"]);
    let plots = here.join("plots");
    let options = ["--add", "offset:current_a", "--no-search", "--plots", text(&plots)];
    let run = ironout(["report", text(&log)].iter().chain(&options));
    assert_eq!(run.status, 0, "{}", run.stderr);
    let names: Vec<String> = std::fs::read_dir(&plots)
        .expect("a folder")
        .map(|entry| entry.expect("a file").file_name().into_string().expect("text"))
        .collect();
    for part in ["magnitude", "error", "dip", "heading", "current-a", "spectrum", "histogram", "sphere-xy"] {
        let name =
            names.iter().find(|name| name.contains(part)).unwrap_or_else(|| panic!("no {part}: {names:?}"));
        let svg = std::fs::read_to_string(plots.join(name)).expect("text");
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n") && svg.len() > 2000, "{name}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
    }
}

/// A sample of a format, and the options it needs.
struct Dropped {
    path: PathBuf,
    options: Vec<(&'static str, String)>,
}

/// Every format's sample: text by the corpus of the reader's tests, recordings by their writers.
fn samples(here: &Path) -> Vec<Dropped> {
    use writers::dataflash::{Cell::N, Cell::T, Dataflash};
    use writers::ros::{File, Form, Message};
    use writers::truth::Truth;
    use writers::ulog::{Ulog, floats};
    let mut all = Vec::new();
    let mut add = |name: String, bytes: &[u8], options: Vec<(&'static str, String)>| {
        all.push(Dropped { path: write(here, &name, bytes), options });
    };
    for (index, sample) in corpus::all(&corpus::rows()).into_iter().enumerate() {
        let mut options: Vec<(&'static str, String)> =
            sample.map.iter().map(|map| ("map", map.to_string())).collect();
        options.extend(sample.scale.map(|scale| ("ut-per-count", scale.to_string())));
        options.extend(sample.instance.map(|number| ("instance", number.to_string())));
        add(format!("{index:02}.log"), &sample.bytes, options);
    }
    let truth = Truth::new("page-truth");
    let (mut ulog, mut dataflash) = (Ulog::new(1000), Dataflash::new());
    let mut mcap = File::new(Form::Little, Some(mcap::Compression::Zstd));
    let mut packed = File::new(Form::Ros1, Some(mcap::Compression::Lz4));
    ulog.info("sys_name", "PX4");
    ulog.format(
        "sensor_mag:uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;\
         float temperature;uint32_t error_count;",
    );
    ulog.subscribe(0, 0, "sensor_mag");
    dataflash.message("MSG", &[N(1000.0), T("ArduCopter V4.5.7 (2a3dc4b7)")]);
    let mut blackbox = Vec::new();
    for row in 0..truth.log.rows {
        let (micros, field) = (truth.micros(row), truth.field(row));
        let stamp = (1000 + micros).to_le_bytes();
        ulog.data(
            0,
            &[
                &stamp,
                &stamp,
                &7_u32.to_le_bytes(),
                &floats(field.map(|v| v / 100.0)),
                &20_f32.to_le_bytes(),
                &[0; 4],
            ],
        );
        let [x, y, z] = field.map(|v| N(v * 10.0));
        let zero = N(0.0);
        dataflash.message(
            "MAG",
            &[N(3e6 + micros as f64), zero, x, y, z, zero, zero, zero, zero, zero, zero, N(1.0), zero],
        );
        for file in [&mut mcap, &mut packed] {
            let stamp = 1_700_000_000_000_000_000 + micros * 1000;
            let tesla = [field[0], -field[1], -field[2]].map(|v| v * 1e-6);
            let message = Message::new(file.form(), stamp, "imu_link").doubles(&tesla).doubles(&[0.0; 9]);
            file.write("/imu/mag", "MagneticField", stamp, &message.finish());
        }
        let counts = [field[0], -field[1], -field[2]].map(|v| (v / 0.02).round() as i32);
        let mut own = [0; 13];
        own[0] = 3_000_000 + micros as i32;
        own[3..6].copy_from_slice(&counts);
        own[11] = 2048;
        blackbox.push(own);
    }
    add("flight.ulg".into(), &ulog.bytes, Vec::new());
    add("flight.bin".into(), &dataflash.binary, Vec::new());
    add("flight.log".into(), dataflash.text.as_bytes(), Vec::new());
    add("bag.mcap".into(), &mcap.finish(), Vec::new());
    add("bag1.mcap".into(), &packed.finish(), Vec::new());
    let firmware = "Betaflight 4.5.1 (77d01ba3b) STM32F405";
    add(
        "flight.bbl".into(),
        &writers::blackbox::session(firmware, &blackbox),
        vec![("ut-per-count", "0.02".to_string())],
    );
    all
}

#[test]
fn every_format_dropped_on_the_page_says_what_the_command_line_says() {
    let Some(_turn) = turn("the page by itself") else { return };
    let here = folder("page-alone");
    let made = ironout(["web", "-o", text(&here.join("web"))]);
    assert_eq!(made.status, 0, "{}", made.stderr);
    let samples = samples(&here);
    let expected: Vec<String> = samples
        .iter()
        .map(|sample| {
            let name = sample.path.file_name().and_then(|name| name.to_str()).expect("a name");
            let mut command = Command::new(env!("CARGO_BIN_EXE_ironout"));
            command.current_dir(&here).args(["fit", name]);
            for (option, value) in &sample.options {
                command.arg(format!("--{option}={value}"));
            }
            let run = command.output().expect("it runs");
            assert!(run.status.code() < Some(2), "{name}: {}", String::from_utf8_lossy(&run.stderr));
            String::from_utf8_lossy(&run.stdout).into_owned()
        })
        .collect();
    let cal = here.join("cal.json");
    let last = samples.last().expect("samples");
    let scale = last.options.iter().map(|(option, value)| format!("--{option}={value}"));
    let fit = ironout(
        ["fit".to_string(), text(&last.path).into(), "-o".into(), text(&cal).into()].into_iter().chain(scale),
    );
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    let unreadable = write(&here, "not a log.txt", "once upon a time\n");
    let given: Vec<Value> =
        samples.iter().map(|sample| json!({"path": sample.path, "options": sample.options})).collect();
    let seen = scenario(
        "alone",
        json!({
            "file": here.join("web/index.html"), "samples": given, "cal": cal, "unreadable": unreadable,
        }),
    );
    for ((sample, expected), seen) in
        samples.iter().zip(&expected).zip(seen["samples"].as_array().expect("a list"))
    {
        let name = sample.path.display();
        assert_eq!(seen["trouble"], "", "{name}: {seen}");
        // But for the advice to keep it.
        let printed: Vec<&str> = expected.lines().filter(|line| !line.contains("keep it with -o")).collect();
        let shown: Vec<&str> = words(&seen["words"]).lines().collect();
        assert_eq!(shown, printed, "{name}");
    }
    assert!(words(&seen["beside"]).contains("cal.json"), "{seen}");
    assert!(words(&seen["refused"]).contains("no log is recognised"), "{}", seen["refused"]);
}

/// What a session by clicks shows, whatever the wire is.
fn assert_session(seen: &Value) {
    for (key, part) in [
        ("link", "mps2 with LSM303DLHC"),
        ("started", "done: cal start"),
        ("hint", "side"),
        ("stopped", "done: cal stop"),
        ("judged", "Accepted"),
        ("accepted", "done: cal accept"),
        ("reading", "magnitude 4"),
        ("whyAnswer", "done: why"),
        ("why", "Why is it off?"),
        ("sentence", "ACCEPTED"),
    ] {
        assert!(words(&seen[key]).contains(part), "{key} without {part}: {seen}");
    }
    // Nothing is hidden from it.
    assert_eq!((&seen["verdict"], &seen["recording"]), (&json!("complete"), &json!("log.csv")), "{seen}");
}

/// The recording that the page saved, read by the command line.
fn assert_recording(here: &Path, seen: &Value) {
    let log = write(here, "recording.csv", words(&seen["log"]));
    let fit = ironout(["fit", text(&log), "--json"]);
    assert_eq!(fit.status, 0, "{} {}", fit.stdout, fit.stderr);
    let fit = fit.json();
    for axis in 0..3 {
        assert!((number(&fit["offset_ut"][axis]) - 93.0).abs() < 1.0, "{fit}");
    }
}

/// A program that is ended with the test.
struct Served(Child);

impl Drop for Served {
    fn drop(&mut self) {
        // As by Ctrl-C: it switches its board off. It may have ended by itself.
        let _ = Command::new("kill").args(["-TERM", &self.0.id().to_string()]).status();
        let _ = self.0.wait();
    }
}

#[cfg(unix)]
#[test]
fn a_board_is_calibrated_by_clicks_on_the_served_page() {
    // The board first: others wait for it too, and the browser is free meanwhile.
    let Some(_board) = ironout_rig::qemu::turn("live --qemu") else { return };
    let Some(_turn) = turn("live") else { return };
    let here = folder("page-live");
    let mut child = Command::new(env!("CARGO_BIN_EXE_ironout"))
        .args(["live", "--qemu", "--json", "--wait", "300"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let out = child.stdout.take().expect("its output");
    let _served = Served(child);
    let mut line = String::new();
    BufReader::new(out).read_line(&mut line).expect("it says where");
    let address: Value = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line:?}"));
    let seen = scenario("live", json!({"address": address["address"]}));
    assert_session(&seen);
    assert_recording(&here, &seen);
}

/// Switches the emulated board of a thread off when it goes.
struct Off {
    stop: Arc<AtomicBool>,
    served_at: String,
    bridge: Option<JoinHandle<()>>,
}

impl Drop for Off {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // It may be waiting for a client.
        drop(std::net::TcpStream::connect(&self.served_at));
        if let Some(bridge) = self.bridge.take() {
            // A board that has failed has said so.
            let _ = bridge.join();
        }
    }
}

#[cfg(unix)]
#[test]
fn a_board_is_calibrated_over_a_serial_port_of_the_browser() {
    use ironout_rig::qemu::{self, Emulator, Firmware, Options};
    use ironout_simulation::{World, WorldOptions};
    let Some(_board) = qemu::turn("the page on a serial port") else { return };
    let Some(_turn) = turn("the page on a serial port") else { return };
    let here = folder("page-serial");
    let made = ironout(["web", "-o", text(&here)]);
    assert_eq!(made.status, 0, "{}", made.stderr);
    let firmware = Firmware::build().unwrap_or_else(|error| panic!("{error}"));
    let mut board = Emulator::start(&firmware, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let world = World::new(WorldOptions {
        seed: 72,
        field_ut: 48.0,
        hard_iron_ut: Some([93.0; 3]),
        seconds: 600.0,
        ..WorldOptions::default()
    });
    board.set_field_ut(world.sensor_ut(0.0)).expect("a field");
    // The page may open the port any number of times; at the end the board is switched off.
    let stop = Arc::new(AtomicBool::new(false));
    let (stopped, served_at) = (Arc::clone(&stop), address.clone());
    let bridge = std::thread::spawn(move || {
        let turn = |sample: u64| Some(world.sensor_ut((sample as f64 * 0.04) % 600.0));
        while !stopped.load(Ordering::Relaxed) && board.serve(&listener, turn).is_ok() {}
    });
    let _off = Off { stop, served_at, bridge: Some(bridge) };
    let seen = scenario("serial", json!({"file": here.join("index.html"), "address": address}));
    assert!(words(&seen["gone"]).contains("it is waited for"), "{seen}");
    assert_eq!(seen["rates"].as_array().and_then(|rates| rates.first()), Some(&json!(115_200)), "{seen}");
    assert_session(&seen);
    assert_recording(&here, &seen);
}
