//! Text logs as people have them: each format gives the calibration of the CSV that it was made from, says how it was read, and is
//! read the same again with what it says.

use crate::common::{folder, ironout, text, write};
use crate::corpus::{Row, Sample};
use crate::writers::fuzz::fuzz;
use ironout_analysis::{Options, Table, fit};
use ironout_cli::cal_file::FitObject;
use ironout_cli::input::{Log, ReadOptions, parse_map, read_stream};
use ironout_cli::read_block;

/// The CSV that the sample was made from, with the columns that it carries.
fn reference(rows: &[Row], sample: &Sample) -> Log {
    let mut names = Vec::new();
    if sample.timed {
        names.push("t_s");
    }
    names.extend(["mx_ut", "my_ut", "mz_ut"]);
    if sample.accel_step.is_some() {
        names.extend(["ax_mps2", "ay_mps2", "az_mps2"]);
    }
    let mut csv = names.join(",") + "\n";
    for r in rows {
        let mut cells: Vec<f64> = if sample.timed { vec![r.t] } else { vec![] };
        cells.extend(r.m);
        if sample.accel_step.is_some() {
            cells.extend(r.a);
        }
        csv.push_str(&cells.iter().map(f64::to_string).collect::<Vec<_>>().join(","));
        csv.push('\n');
    }
    read_stream(csv.as_bytes(), 0, &ReadOptions::default()).expect("the program's own CSV")
}

fn calibrated(name: &str, log: &Log) -> ([f64; 3], [[f64; 3]; 3]) {
    let fitted = fit(&Table::from(log), &Options::default()).unwrap_or_else(|_| panic!("{name}: no fit"));
    assert!(fitted.accepted, "{name}: {:?}", fitted.reasons);
    let object = FitObject::of(&fitted, "adjusted");
    (object.offset_ut.expect("an offset"), object.matrix.expect("a matrix"))
}

#[test]
fn every_format_gives_the_calibration_of_its_csv() {
    let rows = crate::corpus::rows();
    let samples = crate::corpus::all(&rows);
    assert!(samples.len() >= 45, "{} formats", samples.len());
    let mut wrong = Vec::new();
    for sample in &samples {
        let from = reference(&rows, sample);
        let log = match sample.read() {
            Ok(log) => log,
            Err(words) => {
                wrong.push(words);
                continue;
            }
        };
        let mut objections = Vec::new();
        if log.rows != from.rows {
            objections.push(format!("{} rows, {} were written", log.rows, from.rows));
        }
        let furthest = |a: &[Vec<f64>; 3], b: &[Vec<f64>; 3]| {
            a.iter().flatten().zip(b.iter().flatten()).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
        };
        let far = furthest(&log.field_ut, &from.field_ut);
        if far > sample.step_ut * 0.51 + 1e-9 {
            objections.push(format!("the field differs by {far} µT, its last digit is {}", sample.step_ut));
        }
        match (&log.accel_mps2, &from.accel_mps2, sample.accel_step) {
            (Some(a), Some(b), Some(step)) if furthest(a, b) <= step * 0.51 + 1e-9 => {}
            (None, None, None) => {}
            _ => objections.push("the accelerometer is another".to_string()),
        }
        if log.gyro_radps.is_some() != sample.gyro {
            objections.push(format!("gyroscope: {}", log.gyro_radps.is_some()));
        }
        match (&log.time_s, &from.time_s) {
            (Some(a), Some(b)) => {
                let far = a.iter().zip(b).map(|(x, y)| ((x - a[0]) - (y - b[0])).abs()).fold(0.0, f64::max);
                if far > 1.1e-3 {
                    objections.push(format!("time differs by {far} s"));
                }
            }
            (None, None) => {}
            _ => objections.push(format!("time: {}", log.time_s.is_some())),
        }
        if objections.is_empty() {
            // Rounding is noise of a third of the last digit; the fit averages it over the rows.
            let ((offset, matrix), (own_offset, own_matrix)) =
                (calibrated(sample.name, &log), calibrated(sample.name, &from));
            // A gyro's rounding turns what the accelerometer measures over some seconds, by a fiftieth of a degree.
            let gyro = if log.gyro_radps.is_some() { 1e-3 } else { 0.0 };
            let share = sample.step_ut / 40.0 + sample.accel_step.unwrap_or(0.0) / 9.8 + gyro;
            for axis in 0..3 {
                let far = (offset[axis] - own_offset[axis]).abs();
                if far > sample.step_ut * 0.5 + 1e-6 {
                    objections.push(format!("offset {axis} differs by {far} µT"));
                }
                for other in 0..3 {
                    let far = (matrix[axis][other] - own_matrix[axis][other]).abs();
                    if far > share * 0.5 + 1e-8 {
                        objections.push(format!("matrix {axis}{other} differs by {far}"));
                    }
                }
            }
        }
        if !objections.is_empty() {
            wrong.push(format!(
                "{}: {}\n{}\n{}",
                sample.name,
                objections.join("; "),
                read_block::text(&log),
                sample.head()
            ));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), samples.len(), wrong.join("\n\n"));
}

/// The options as the block prints them, taken back from its words.
fn pinned(log: &Log) -> ReadOptions {
    let mut options = ReadOptions::default();
    for (option, value) in &log.read_as.pins {
        match option.as_str() {
            "--map" => {
                options.map = parse_map(std::slice::from_ref(value))
                    .unwrap_or_else(|failure| panic!("{value}: {failure}"))
            }
            "--instance" => options.instance = Some(value.parse().expect("a number")),
            "--ut-per-count" => {
                let scale: Vec<f64> = value.split(',').map(|part| part.parse().expect("a number")).collect();
                options.ut_per_count = Some([scale[0], scale[1], scale[2]]);
            }
            other => panic!("{other}"),
        }
    }
    options
}

#[test]
fn what_is_printed_pins_the_reading_to_the_bit() {
    let rows = crate::corpus::rows();
    for sample in crate::corpus::all(&rows) {
        let log = sample.read().expect("read above");
        let again = read_stream(sample.bytes.as_slice(), 0, &pinned(&log))
            .unwrap_or_else(|failure| panic!("{}: {failure}\n{}", sample.name, read_block::text(&log)));
        let bits = |log: &Log| -> Vec<u64> {
            let columns = log.time_s.iter().chain(&log.field_ut).chain(log.accel_mps2.iter().flatten());
            let columns = columns.chain(log.gyro_radps.iter().flatten()).chain(&log.heading_deg);
            columns
                .chain(log.covariates.iter().map(|c| &c.values))
                .flatten()
                .map(|value| value.to_bits())
                .collect()
        };
        let names = |log: &Log| log.covariates.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&log), names(&again), "{}", sample.name);
        assert!(bits(&log) == bits(&again), "{}\n{}", read_block::text(&log), read_block::text(&again));
        assert_eq!((log.rows, &log.counts), (again.rows, &again.counts), "{}", sample.name);
        assert_eq!(log.read_as.columns, again.read_as.columns, "{}", sample.name);
    }
}

/// The words of the block through a POSIX shell: the same object as without them.
#[test]
fn the_printed_options_can_be_pasted_into_a_shell() {
    let rows = crate::corpus::rows();
    let here = folder("pasted");
    let program = env!("CARGO_BIN_EXE_ironout");
    let wanted = [
        "semicolons, decimal comma",
        "phyphox, CSV with commas",
        "two sensors in the rows of one table",
        "4 numbers a line",
        "R, lines of an ironout board between replies",
    ];
    let samples: Vec<Sample> =
        crate::corpus::all(&rows).into_iter().filter(|sample| wanted.contains(&sample.name)).collect();
    assert_eq!(samples.len(), wanted.len());
    for sample in samples {
        let log = write(&here, "a log.txt", &sample.bytes);
        let mut arguments = vec!["fit".to_string(), text(&log).to_string()];
        sample.scale.iter().for_each(|scale| arguments.extend(["--ut-per-count".into(), scale.to_string()]));
        sample.instance.iter().for_each(|number| arguments.extend(["--instance".into(), number.to_string()]));
        let said = ironout(&arguments);
        assert_eq!(said.status, 0, "{}: {}", sample.name, said.stderr);
        let line = said.stderr.lines().find_map(|line| line.trim().strip_prefix("read the same again with"));
        let line = line.unwrap_or_else(|| panic!("no pins in {}", said.stderr));
        let object = ironout(arguments.iter().map(String::as_str).chain(["--json"])).json();
        let command = format!("'{program}' fit '{}' --json {line}", text(&log));
        let pasted = std::process::Command::new("sh").args(["-c", &command]).output().expect("a shell");
        let pasted: serde_json::Value = serde_json::from_slice(&pasted.stdout).unwrap_or_else(|error| {
            panic!("{error}: {command}: {}", String::from_utf8_lossy(&pasted.stderr))
        });
        assert_eq!(pasted["offset_ut"], object["offset_ut"], "{command}");
        assert_eq!(pasted["read_as"]["columns"], object["read_as"]["columns"], "{command}");
    }
}

#[test]
fn broken_tables_are_answered_or_refused() {
    let rows = crate::corpus::rows();
    let samples = crate::corpus::all(&rows);
    let short: Vec<&[u8]> =
        samples.iter().map(|sample| sample.bytes.get(..8000).unwrap_or(&sample.bytes)).collect();
    let accepted = fuzz("text of other programs", &short, 4000);
    assert!(accepted > 400, "{accepted}");
}
