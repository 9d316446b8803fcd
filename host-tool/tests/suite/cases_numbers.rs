//! Broken numbers in a log: said, mended by one option, and read alike by `apply` and `check`.

use crate::common::{case, folder, ironout, recording, text, write};
use std::path::Path;

/// The truth of the cases: a board with this offset, µT.
const OFFSET_UT: [f64; 3] = [12.0, -25.0, 31.0];

/// The option behind `Fix:`.
fn remedy(stderr: &str) -> Vec<String> {
    let line =
        stderr.lines().skip_while(|line| !line.contains("Fix:")).find(|line| line.trim().starts_with("--"));
    let line = line.unwrap_or_else(|| panic!("no remedy in {stderr}"));
    line.split_whitespace().map(|part| part.trim_matches('\'').to_string()).collect()
}

fn offset_is(json: &serde_json::Value, expected: [f64; 3], what: &str) {
    let found: Vec<f64> =
        json["offset_ut"].as_array().expect("an offset").iter().filter_map(|v| v.as_f64()).collect();
    let near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 0.3);
    assert!(near && json["accepted"] == true, "{what}: {found:?}, not {expected:?}");
}

#[test]
fn unsigned_swapped_and_wrapped_counts_are_said_and_mended_by_the_option_that_is_printed() {
    for (name, scale, told, expected) in [
        ("05_uint16.csv", "0.092", "above 32767 are negative (subtract 65536)", OFFSET_UT),
        ("06_byteswap.csv", "0.092", "two bytes", OFFSET_UT),
        ("07_wrap16.csv", "0.01", "they jump by 65536", [310.0, -25.0, 31.0]),
    ] {
        let Some(log) = case(name) else { return };
        let run = ironout(["fit", text(&log), "--ut-per-count", scale]);
        let said = run.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(run.status == 2 && said.contains(told), "{name}: {}", run.stderr);
        assert!(!said.contains("ut-per-count") && !said.contains("rotate the"), "{name}: {}", run.stderr);
        let here = folder(&format!("cases_numbers_{}", &name[..2]));
        let cal = here.join("cal.json");
        let mut options = vec!["fit", text(&log), "--ut-per-count", scale, "--json", "-o", text(&cal)];
        let found = remedy(&run.stderr);
        options.extend(found.iter().map(String::as_str));
        let run = ironout(&options);
        assert_eq!(run.status, 0, "{name}: {}", run.stderr);
        offset_is(&run.json(), expected, name);
        // The calibration knows how its log was read.
        let run = ironout(["apply", text(&log), "--cal", text(&cal), "--json"]);
        assert_eq!(run.status, 0, "{name}: {}", run.stderr);
        let after = run.json()["after"]["rms_percent"].as_f64().expect("a number");
        assert!(after < 1.5, "{name}: {after} %");
        assert_eq!(ironout(["check", text(&log), "--cal", text(&cal), "--json"]).status, 0, "{name}");
    }
}

#[test]
fn rows_of_zeros_are_set_aside_counted_and_said() {
    let Some(log) = case("04_zero_rows.csv") else { return };
    let here = folder("cases_numbers_04");
    let cal = here.join("cal.json");
    let run = ironout(["fit", text(&log), "-o", text(&cal)]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    assert!(
        run.said().contains("skipped: 82 lines: 0, 0, 0 in the three axes is an error code"),
        "{}",
        run.stderr
    );
    let run = ironout(["fit", text(&log), "--json"]);
    offset_is(&run.json(), OFFSET_UT, "zeros");
    assert_eq!(run.json()["read_as"]["left_out"][0]["rows"], 82);
    let out = here.join("corrected.csv");
    let run = ironout(["apply", text(&log), "--cal", text(&cal), "-o", text(&out)]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let rows = std::fs::read_to_string(&out).expect("written");
    assert_eq!(rows.lines().filter(|line| !line.starts_with('#')).count(), 1 + 800 - 82);
    // As they are, they spoil the fit: nothing else set them aside.
    assert_eq!(ironout(["fit", text(&log), "--repair", "none"]).status, 1);
}

#[test]
fn a_lost_low_byte_is_said_with_its_share_of_the_field() {
    let Some(log) = case("13_low_byte_lost.csv") else { return };
    for command in ["fit", "diagnose"] {
        let run = ironout([command, text(&log), "--ut-per-count", "3.413"]);
        let said = run.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains("steps of 3.41 µT, 7 % of the field") && said.contains("low byte"), "{said}");
    }
}

/// The rows of a case with its counts changed.
fn changed(
    from: &Path,
    here: &Path,
    name: &str,
    by: impl Fn(usize, [f64; 3]) -> [f64; 3],
) -> std::path::PathBuf {
    let content = std::fs::read_to_string(from).expect("text");
    let mut out = String::new();
    for (row, line) in content.lines().enumerate() {
        let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
        if row > 0 {
            let own = [1, 2, 3].map(|at: usize| cells[at].parse::<f64>().expect("a number"));
            cells.splice(1..4, by(row - 1, own).map(|value| value.to_string()));
        }
        out.push_str(&cells.join(","));
        out.push('\n');
    }
    write(here, name, out)
}

#[test]
fn other_scales_axes_and_kinds_end_in_a_fit() {
    let Some(log) = case("cal_log.csv") else { return };
    let here = folder("cases_numbers_variants");
    let round = |m: [f64; 3], scale: f64| m.map(|v| (v / scale).round());
    let bits = 4096.0;
    // Name, scale; whether it is mended without an option.
    type By = Box<dyn Fn(usize, [f64; 3]) -> [f64; 3]>;
    let list: [(&str, f64, bool, By); 8] = [
        (
            "one_axis_unsigned",
            0.3,
            false,
            Box::new(move |_, m| {
                let [x, y, z] = round(m, 0.3);
                [x, y.rem_euclid(65_536.0), z]
            }),
        ),
        ("twelve_bits", 0.15, false, Box::new(move |_, m| round(m, 0.15).map(|v| v.rem_euclid(bits)))),
        (
            "one_axis_swapped",
            0.05,
            false,
            Box::new(move |_, m| {
                let [x, y, z] = round(m, 0.05);
                [x, y, f64::from((z as i16).swap_bytes())]
            }),
        ),
        (
            "overflow_code",
            0.092,
            true,
            Box::new(move |row, m| {
                let [x, y, z] = round(m, 0.092);
                [if row % 17 == 3 { -4096.0 } else { x }, y, z]
            }),
        ),
        (
            "every_tenth",
            0.1,
            true,
            Box::new(move |row, m| round(m, 0.1).map(|v| if row % 10 == 7 { 3.0 * v + 977.0 } else { v })),
        ),
        (
            "range_doubled",
            0.01,
            false,
            Box::new(move |row, m| round(m, 0.01).map(|v| if row >= 400 { (v * 2.0).round() } else { v })),
        ),
        (
            "range_tenth",
            0.01,
            false,
            Box::new(move |row, m| round(m, 0.01).map(|v| if row >= 250 { (v * 0.1).round() } else { v })),
        ),
        (
            "two_faults",
            0.092,
            false,
            Box::new(move |row, m| {
                if row % 23 == 2 { [65_535.0; 3] } else { round(m, 0.092).map(|v| v.rem_euclid(65_536.0)) }
            }),
        ),
    ];
    for (name, scale, by_itself, by) in &list {
        let broken = changed(&log, &here, &format!("{name}.csv"), by);
        let scale = scale.to_string();
        let map = "--map=mx_counts=mx_ut,my_counts=my_ut,mz_counts=mz_ut";
        let mut options = vec![
            "fit".to_string(),
            text(&broken).into(),
            map.into(),
            "--ut-per-count".into(),
            scale,
            "--json".into(),
        ];
        if !by_itself {
            let run = ironout(options.iter().filter(|option| *option != "--json"));
            assert_eq!(run.status, 2, "{name}: {}", run.stderr);
            options.extend(remedy(&run.stderr));
        }
        let run = ironout(&options);
        assert_eq!(run.status, 0, "{name}: {} {}", run.stderr, run.stdout);
        offset_is(&run.json(), OFFSET_UT, name);
    }
}

#[test]
fn a_repair_of_numbers_that_were_right_is_undone() {
    let Some(log) = case("05_uint16.csv") else { return };
    let run = ironout(["fit", text(&log), "--ut-per-count", "0.092", "--repair", "unsigned,swapped-bytes"]);
    assert_eq!(run.status, 2, "{}", run.stdout);
    assert_eq!(remedy(&run.stderr), ["--repair", "unsigned"], "{}", run.stderr);
    for bad in ["swap", "unsigned=0", "y:late=x"] {
        let run = ironout(["fit", text(&log), "--ut-per-count", "0.092", "--repair", bad]);
        assert!(run.status == 2 && run.said().contains("expected unsigned"), "{bad}: {}", run.stderr);
    }
}

#[test]
fn code_for_repaired_numbers_names_the_repair() {
    let Some(log) = case("05_uint16.csv") else { return };
    let cal = folder("cases_numbers_code").join("cal.json");
    let run =
        ironout(["fit", text(&log), "--ut-per-count", "0.092", "--repair", "unsigned", "-o", text(&cal)]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    for form in ["c", "rust"] {
        let code = ironout(["export", text(&cal), "--as", form]).stdout;
        assert!(code.contains("--repair unsigned") && code.contains("as signed numbers"), "{code}");
    }
}

#[test]
fn a_field_that_the_earth_nowhere_has_is_noted() {
    let Some(log) = recording("hand-rotated-counts.csv") else { return };
    for (scale, odd) in [("0.1", true), ("0.25", false)] {
        let run = ironout(["fit", text(&log), "--ut-per-count", scale]);
        assert_eq!(run.stdout.contains("the Earth's field is 22 to 67 µT"), odd, "{}", run.stdout);
    }
}

/// Real recordings hold no broken numbers: none is refused, and no row is set aside as an error code.
#[test]
fn recordings_are_left_alone() {
    let Some(folder_of_all) = recording("broad") else { return };
    let here = folder("cases_numbers_recordings");
    let all = [folder_of_all.parent().expect("a folder"), &folder_of_all];
    let mut read = 0;
    for path in all.iter().flat_map(|folder| std::fs::read_dir(folder).expect("a folder")) {
        let path = path.expect("an entry").path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_string();
        if !name.ends_with(".csv") || name.ends_with(".truth.csv") {
            continue;
        }
        let run = ironout(["import", text(&path), "-o", text(&here.join("out.csv"))]);
        assert_eq!(run.status, 0, "{name}: {}", run.stderr);
        for word in ["--repair", "error code", "does not belong", "freezes"] {
            assert!(!run.said().contains(word), "{name}: {}", run.stderr);
        }
        read += 1;
    }
    assert!(read >= 15, "{read}");
}
