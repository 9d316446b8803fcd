//! The frame of a log: whatever a reader did to the numbers of its source, every export undoes. Each target's published formula,
//! fed with those numbers, gives the field that `apply` gives.

use crate::common::target::*;
use crate::common::{folder, ironout, text, write};
use crate::frames_sources::{IDENTITY, LEFT_UP, Source, inverse, short, sources, transposed};
use crate::writers::fuzz::fuzz;
use crate::writers::truth::{Truth, assert_same_calibration, read_with};
use ironout_analysis::frame::Frame;
use ironout_cli::cal_file::CalFile;
use ironout_cli::input::{Log, ReadOptions, read_log};
use serde_json::Value;
use std::path::{Path, PathBuf};

const EXPORTS: [&str; 8] = ["px4", "ardupilot", "betaflight", "ros", "iio", "c", "rust", "json"];

/// A source, its calibration, and the log as the program reads it.
struct Case {
    source: Source,
    cal: PathBuf,
    log: Log,
    corrected: Vec<Vector>,
}

fn case(source: Source, here: &Path) -> Case {
    let (path, cal) = (write(here, source.file, &source.bytes), here.join("cal.json"));
    let fit = ironout(["fit", text(&path), "-o", text(&cal)].iter().chain(source.options));
    assert_eq!(fit.status, 0, "{}: {} {}", source.name, fit.stdout, fit.stderr);
    let out = here.join("out.csv");
    let apply = ironout(["apply", text(&path), "--cal", text(&cal), "-o", text(&out)]);
    assert_eq!(apply.status, 0, "{}: {}", source.name, apply.stderr);
    let applied = read_log(&out, &ReadOptions::default()).expect("a table");
    let column = |name: &str| applied.covariate(name).unwrap_or_else(|| panic!("no {name}")).values.clone();
    let [x, y, z] = ["cx_ut", "cy_ut", "cz_ut"].map(column);
    let corrected: Vec<Vector> = x.iter().zip(y).zip(z).map(|((x, y), z)| [*x, y, z]).collect();
    let log = read_log(&path, &options(&source)).expect("a log");
    assert_eq!((log.rows, corrected.len()), (source.numbers.len(), source.numbers.len()), "{}", source.name);
    Case { source, cal, log, corrected }
}

fn options(source: &Source) -> ReadOptions {
    let value = |name: &str| {
        let given = source.options.iter().find_map(|option| option.strip_prefix(name)?.strip_prefix('='));
        given.map(String::from)
    };
    let rotate: Vec<String> = value("--rotate").into_iter().collect();
    ReadOptions {
        mounting: ironout_cli::input::Mounting::parse(&rotate).expect("a mounting"),
        ut_per_count: value("--ut-per-count").map(|scale| [scale.parse().expect("a number"); 3]),
        ..ReadOptions::default()
    }
}

/// The numbers in a list of code or parameters.
pub fn numbers_of(text: &str) -> Vec<f64> {
    text.split([',', '{', '}', '[', ']', ';', ' ', '\n'])
        .filter_map(|word| word.trim().parse().ok())
        .collect()
}

/// The nine numbers and three of a constant matrix and vector in code.
fn affine(code: &str, matrix: &str, offset: &str) -> (Matrix, Vector) {
    let after = |mark: &str, count: usize| -> Option<Vec<f64>> {
        let rest = code.split_once(mark)?.1;
        let found = numbers_of(&rest[..rest.find(';')?]);
        assert_eq!(found.len(), count, "{mark}: {rest}");
        Some(found)
    };
    let m = after(matrix, 9).unwrap_or_else(|| IDENTITY.as_flattened().to_vec());
    let v = after(offset, 3).unwrap_or_else(|| vec![0.0; 3]);
    (std::array::from_fn(|i| std::array::from_fn(|j| m[3 * i + j])), [v[0], v[1], v[2]])
}

fn align(word: &str, [x, y, z]: Vector) -> Vector {
    match word {
        "CW0" => [x, y, z],
        "CW90" => [y, -x, z],
        "CW180" => [-x, -y, z],
        "CW270" => [-y, x, z],
        "CW0FLIP" => [-x, y, -z],
        "CW90FLIP" => [y, x, -z],
        "CW180FLIP" => [x, -y, -z],
        "CW270FLIP" => [-y, -x, -z],
        other => panic!("{other}"),
    }
}

/// The largest deviation of what the export makes of the source's numbers from what `apply` makes of them: µT, and µT that the
/// target may be off by since it holds less than the calibration.
fn deviation(case: &Case, form: &str) -> (f64, f64) {
    let Case { source, cal, log, corrected } = case;
    let options: &[&str] = if ["betaflight", "iio"].contains(&form) { &["--ut-per-count=0.05"] } else { &[] };
    let run = ironout(["export", text(cal), "--as", form, "--json"].iter().chain(options));
    assert_eq!(run.status, 0, "{} as {form}: {} {}", source.name, run.stdout, run.stderr);
    let object = run.json();
    let file = object["text"].as_str().expect("a file");
    let aligned = object["lost_rotation_deg"].as_f64();
    let (native, from_sensor) = source.native;
    let own = native == form;
    // In the axes in which the target keeps its numbers.
    let in_target = |row: usize| {
        let measured = source.measured_ut(row);
        if own { times(&transposed(&from_sensor), measured) } else { measured }
    };
    let mounting = if own { product(&source.from_source, &from_sensor) } else { source.from_source };
    let calibration = CalFile::read(cal).expect("a calibration").calibration().expect("sound");
    let angle_ut = 80.0 * (aligned.unwrap_or(0.0) + 0.01).to_radians();
    let worst = |rows: std::ops::Range<usize>, target: &dyn Fn(usize) -> (Vector, Vector)| {
        rows.map(|row| {
            let (own, wanted) = target(row);
            norm(std::array::from_fn(|axis| own[axis] - wanted[axis]))
        })
        .fold(0.0, f64::max)
    };
    let all = 0..source.numbers.len();
    // All of the magnitude, and all of the direction but for the rotation that the target has no room for.
    let but_for_a_rotation = |target: &dyn Fn(usize) -> (Vector, Vector)| {
        let magnitude = |row: usize| {
            let (own, wanted) = target(row);
            ([norm(own), 0.0, 0.0], [norm(wanted), 0.0, 0.0])
        };
        let direction = worst(all.clone(), target);
        assert!(
            aligned.is_none_or(|_| direction <= 1e-3 + angle_ut),
            "{} as {form}: {direction} µT",
            source.name
        );
        (worst(all.clone(), &magnitude), 1e-3)
    };
    match form {
        "px4" => {
            let p = px4(file);
            assert!(
                !(own && p.contains_key("CAL_MAG0_ROT")),
                "{}: the mounting is there already\n{file}",
                source.name
            );
            let get = |name: &str| p[&format!("CAL_MAG0_{name}")];
            let [a, b, c] = ["XSCALE", "YSCALE", "ZSCALE"].map(get);
            let [d, e, f] = ["XODIAG", "YODIAG", "ZODIAG"].map(get);
            let (off, s) = (["XOFF", "YOFF", "ZOFF"].map(get), [[a, d, e], [d, b, f], [e, f, c]]);
            let set = p.get("CAL_MAG0_ROT").map(|number| orientation(*number as usize));
            let turn = set.unwrap_or(if own { mounting } else { IDENTITY });
            let target = |row: usize| {
                let gauss = in_target(row).map(|ut| ut / 100.0);
                let centred = std::array::from_fn(|axis| gauss[axis] - off[axis]);
                (times(&turn, times(&s, centred)).map(|gauss| gauss * 100.0), corrected[row])
            };
            but_for_a_rotation(&target)
        }
        "ardupilot" => {
            let p = ardupilot(file);
            assert!(
                !(own && p.contains_key("COMPASS_ORIENT")),
                "{}: the mounting is there already\n{file}",
                source.name
            );
            let three = |part: &str| ["X", "Y", "Z"].map(|axis| p[&format!("COMPASS_{part}_{axis}")]);
            let (ofs, [a, b, c], [d, e, f]) = (three("OFS"), three("DIA"), three("ODI"));
            let m = [[a, d, e], [d, b, f], [e, f, c]];
            let set = p.get("COMPASS_ORIENT").map(|number| orientation(*number as usize));
            let orient = set.unwrap_or(if own { mounting } else { IDENTITY });
            let target = |row: usize| {
                let mg = times(&orient, in_target(row).map(|ut| ut * 10.0));
                let field = times(&m, std::array::from_fn(|axis| mg[axis] + ofs[axis]));
                (field.map(|mg| mg / 10.0), corrected[row])
            };
            but_for_a_rotation(&target)
        }
        "betaflight" => {
            // An offset alone: held against the field less the offset.
            let line = |key: &str| rows(file).find_map(|line| line.strip_prefix(&format!("set {key} = ")));
            let zero = numbers_of(line("mag_calibration").expect("an offset"));
            let word = line("align_mag");
            assert!(
                !(word.is_some() && source.name.contains("etaflight")),
                "align_mag is in the log already: {file}"
            );
            let to_body = if word.is_some() { LEFT_UP } else { source.from_source };
            let target = |row: usize| {
                let counts = align(word.unwrap_or("CW0"), in_target(row).map(|ut| ut / 0.05));
                let left: Vector = std::array::from_fn(|axis| (counts[axis] - zero[axis]) * 0.05);
                let field = log.field(row);
                (times(&to_body, left), std::array::from_fn(|axis| field[axis] - calibration.offset_ut[axis]))
            };
            // Half a count of each axis.
            (worst(all, &target), 0.025 * 3_f64.sqrt() + 1e-6)
        }
        "ros" => {
            let value = |key: &str| {
                numbers_of(
                    rows(file)
                        .find(|line| line.trim().starts_with(key))
                        .expect(key)
                        .split_once(": ")
                        .expect("a value")
                        .1,
                )
            };
            let bias = ["x", "y", "z"].map(|axis| value(&format!("initial_mag_bias_{axis}:"))[0]);
            let m = value("initial_mag_scaling_matrix:");
            let matrix: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| m[3 * i + j]));
            let target = |row: usize| {
                let tesla = in_target(row).map(|ut| ut * 1e-6);
                let unbiased = times(&matrix, std::array::from_fn(|axis| tesla[axis] - bias[axis]));
                (times(&source.from_source, unbiased.map(|tesla| tesla * 1e6)), corrected[row])
            };
            (worst(all, &target), 1e-4)
        }
        "iio" => {
            // A factor an axis: held on the offset, and on what the mount matrix turns.
            let value = |key: &str| {
                numbers_of(rows(file).find_map(|line| line.strip_prefix(&format!("{key}="))).expect(key))
            };
            let add = ["x", "y", "z"].map(|axis| value(&format!("in_magn_{axis}_offset"))[0]);
            let m = value("in_mount_matrix");
            let mount: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| m[3 * i + j]));
            let zero = times(&source.from_source, add.map(|counts| -counts * 0.05));
            let off = norm(std::array::from_fn(|axis| zero[axis] - calibration.offset_ut[axis]));
            let turned = product(&mount, &transposed(&source.from_source));
            let cosine = (turned[0][0] + turned[1][1] + turned[2][2] - 1.0) / 2.0;
            assert!(cosine > 3_f64.to_radians().cos(), "{}: {file}", source.name);
            (off, 1e-5)
        }
        "c" | "rust" => {
            let (matrix, offset) = if form == "c" {
                let plain = file.replace("(float)", "").replace("(ironout_real)", "");
                affine(&plain, "ironout_reading[3][3] = ", "ironout_reading_offset_ut[3] = ")
            } else {
                affine(file, "READING_F64: [[f64; 3]; 3] = ", "READING_OFFSET_UT_F64: [f64; 3] = ")
            };
            let target = |row: usize| {
                let measured = times(&matrix, source.numbers[row]);
                let measured = std::array::from_fn(|axis| measured[axis] + offset[axis]);
                (calibration.apply(measured), corrected[row])
            };
            (worst(source.last_from()..source.numbers.len(), &target), 1e-3)
        }
        _ => {
            let kept: Value = serde_json::from_str(file).expect("JSON");
            let frame: Frame = serde_json::from_value(kept["reading"]["frame"].clone()).expect("a frame");
            let time = log.time_s.as_ref().expect("a time");
            let target = |row: usize| {
                (calibration.apply(frame.body_ut(time[row], source.numbers[row])), corrected[row])
            };
            (worst(all, &target), 1e-3)
        }
    }
}

#[test]
fn every_export_undoes_what_every_reader_did_and_all_give_one_calibration() {
    let truth = Truth::new("frames");
    let mut table =
        format!("| read from | {} |\n|---|{}\n", EXPORTS.join(" | "), "---|".repeat(EXPORTS.len()));
    let mut first: Option<Value> = None;
    let mut wrong = Vec::new();
    for (index, source) in sources(&truth).into_iter().enumerate() {
        let here = folder(&format!("frames_{index}"));
        let case = case(source, &here);
        // The reader itself: the sensor's own field in body axes, to the rounding of the source.
        for row in 0..case.log.rows {
            let (read, own) = (case.log.field(row), truth.field(row));
            let off = norm(std::array::from_fn(|axis| read[axis] - own[axis]));
            assert!(off < 0.2, "{} row {row}: {read:?} for {own:?}", case.source.name);
        }
        let cal: Value =
            serde_json::from_str(&std::fs::read_to_string(&case.cal).expect("a file")).expect("JSON");
        if case.log.accel_mps2.is_some() {
            match &first {
                Some(first) => assert_same_calibration(first, &cal, 0.05, 2e-3),
                None => first = Some(cal),
            }
        } else {
            let offset = |value: &Value, axis: usize| value["offset_ut"][axis].as_f64().expect("a number");
            let first = first.as_ref().expect("one with an accelerometer");
            assert!(
                (0..3).all(|axis| (offset(&cal, axis) - offset(first, axis)).abs() < 0.05),
                "{}",
                case.source.name
            );
        }
        table += &format!("| {} |", case.source.name);
        for form in EXPORTS {
            let (off, most) = deviation(&case, form);
            table += &format!(" {} |", upwards(off));
            if off > most {
                wrong.push(format!("{} as {form}: {off} µT, at most {most}", case.source.name));
            }
        }
        table += "\n";
    }
    assert!(wrong.is_empty(), "{}\n{table}", wrong.join("\n"));
    assert_documented(&table);
}

/// A figure that does not hang on its last bits: one digit, rounded up.
fn upwards(off_ut: f64) -> String {
    if off_ut < 1e-9 {
        return "< 1e-9".into();
    }
    let unit = 10_f64.powf(off_ut.log10().floor());
    format!("{:.0e}", (off_ut / unit).ceil() * unit)
}

/// `docs/exports.md` has this table; `IRONOUT_ACCEPT=1` writes it there.
fn assert_documented(table: &str) {
    let (begin, end) = ("<!-- frames:begin -->\n", "<!-- frames:end -->");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/exports.md");
    let document = std::fs::read_to_string(path).expect("docs/exports.md");
    let (before, rest) = document.split_once(begin).expect("the mark where the table begins");
    let (own, after) = rest.split_once(end).expect("the mark where the table ends");
    if std::env::var_os("IRONOUT_ACCEPT").is_some() {
        std::fs::write(path, [before, begin, table, end, after].concat())
            .expect("docs/exports.md is written");
    } else {
        assert_eq!(
            own, table,
            "docs/exports.md has another table; IRONOUT_ACCEPT=1 writes the one that was measured"
        );
    }
}

#[test]
fn a_file_of_an_earlier_program_has_the_frame_that_its_options_make() {
    let here = folder("frames_earlier");
    let reading = serde_json::json!({"ut_per_count": [0.5, 0.5, 0.5], "rotate": ["yaw90"]});
    let old = CalFile::read(&cal(&here, &SYMMETRIC, &[], reading)).expect("a calibration");
    let frame = old.reading.expect("a reading").frame().expect("a frame");
    assert_eq!(frame.ut_per_number, [0.5; 3]);
    assert_eq!(frame.body_ut(0.0, [2.0, 4.0, 6.0]), [-2.0, 1.0, 3.0]);
    let broken = serde_json::json!({"ut_per_count": null, "rotate": [], "frame": {
        "ut_per_number": [1, 1, 1], "from_source": [[1, 0, 0], [1, 0, 0], [0, 0, 1]],
    }});
    let file = cal(&here, &SYMMETRIC, &[], broken);
    let error = ironout(["export", text(&file), "--as", "c", "--json"]).error();
    assert!(error["message"].as_str().is_some_and(|text| text.contains("not orthogonal")), "{error}");
    assert_ne!(inverse(&SYMMETRIC), SYMMETRIC);
}

#[test]
fn broken_files_of_the_new_formats_are_told_and_never_end_the_program() {
    let truth = Truth::new("frames_fuzz");
    let [telemetry, bag, samples] = short(&truth, 60);
    for (name, bytes) in [("telemetry", &telemetry), ("bag", &bag), ("samples", &samples)] {
        let scale = ReadOptions { ut_per_count: Some([0.1; 3]), ..ReadOptions::default() };
        let log = read_with(bytes, &scale).unwrap_or_else(|failure| panic!("{name}: {failure}"));
        assert!(log.rows > 40, "{name}: {}", log.rows);
    }
    // The samples are one object of JSON, which most changes spoil.
    for (name, bytes, least) in
        [("telemetry", &telemetry, 2000), ("rosbag2", &bag, 400), ("samples", &samples, 100)]
    {
        let accepted = fuzz(name, &[bytes], 4000);
        assert!(accepted > least, "{name}: {accepted}");
    }
}
