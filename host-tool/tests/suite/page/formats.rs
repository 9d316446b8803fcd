//! The page by itself: a sample of every format is dropped on it.

use crate::common::{folder, ironout, text, write};
use crate::page::browser::{scenario, turn, words};
use crate::page::report::{HOSTILE, assert_text, hostile};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A sample of a format, and the options it needs.
struct Dropped {
    path: PathBuf,
    options: Vec<(&'static str, String)>,
}

/// Every format's sample: text by the corpus of the reader's tests, recordings by their writers.
fn samples(here: &Path) -> Vec<Dropped> {
    use crate::writers::dataflash::{Cell::N, Cell::T, Dataflash};
    use crate::writers::ros::{File, Form, Message};
    use crate::writers::truth::Truth;
    use crate::writers::ulog::{Ulog, floats};
    let mut all = Vec::new();
    let mut add = |name: String, bytes: &[u8], options: Vec<(&'static str, String)>| {
        all.push(Dropped { path: write(here, &name, bytes), options });
    };
    for (index, sample) in crate::corpus::all(&crate::corpus::rows()).into_iter().enumerate() {
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
        &crate::writers::blackbox::session(firmware, &blackbox),
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
            command.current_dir(&here).args(["fit", name, "-o", "cal.json", "-v"]);
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
            "hostile": hostile(&here), "names": HOSTILE,
        }),
    );
    for ((sample, expected), seen) in
        samples.iter().zip(&expected).zip(seen["samples"].as_array().expect("a list"))
    {
        let name = sample.path.display();
        assert_eq!(seen["trouble"], "", "{name}: {seen}");
        // But for what became of the file.
        let of_file = |line: &&str| !line.starts_with("wrote ") && !line.starts_with("refused: ");
        let printed: Vec<&str> = expected.lines().filter(of_file).collect();
        let shown: Vec<&str> = words(&seen["words"]).lines().collect();
        assert_eq!(shown, printed, "{name}");
    }
    assert!(words(&seen["beside"]).contains("cal.json"), "{seen}");
    let example = &seen["example"];
    assert!(words(&example["name"]).starts_with("example.csv"), "{example}");
    assert!(words(&example["sentence"]).starts_with("FOUND"), "{example}");
    assert_eq!(example["on"], json!(["offset:current_a"]));
    let asked = &seen["question"];
    assert!(words(&asked["text"]).contains("Which chip is it?"), "{asked}");
    assert_eq!((&asked["left"], &asked["objections"]), (&json!(["verdict", "drop"]), &json!([])), "{asked}");
    let own = seen["samples"].as_array().and_then(|all| all.last()).map(|last| &last["now"]);
    assert!(words(&asked["name"]).starts_with("flight.bbl") && Some(&asked["answered"]) == own, "{asked}");
    // The same digits of a log that only stands beside another.
    let first =
        samples.first().expect("samples").path.file_name().and_then(|name| name.to_str()).expect("a name");
    let own = seen["samples"][0]["now"].as_str().expect("an error");
    let beside = words(&seen["besideLog"]);
    assert!(beside.contains(first) && beside.contains(own), "{first} {own}: {beside}");
    assert_eq!(seen["stays"], json!(true), "{seen}");
    assert_text(&seen["hostile"]);
    assert!(words(&seen["refused"]).contains("the format is unknown"), "{}", seen["refused"]);
}
