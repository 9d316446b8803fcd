//! Scale and mounting of the log in the exports to C and Rust: from the numbers of the log to what `apply` gives.

use crate::common::{folder, ironout, simulate, text, write};
use std::process::Command;

/// A log in counts in axes of its own, its calibration, and what `apply` makes of its first rows: raw and corrected.
fn calibrated(name: &str, effect: Option<&str>) -> (std::path::PathBuf, std::path::PathBuf, Vec<[f64; 8]>) {
    let here = folder(name);
    let mut world = vec!["--seconds", "40", "--seed", "4"];
    world.extend(effect.iter().flat_map(|effect| ["--effect", *effect]));
    let own = simulate(&here, "own.csv", &world);
    let content = std::fs::read_to_string(&own).expect("text");
    let mut lines = content.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().expect("a header");
    let place = |name: &str| header.split(',').position(|own| own == name).expect("a column");
    let (m, current) = (["mx_ut", "my_ut", "mz_ut"].map(place), place("current_a"));
    // The sensor's axes are the body's y, minus x, z; its counts are of three sizes.
    let scale = [0.05, 0.04, 0.08];
    let mut csv = "t_s,mx_counts,my_counts,mz_counts,current_a\n".to_string();
    for line in lines {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let body = m.map(|column| cells[column]);
        let sensor = [body[1], -body[0], body[2]];
        let counts: Vec<String> =
            (0..3).map(|axis| (sensor[axis] / scale[axis]).round().to_string()).collect();
        csv += &format!("{},{},{}\n", cells[0], counts.join(","), cells[current]);
    }
    let log = write(&here, "log.csv", csv);
    let (cal, out) = (here.join("cal.json"), here.join("out.csv"));
    let read = ["--ut-per-count", "0.05,0.04,0.08", "--rotate=-y,x,z"];
    let mut fit = vec!["fit", text(&log), "-o", text(&cal)];
    fit.extend(read);
    fit.extend(effect.iter().flat_map(|effect| ["--add", *effect]));
    let run = ironout(&fit);
    assert_eq!(run.status, 0, "{}", run.stdout);
    let mut apply = vec!["apply", text(&log), "--cal", text(&cal), "-o", text(&out)];
    apply.extend(["--rotate=-y,x,z"]);
    let run = ironout(&apply);
    assert_eq!(run.status, 0, "{}", run.stderr);
    let table = std::fs::read_to_string(&out).expect("text");
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let names = ["mx_counts", "my_counts", "mz_counts", "cx_ut", "cy_ut", "cz_ut", "t_s", "current_a"];
    let places =
        names.map(|name| header.iter().position(|own| *own == name).unwrap_or_else(|| panic!("{name}")));
    let rows = lines.step_by(97).map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        places.map(|place| cells[place].parse().expect("a number"))
    });
    let rows: Vec<[f64; 8]> = rows.collect();
    assert!(rows.len() > 15);
    (here, cal, rows)
}

#[test]
fn a_c_program_fed_with_counts_corrects_as_apply_does() {
    for (name, effect) in [("exports_c_plain", None), ("exports_c_effect", Some("offset:current_a"))] {
        let (here, cal, rows) = calibrated(name, effect);
        let run = ironout(["export", text(&cal), "--as", "c"]);
        assert_eq!(run.status, 0, "{}", run.stderr);
        assert!(run.stdout.contains("ironout_measured_ut("), "{}", run.stdout);
        write(&here, "calibration.h", &run.stdout);
        if Command::new("cc").arg("--version").output().is_err() {
            use std::io::Write;
            let _ = writeln!(std::io::stderr(), "SKIPPED: no C compiler here");
            return;
        }
        let (scalar, feed) = if effect.is_some() { ("ironout_real", "a, ") } else { ("float", "") };
        let calls: String = rows
            .iter()
            .map(|row| {
                let [x, y, z, _, _, _, _, a] = row;
                format!(
                    "    {{ const {scalar} raw[3] = {{{x:?}, {y:?}, {z:?}}}; const {scalar} a = {a:?}; {scalar} v[3]; (void)a; \
                     ironout_measured_ut(raw, v); ironout_apply(v, {feed}v); printf(\"%.9f %.9f %.9f\\n\", (double)v[0], \
                     (double)v[1], (double)v[2]); }}\n"
                )
            })
            .collect();
        let main = format!(
            "#define IRONOUT_REAL double\n#include <stdio.h>\n#include \"calibration.h\"\nint main(void)\n{{\n{calls}    return 0;\n}}\n"
        );
        let source = write(&here, "main.c", main);
        let program = here.join("main");
        // Constants of the log in a single-precision program: narrowing is meant.
        let flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wno-unused-function"];
        let out = Command::new("cc").args(flags).args(["-o", text(&program), text(&source), "-lm"]).output();
        let out = out.expect("cc runs");
        assert!(out.status.success(), "{}\n{}", String::from_utf8_lossy(&out.stderr), run.stdout);
        let printed = Command::new(&program).output().expect("the program runs").stdout;
        let printed = String::from_utf8_lossy(&printed).into_owned();
        assert_eq!(printed.lines().count(), rows.len());
        for (row, line) in rows.iter().zip(printed.lines()) {
            let own: Vec<f64> = line.split(' ').map(|word| word.parse().expect("a number")).collect();
            for axis in 0..3 {
                // Single precision at 100 µT, and the digits of the CSV.
                assert!((own[axis] - row[3 + axis]).abs() < 1e-4, "{own:?} for {row:?}");
            }
        }
    }
}

#[test]
fn the_rust_constants_carry_the_reading() {
    let (_, cal, rows) = calibrated("exports_rust_reading", None);
    let code = ironout(["export", text(&cal), "--as", "rust"]).stdout;
    let numbers = |from: &str, lines: usize| -> Vec<f64> {
        let body = code.split(from).nth(1).unwrap_or_else(|| panic!("{from}"));
        let cells = body.lines().skip(1).take(lines).flat_map(|line| line.split([',', '[', ']']));
        cells.filter_map(|cell| cell.trim().parse().ok()).collect()
    };
    let reading = numbers("pub const READING_F64: [[f64; 3]; 3] = [", 3);
    assert_eq!(reading, [-0.0, -0.04, 0.0, 0.05, 0.0, 0.0, 0.0, 0.0, 0.08]);
    assert!(code.contains("pub fn measured_ut(raw: [f32; 3]) -> [f32; 3]"), "{code}");
    let cal =
        ironout_cli::cal_file::CalFile::read(&cal).expect("a calibration").calibration().expect("sound");
    for row in rows {
        let measured = [0, 1, 2].map(|i| (0..3).map(|j| reading[3 * i + j] * row[j]).sum::<f64>());
        let corrected = cal.apply(measured);
        for axis in 0..3 {
            assert!((corrected[axis] - row[3 + axis]).abs() < 1e-4, "{corrected:?} for {row:?}");
        }
    }
}
