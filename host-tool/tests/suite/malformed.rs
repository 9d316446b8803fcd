//! Bad logs and bad usage: a message with place and remedy, the right exit status, nothing lost.

use crate::common::{folder, ironout, text, write};
use std::path::Path;

const HEADER: &str = "t_s,mx_ut,my_ut,mz_ut,temp_c\n";

/// Runs `fit --json` on this content and expects the error object with this line, column and words.
#[track_caller]
fn refused(name: &str, content: impl AsRef<[u8]>, line: Option<u64>, column: Option<&str>, words: &[&str]) {
    refused_with(name, content, line, column, words, &[]);
}

#[track_caller]
fn refused_with(
    name: &str,
    content: impl AsRef<[u8]>,
    line: Option<u64>,
    column: Option<&str>,
    words: &[&str],
    options: &[&str],
) {
    let log = write(&folder(name), "log.csv", content);
    let path = log.to_str().expect("text");
    let run = ironout(["fit", path, "--json"].iter().chain(options));
    let error = run.error();
    assert_eq!(error["line"].as_u64(), line, "{error}");
    assert_eq!(error["column"].as_str(), column, "{error}");
    assert_eq!(error["file"].as_str(), Some(path), "{error}");
    let message = error["message"].as_str().expect("words");
    for word in words {
        assert!(message.contains(word), "no {word:?} in {message:?}");
    }
    // To people: the same words on standard error, with file and line, and nothing on standard output.
    let run = ironout(["fit", path].iter().chain(options));
    assert_eq!((run.status, run.stdout.as_str()), (2, ""));
    let place = line.map_or(path.to_string(), |line| format!("{path}:{line}"));
    // Long messages are broken into lines.
    let told = run.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(told.contains(&place) && told.contains(words[0]), "{}", run.stderr);
}

#[test]
fn missing_column() {
    let content = "t_s,mx_ut,my_ut,temp_c\n0,1,2,3\n";
    refused(
        "missing_column",
        content,
        Some(1),
        Some("mz_ut"),
        &["mz_ut", "--map", "t_s, mx_ut, my_ut, temp_c"],
    );
}

#[test]
fn other_headers_are_answered_with_the_map_to_write() {
    // One row of small whole numbers: no unit fits, and counts of a sensor may be anything.
    let words = [
        "unit",
        "--map 'mx_ut=MagX[uT],my_ut=MagY[uT],mz_ut=MagZ[uT]'",
        "--map mx_counts=MagX,",
        "--ut-per-count",
    ];
    let content = "time,MagX,MagY,MagZ\n0,30,20,30\n0.02,31,20,30\n";
    refused("other_headers", content, Some(1), Some("MagX"), &words);
}

#[test]
fn counts_without_scale() {
    let content = "# raw\nt_s,mx_counts,my_counts,mz_counts\n0,1,2,3\n";
    refused("counts", content, Some(2), Some("mx_counts"), &["--ut-per-count"]);
}

#[test]
fn text_in_a_number() {
    let content = format!("{HEADER}0,1,2,3,20\n0.02,1,oops,3,20\n");
    refused("text", content, Some(3), Some("my_ut"), &["\"oops\" is not a number"]);
    let content = format!("{HEADER}zero,1,2,3,20\n");
    refused("text_time", content, Some(2), Some("t_s"), &["\"zero\" is not a number"]);
}

#[test]
fn nan_infinity_and_nothing_in_a_field() {
    for (name, cell) in [("nan", "NaN"), ("inf", "inf"), ("minus_inf", "-Infinity"), ("huge", "1e999")] {
        refused(
            name,
            format!("# a\n{HEADER}0,1,2,3,20\n1,{cell},2,3,20\n"),
            Some(4),
            Some("mx_ut"),
            &["not a finite number"],
        );
    }
    refused("nan_time", format!("{HEADER}nan,1,2,3,20\n"), Some(2), Some("t_s"), &["not a finite number"]);
    refused("empty_cell", format!("{HEADER}0,1,,3,20\n"), Some(2), Some("my_ut"), &["empty"]);
}

#[test]
fn mapped_columns_are_named_as_the_file_names_them() {
    let content = "when,X,Y,Z\n0,1,2,3\n1,1,nan,3\n";
    let map = ["--map", "t_s=when,mx_ut=X", "--map", "my_ut=Y,mz_ut=Z"];
    refused_with("mapped", content, Some(3), Some("Y"), &["finite"], &map);
    refused_with(
        "mapped_wrong",
        content,
        Some(1),
        None,
        &["no column \"W\"", "when, X, Y, Z"],
        &["--map", "mx_ut=W"],
    );
}

#[test]
fn empty_files() {
    refused("empty", "", None, None, &["the file is empty", "t_s,mx_ut"]);
    refused("only_comments", "# nothing\n\n# here\n", None, None, &["the file is empty"]);
    refused("header_only", HEADER, Some(1), None, &["no rows"]);
}

#[test]
fn a_line_of_a_million_columns() {
    refused("million", "a,".repeat(1_000_000), Some(1), None, &["longer than 262144 bytes"]);
    let content = format!("{HEADER}0,1,2,3,20\n{}\n", "1,".repeat(1_000_000));
    refused("million_below", content, Some(3), None, &["longer than 262144 bytes"]);
    let many: Vec<String> = (0..2000).map(|i| format!("c{i}")).collect();
    refused("two_thousand", many.join(",") + "\n", Some(1), None, &["2000 columns"]);
}

#[test]
fn binary_and_other_encodings() {
    let mut bytes: Vec<u8> = (0..5000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    bytes[100] = 0;
    refused("binary", &bytes, Some(1), None, &["not text"]);
    let mut late = format!("{HEADER}0,1,2,3,20\n").into_bytes();
    late.extend([b'1', 0, b'2']);
    refused("binary_late", &late, Some(1), None, &["not text"]);
    for (name, head, words) in [
        ("ulog", &b"ULog\x01\x12\x35\x01"[..], "ULog"),
        ("zip", b"PK\x03\x04rest", "unpack"),
        ("gzip", b"\x1f\x8b\x08", "empty"),
        ("sqlite", b"SQLite format 3\0", "SQLite"),
    ] {
        refused(name, head, None, None, &[words]);
    }
}

#[test]
fn ragged_rows_and_open_quotes() {
    refused(
        "short_row",
        format!("{HEADER}0,1,2,3,20\n1,2,3\n2,1,2,3,20\n"),
        Some(3),
        None,
        &["3 cells, but the header has 5"],
    );
    refused("long_row", format!("{HEADER}0,1,2,3,20,9\n"), Some(2), None, &["6 cells, but the header has 5"]);
    refused("cut_off", format!("{HEADER}0,1,2,3,20\n1,2,3"), Some(3), None, &["cut off"]);
    refused("quote", format!("{HEADER}0,1,2,3,\"20\n1,1,2,3,20\n"), Some(2), None, &["quote"]);
}

#[test]
fn columns_twice_and_no_names() {
    refused("twice", "t_s,mx_ut,my_ut,mz_ut,mx_ut\n0,1,2,3,4\n", Some(1), Some("mx_ut"), &["twice"]);
    let words = ["unit", "--map 'mx_ut=column 2[", "--ut-per-count"];
    refused("no_header", "0,1,20,30\n0.02,2,30,40\n", Some(1), Some("2"), &words);
    refused("two_times", "t_s,t_us,mx_ut,my_ut,mz_ut\n0,0,1,2,3\n", Some(1), None, &["both t_s and t_us"]);
}

#[test]
fn time_running_backward() {
    let content = format!("{HEADER}0,1,2,3,20\n2,1,2,4,20\n1,1,2,5,20\n");
    refused("backward", content, Some(4), Some("t_s"), &["time runs backward, 1 after 2"]);
}

#[test]
fn files_that_cannot_be_read() {
    let run = ironout(["fit", "no/such/log.csv", "--json"]);
    assert!(run.error()["message"].as_str().is_some_and(|m| m.contains("no such file")));
    let here = folder("a_folder");
    let run = ironout(["fit", here.to_str().expect("text"), "--json"]);
    assert!(run.error()["message"].as_str().is_some_and(|m| m.contains("folder")));
}

#[test]
fn usage_errors_are_status_2_and_objects_with_json() {
    for arguments in [
        vec!["frobnicate", "--json"],
        vec!["fit", "--json"],
        vec!["fit", "log.csv", "--nonsense", "--json"],
        vec!["fit", "log.csv", "--method", "magic", "--json"],
        vec!["fit", "log.csv", "--field", "-3", "--json"],
        vec!["fit", "log.csv", "--field", "nan", "--json"],
        vec!["fit", "log.csv", "--at", "0,0,yesterday", "--json"],
        vec!["fit", "log.csv", "--ut-per-count", "0", "--json"],
        vec!["fit", "log.csv", "--ut-per-count", "1,2", "--json"],
        vec!["fit", "log.csv", "--rotate", "sideways", "--json"],
        vec!["fit", "log.csv", "--map", "mx_ut", "--json"],
        vec!["simulate", "-o", "x.csv", "--seconds", "-1", "--json"],
        vec!["simulate", "-o", "x.csv", "--effect", "gremlins", "--json"],
        vec!["simulate", "-o", "x.csv", "--seconds", "1e9", "--json"],
    ] {
        let error = ironout(&arguments).error();
        assert!(error["message"].as_str().is_some_and(|m| m.len() > 20), "{arguments:?}: {error}");
    }
    for arguments in [vec!["frobnicate"], vec![]] {
        let run = ironout(&arguments);
        assert_eq!((run.status, run.stdout.as_str()), (2, ""), "{arguments:?}");
    }
    for arguments in [vec!["--help"], vec!["fit", "--help"], vec!["--version"]] {
        assert_eq!(ironout(&arguments).status, 0);
    }
}

/// Run by no cargo: that one would have the page built.
#[cfg(not(feature = "page"))]
#[test]
fn a_program_without_the_page_says_how_to_get_one_and_writes_nothing() {
    let here = folder("no_page");
    let log = write(&here, "log.csv", "mx_ut,my_ut,mz_ut\n1,2,3\n");
    let out = here.join("report.html");
    for arguments in [
        vec!["report", text(&log), "-o", text(&out)],
        vec!["web", "-o", text(&out)],
        vec!["live", "--tcp", "x"],
    ] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_ironout"));
        let run = command.env_remove("CARGO").args(&arguments).output().expect("the command starts");
        let said = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.code() == Some(2) && said.contains("--features page"), "{arguments:?}: {said}");
        assert!(!out.exists(), "{arguments:?}");
    }
}

#[cfg(feature = "page")]
#[test]
fn a_page_that_cannot_be_made_says_why() {
    let here = folder("bad_page");
    let log = write(&here, "log.csv", "mx_ut,my_ut,mz_ut\n1,2,3\n");
    let out = here.join("report.html");
    for (arguments, part) in [
        (vec!["report", text(&log)], "--output"),
        (vec!["report", "no such log", "-o", text(&out)], "no such file"),
        (vec!["report", text(&log), "-o", text(&log)], "would overwrite the input file"),
        (vec!["report", text(&log), "-o", text(&out), "--method", "trace"], "adjusted"),
        (vec!["live"], "--qemu"),
        (vec!["live", "--port", "x", "--tcp", "y"], "cannot be used with"),
        (vec!["live", "--replay", text(&log)], "time column"),
        (vec!["live", "--replay", text(&log), "--speed", "0"], "--speed 0"),
        (vec!["live", "--tcp", "x", "--hidden", "step"], "cannot be used with"),
        (vec!["live", "--qemu", "--hidden", "current"], "--hidden current"),
    ] {
        let run = ironout(arguments.iter().chain(&["--json"]));
        assert!(
            run.error()["message"].as_str().is_some_and(|m| m.contains(part)),
            "{arguments:?}: {}",
            run.stdout
        );
        assert!(!out.exists(), "{arguments:?}");
    }
}

#[test]
fn a_bad_calibration_file_is_named() {
    let here = folder("bad_cal");
    let log = write(&here, "log.csv", format!("{HEADER}0,1,2,3,20\n"));
    let log = log.to_str().expect("text");
    for (name, content, words) in [
        ("empty.json", "", "empty"),
        ("cut.json", "{\"version\": 1,\n\"method\":", "damaged JSON"),
        ("other.json", "{\"hello\": 1}", "version"),
        ("future.json", "{\"version\": 99}", "version 99"),
    ] {
        let cal = write(&here, name, content);
        for command in ["apply", "check"] {
            let error = ironout([command, log, "--cal", cal.to_str().expect("text"), "--json"]).error();
            assert!(error["message"].as_str().is_some_and(|m| m.contains(words)), "{name}: {error}");
            assert_eq!(error["file"].as_str().map(Path::new), Some(cal.as_path()));
        }
    }
    let binary = write(&here, "binary.json", [0xff, 0xfe, 0x00, 0x80]);
    assert_eq!(ironout(["export".as_ref(), binary.as_os_str(), "--as".as_ref(), "c".as_ref()]).status, 2);
}

#[test]
fn a_long_cell_is_not_echoed_whole() {
    for cell in ["9".repeat(100_000), "x".repeat(100_000)] {
        let content = format!("{HEADER}0,1,2,3,20\n1,{cell},2,3,20\n");
        let log = write(&folder("long_cell"), "log.csv", content);
        let error = ironout(["fit", log.to_str().expect("text"), "--json"]).error();
        let message = error["message"].as_str().expect("words");
        assert!(message.contains(&cell[..100]) && message.len() < 500, "{message}");
    }
}

#[test]
fn an_answer_that_cannot_be_written_is_a_failure() {
    use std::process::{Command, Stdio};
    // A device that is always full; other systems have none.
    let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") else {
        use std::io::Write;
        let _ = writeln!(std::io::stderr(), "SKIPPED: there is no /dev/full here");
        return;
    };
    for arguments in [&["--help"][..], &["--version"], &["fit", "no such log", "--json"]] {
        let output = Command::new(env!("CARGO_BIN_EXE_ironout"))
            .args(arguments)
            .stdout(Stdio::from(full.try_clone().expect("one more handle")))
            .output()
            .expect("the command starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains("cannot write to standard output"), "{arguments:?}: {said}");
    }
}

#[test]
fn help_and_version_are_objects_too() {
    for (option, key, words) in [("--help", "help", "Usage"), ("--version", "version", "ironout")] {
        let run = ironout([option, "--json"]);
        assert_eq!(run.status, 0);
        assert!(run.json()[key].as_str().is_some_and(|text| text.contains(words)), "{}", run.stdout);
    }
}

#[test]
fn a_column_mapped_to_no_sensor_is_pointed_out() {
    let log = write(&folder("map_covariate"), "log.csv", format!("{HEADER}0,1,2,3,20\n"));
    let path = log.to_str().expect("text");
    let run = ironout(["fit", path, "--map", "bogus=temp_c"]);
    assert!(run.said().contains("reads temp_c as the covariate bogus"), "{}", run.stderr);
    let run = ironout(["fit", path, "--map", "my_ut=my_ut"]);
    assert!(!run.said().contains("as the covariate"), "{}", run.stderr);
}
