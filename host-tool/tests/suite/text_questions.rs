//! Text logs that can be read in two ways, or in none: what is asked, what is said, and what hostile input gets.

use crate::common::{folder, ironout, simulate, text, write};
use crate::corpus::{Row, lines, rows};
use ironout_cli::failure::Failure;
use ironout_cli::input::{Log, ReadOptions, parse_map, read_stream};
use ironout_cli::read_block;
use rand::{RngExt, SeedableRng, rngs::ChaCha12Rng};

fn read(content: &str, map: &[&str]) -> Result<Log, Failure> {
    let map: Vec<String> = map.iter().map(|part| part.to_string()).collect();
    let options = ReadOptions { map: parse_map(&map)?, ..ReadOptions::default() };
    read_stream(content.as_bytes(), 0, &options)
}

#[track_caller]
fn asked(content: &str, words: &[&str]) -> Failure {
    let failure = read(content, &[]).map(|log| read_block::text(&log)).expect_err("a question");
    assert_eq!(failure.exit, 2);
    for word in words {
        assert!(failure.message.contains(word), "no {word:?} in {failure}");
    }
    assert!(failure.message.lines().all(|line| line.len() < 160), "{failure}");
    failure
}

fn table(header: &str, line: impl FnMut(usize, &Row) -> String) -> String {
    format!("{header}\n{}", lines(&rows(), line))
}

#[test]
fn whole_numbers_may_be_milligauss_or_counts_and_either_answer_reads() {
    let log = table("t_ms,MagX,MagY,MagZ", |_, r| {
        format!("{:.0},{:.0},{:.0},{:.0}", r.t * 1e3, r.m[0] * 10.0, r.m[1] * 10.0, r.m[2] * 10.0)
    });
    let failure = asked(&log, &["--map 'mx_ut=MagX[mG],my_ut=MagY[mG],mz_ut=MagZ[mG]'", "--ut-per-count"]);
    assert_eq!((failure.line, failure.column.as_deref()), (Some(1), Some("MagX")));
    let log = read(&log, &["mx_ut=MagX[mG],my_ut=MagY[mG],mz_ut=MagZ[mG]"]).expect("stated");
    assert_eq!(log.time_s.as_ref().map(|t| t[1]), Some(0.02));
}

#[test]
fn a_step_of_one_may_be_a_second_or_a_millisecond() {
    let log = table("time;MagX (uT);MagY (uT);MagZ (uT)", |index, r| {
        format!("{index};{:.3};{:.3};{:.3}", r.m[0], r.m[1], r.m[2])
    });
    asked(&log, &["--map 't_s=time[s]'", "--map 't_s=time[ms]'"]);
    let log = read(&log, &["t_s=time[ms]"]).expect("stated");
    assert_eq!(log.time_s.as_ref().map(|t| t[1000]), Some(1.0));
}

#[test]
fn milliseconds_are_never_read_as_seconds() {
    let log =
        table("t_ms,mx_ut,my_ut,mz_ut", |_, r| format!("{:.0},{},{},{}", r.t * 1e3, r.m[0], r.m[1], r.m[2]));
    for map in [&["t_s=t_ms"][..], &[]] {
        let log = read(&log, map).expect("a log");
        assert_eq!(log.time_s.as_ref().map(|t| t[50]), Some(1.0), "{map:?}");
        assert!(log.covariates.is_empty(), "{map:?}");
        assert!(read_block::text(&log).contains("t_s from t_ms, in ms"), "{}", read_block::text(&log));
    }
    let log = read(&log, &["t_s=t_ms[us]"]).expect("stated");
    assert_eq!(log.time_s.as_ref().map(|t| t[50]), Some(1e-3));
    // A time under another name is time, too, and not a covariate.
    let log = table("timestamp,mx_ut,my_ut,mz_ut", |_, r| {
        format!("{:.0},{},{},{}", r.t * 1e6, r.m[0], r.m[1], r.m[2])
    });
    let log = read(&log, &[]).expect("a log");
    assert!(log.time_s.is_some_and(|t| t[50] == 1.0) && log.covariates.is_empty());
}

#[test]
fn a_program_whose_unit_cannot_be_is_a_question() {
    // A driver that publishes µT where the message says T.
    let log = table("Time,magnetic_field.x,magnetic_field.y,magnetic_field.z", |_, r| {
        format!("{:.3},{:.3},{:.3},{:.3}", r.t, r.m[0], r.m[1], r.m[2])
    });
    asked(&log, &["ROS messages write T", "mx_ut=magnetic_field.x[uT]"]);
}

#[test]
fn numbers_without_names_that_may_be_either_sensor_are_a_question() {
    let log = lines(&rows(), |_, r| {
        let other = r.m.map(|v| 1.1 * v - 90.0);
        format!("{:.3},{:.3},{:.3},{:.3},{:.3},{:.3}", other[2], other[0], other[1], r.m[0], r.m[1], r.m[2])
    });
    let words = ["which columns", "mx_ut=column 1[uT]", "mx_ut=column 4[uT]"];
    asked(&log, &words);
    assert!(read(&log, &["mx_ut=column 4[uT],my_ut=column 5[uT],mz_ut=column 6[uT]"]).is_ok());
}

#[test]
fn no_magnetometer_says_what_was_looked_for_and_what_is_there() {
    let log = table("time_s,AccX,AccY,AccZ,throttle", |_, r| {
        format!("{:.2},{},{},{},0.5", r.t, r.a[0], r.a[1], r.a[2])
    });
    let failure =
        asked(&log, &["no magnetometer found", "looked for", "time_s, AccX, AccY, AccZ, throttle", "--map"]);
    assert_eq!(failure.line, Some(1));
    let log = table("t,x,y,z", |_, r| format!("{:.2},{},{},{}", r.t, r.a[0], r.a[1], r.a[2]));
    asked(&log, &["1 g", "accelerometer"]);
    let log = table("time_s,MagX (uT),MagY (uT),temp", |_, r| {
        format!("{:.2},{},{},{}", r.t, r.m[0], r.m[1], r.temp)
    });
    asked(&log, &["mz_ut is missing", "MagX (uT)"]);
    asked("Booting\nReady.\nwaiting for sensor\n", &["the format is unknown", "looked for", "Booting"]);
    asked("Time (s);MagX (uT);MagY (uT);MagZ (uT)\n", &["no rows"]);
    let log = table("t_s;mx;my;mz", |_, r| {
        let n = r.m.iter().map(|v| v * v).sum::<f64>().sqrt();
        format!("{:.2};{:.6};{:.6};{:.6}", r.t, r.m[0] / n, r.m[1] / n, r.m[2] / n)
    });
    asked(&log, &["normalised"]);
}

#[test]
fn a_gyroscope_of_two_possible_units_is_left_out_with_both_options() {
    let log = table("t_s,MagX_uT,MagY_uT,MagZ_uT,GyroX,GyroY,GyroZ", |_, r| {
        format!("{:.2},{},{},{},{},{},{}", r.t, r.m[0], r.m[1], r.m[2], r.g[0], r.g[1], r.g[2])
    });
    let found = read(&log, &[]).expect("a log");
    let said = read_block::text(&found);
    assert!(found.gyro_radps.is_none() && found.covariates.is_empty());
    assert!(said.contains("gx_radps=GyroX[rad/s]") && said.contains("gx_radps=GyroX[deg/s]"), "{said}");
    let found =
        read(&log, &["gx_radps=GyroX[deg/s],gy_radps=GyroY[deg/s],gz_radps=GyroZ[deg/s]"]).expect("stated");
    assert!(found.gyro_radps.is_some());
}

#[test]
fn rows_that_are_none_are_left_out_and_counted() {
    let mut broken = table("time_s;MagX_uT;MagY_uT;MagZ_uT", |index, r| match index {
        10 => "wifi: lost".to_string(),
        20 => format!("{:.3};1.0;2.0", r.t),
        30 | 31 => format!("{:.3};nan;{};{}", r.t, r.m[1], r.m[2]),
        40 => format!("{:.3};{};{};{}", r.t - 0.5, r.m[0], r.m[1], r.m[2]),
        _ => format!("{:.3};{};{};{}", r.t, r.m[0], r.m[1], r.m[2]),
    });
    broken.push_str("30.0;1.5");
    let log = read(&broken, &[]).expect("a log");
    assert_eq!(log.rows, rows().len() - 5);
    let left: Vec<(usize, Option<u64>)> =
        log.read_as.left_out.iter().map(|entry| (entry.rows, entry.first_line)).collect();
    assert_eq!(left.iter().map(|(rows, _)| rows).sum::<usize>(), 6, "{:?}", log.read_as.left_out);
    for line in [12, 22, 32, 42] {
        assert!(
            left.contains(&(1, Some(line))) || left.contains(&(2, Some(line))),
            "{line}: {:?}",
            log.read_as.left_out
        );
    }
    // Two recordings in one file have no common time: the log is read without, and that is said with the place.
    let once = table("time_s;MagX_uT;MagY_uT;MagZ_uT", |_, r| {
        format!("{:.3};{};{};{}", r.t, r.m[0], r.m[1], r.m[2])
    });
    let log = read(&format!("{once}{once}"), &[]).expect("a log");
    assert_eq!(log.time_s, None);
    let said = log.read_as.not_read.join(" ");
    let place = format!("line {}", rows().len() + 3);
    assert!(said.contains("it decreases in 1499 of 3000 rows") && said.contains(&place), "{said}");
}

#[test]
fn what_holds_the_field_is_no_covariate() {
    let norm = |r: &Row| r.m.iter().map(|v| v * v).sum::<f64>().sqrt();
    let log = table("time_s,MagX_uT,MagY_uT,MagZ_uT,Total,value,Azimuth,throttle", |index, r| {
        format!(
            "{:.2},{},{},{},{},{},{},{}",
            r.t,
            r.m[0],
            r.m[1],
            r.m[2],
            norm(r),
            norm(r) * 10.0,
            index % 360,
            index % 11
        )
    });
    let log = read(&log, &[]).expect("a log");
    let names: Vec<&str> = log.covariates.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["throttle"], "{}", read_block::text(&log));
}

#[test]
fn a_column_that_runs_forward_is_no_axis() {
    // z is text, and what is left are time, x and y.
    let log = lines(&rows(), |_, r| format!("{:.3},{:.3},{:.3},{:.3}oops", r.t, r.m[0], r.m[1], r.m[2]));
    asked(&log, &["no magnetometer found"]);
}

#[test]
fn commas_between_cells_and_in_numbers_cannot_be_told_apart() {
    let log = table("time,MagX,MagY,MagZ", |_, r| {
        format!("{:.3},{:.2},{:.2},{:.2}", r.t, r.m[0], r.m[1], r.m[2]).replace('.', ",")
    });
    assert_eq!(asked(&log, &["half as many names", "semicolons"]).line, Some(1));
}

#[test]
fn instances_are_never_mixed_and_a_wrong_one_is_named() {
    let log = table("t_ms,I,MagX_mG,MagY_mG,MagZ_mG", |_, r| {
        let m = r.m.map(|v| v * 10.0);
        format!("{0:.0},1,{1},{2},{3}\n{0:.0},3,{2},{1},{3}", r.t * 1e3, m[0], m[1], m[2])
    });
    let found = read(&log, &[]).expect("a log");
    assert_eq!(found.rows, rows().len());
    let instance = found.read_as.instance.as_ref().expect("two sensors");
    assert_eq!((instance.taken, instance.there.iter().map(|(n, _)| *n).collect::<Vec<_>>()), (1, vec![1, 3]));
    let with = |number| {
        read_stream(log.as_bytes(), 0, &ReadOptions { instance: Some(number), ..ReadOptions::default() })
    };
    let other = with(3).expect("a log");
    assert_eq!((other.field_ut[0][7], other.field_ut[1][7]), (found.field_ut[1][7], found.field_ut[0][7]));
    let own = log.replace("t_ms,I,MagX_mG,MagY_mG,MagZ_mG", "t_ms,instance,mx_mg,my_mg,mz_mg");
    let split = read(&own, &[]).expect("a log");
    assert_eq!((split.rows, &split.field_ut), (found.rows, &found.field_ut));
    assert!(with(2).expect_err("none").message.contains("there are 1 (1500 rows), 3 (1500 rows)"));
}

#[test]
fn the_commands_take_any_format_and_apply_writes_it_as_csv() {
    let here = folder("any_format");
    let own = simulate(&here, "own.csv", &["--seed", "11", "--seconds", "30"]);
    let phone = write(
        &here,
        "phone.txt",
        table("Time (s);X (µT);Y (µT);Z (µT)", |_, r| {
            format!("{:.3};{:.3};{:.3};{:.3}", r.t, r.m[0], r.m[1], r.m[2]).replace('.', ",")
        }),
    );
    let (cal, out, csv) = (here.join("cal.json"), here.join("out.csv"), here.join("log.csv"));
    let fit = ironout(["fit", text(&phone), "-o", text(&cal)]);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    for command in ["apply", "check"] {
        let run = ironout([command, text(&phone), "--cal", text(&cal), "--json"]);
        assert_eq!((run.status, run.stderr.as_str()), (0, ""), "{}", run.stdout);
        assert!(run.json()["read_as"]["format"].as_str().is_some_and(|words| words.contains("semicolons")));
    }
    assert!(ironout(["diagnose", text(&phone), "--json"]).json()["read_as"]["pins"].is_array());
    let apply = ironout(["apply", text(&phone), "--cal", text(&cal), "-o", text(&out)]);
    assert_eq!(apply.status, 0, "{}", apply.stderr);
    let corrected = std::fs::read_to_string(&out).expect("the corrected log");
    assert!(
        corrected.contains("\nt_s,mx_ut,my_ut,mz_ut,cx_ut,cy_ut,cz_ut,norm_ut,residual_ut\n"),
        "{}",
        &corrected[..600]
    );
    // What import writes is the program's own, to the bit.
    let import = ironout(["import", text(&phone), "-o", text(&csv)]);
    assert_eq!(import.status, 0, "{}", import.stderr);
    let object = |log: &std::path::Path| ironout(["fit", text(log), "--json"]).json();
    assert_eq!(object(&csv)["offset_ut"], object(&phone)["offset_ut"]);
    assert_eq!(object(&csv)["read_as"]["format"], "CSV of this program");
    let printed = ironout(["import", text(&phone), "-o", "-"]);
    assert_eq!(printed.stdout, std::fs::read_to_string(&csv).expect("the CSV"));
    assert!(!std::path::Path::new("-").exists());
    // The own format keeps its one line.
    let run = ironout(["fit", text(&own)]);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    // Standard input.
    let piped = std::process::Command::new("sh")
        .args(["-c", &format!("'{}' fit - --json < '{}'", env!("CARGO_BIN_EXE_ironout"), text(&phone))])
        .output()
        .expect("a shell");
    let piped: serde_json::Value = serde_json::from_slice(&piped.stdout).expect("an object");
    assert_eq!(piped["offset_ut"], object(&phone)["offset_ut"]);
}

/// Every format with bytes changed, cut, doubled and moved: a sound log, or an error with words; never a panic.
#[test]
fn damaged_logs_of_every_format_are_read_or_refused() {
    let few: Vec<Row> = rows().into_iter().step_by(37).collect();
    let samples = crate::corpus::all(&few);
    let cases: u64 =
        std::env::var("IRONOUT_FUZZ_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(4000);
    let tokens: [&[u8]; 24] = [
        b"",
        b"\n",
        b"\r",
        b"\0",
        b"\"",
        b",",
        b";",
        b"\t",
        b" ",
        b":",
        b"=",
        b"[",
        b"]",
        b"{",
        b"}",
        b"nan",
        b"1e999",
        b"-",
        b"\xff\xfe",
        b"\xef\xbb\xbf",
        b"99999999999999999999",
        b"Raw:",
        b"R,",
        b"12:34:56.789 -> ",
    ];
    let (mut good, mut refused) = (0, 0);
    for case in 0..cases {
        let mut rng = ChaCha12Rng::seed_from_u64(case);
        let mut below = |n: usize| rng.random_range(0..n.max(1));
        let sample = &samples[below(samples.len())];
        let mut bytes = sample.bytes.clone();
        for _ in 0..=below(8) {
            let at = below(bytes.len() + 1);
            let end = (at + below(60)).min(bytes.len());
            match below(6) {
                0 => bytes.truncate(at),
                1 => drop(bytes.drain(at..end)),
                2 => {
                    let copy = bytes[at..end].to_vec();
                    let to = below(bytes.len() + 1);
                    bytes.splice(to..to, copy);
                }
                3 if at < bytes.len() => bytes[at] ^= 1 << below(8),
                _ => drop(bytes.splice(at..at, tokens[below(tokens.len())].iter().copied())),
            }
        }
        match read_stream(bytes.as_slice(), 0, &sample.options()) {
            Ok(log) => {
                good += 1;
                assert!(
                    log.rows > 0 && log.field_ut.iter().all(|column| column.len() == log.rows),
                    "case {case}"
                );
                assert!(log.field_ut.iter().flatten().all(|value| value.is_finite()), "case {case}");
                assert!(log.covariates.iter().all(|column| column.values.len() == log.rows), "case {case}");
                assert!(
                    log.time_s.iter().all(|t| t.windows(2).all(|pair| pair[0] <= pair[1])),
                    "case {case}"
                );
                assert!(!read_block::text(&log).is_empty());
            }
            Err(failure) => {
                refused += 1;
                assert!(failure.exit == 2 && failure.message.len() > 10, "case {case}: {failure}");
            }
        }
    }
    assert!(good > cases / 4 && refused > cases / 100, "{good} read, {refused} refused");
}
