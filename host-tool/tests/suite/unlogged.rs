//! Causes outside of what single columns do at once: late and slow columns, soft iron that follows one, recordings with an offset each, an
//! offset that switches, a true field that was logged.

use crate::common::{case, folder, ironout, simulate, text, write};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

fn diagnosed(logs: &[&Path]) -> Value {
    let logs = logs.iter().map(|log| text(log));
    ironout(["diagnose"].into_iter().chain(logs).chain(["--json"])).json()
}

fn triple(value: &Value) -> [f64; 3] {
    std::array::from_fn(|axis| value[axis].as_f64().expect("a number"))
}

fn named(diagnosis: &Value) -> Vec<String> {
    let steps = diagnosis["steps"].as_array().expect("steps");
    steps.iter().filter_map(|step| step["added"].as_str().map(str::to_string)).collect()
}

#[test]
fn an_unlogged_offset_that_switches_is_given_with_its_vector_and_its_times() {
    let Some(log) = case("12_onoff_unlogged.csv") else { return };
    let diagnosis = diagnosed(&[&log]);
    let found = &diagnosis["switching"];
    for (value, truth) in triple(&found["offset_ut"]).into_iter().zip([2.5, -1.0, 1.8]) {
        // On and off are each other's negative: which of the two it is, the smaller part of the log says.
        let sign = triple(&found["offset_ut"])[0].signum();
        assert!((sign * value - truth).abs() < 0.15, "{found}");
    }
    assert!(found["rms_ut"].as_f64() < Some(0.35), "{found}");
    assert!(found["on_s"].as_array().is_some_and(|spans| spans.len() >= 3), "{found}");
    let said = ironout(["diagnose", text(&log), "-v"]).stdout;
    assert!(said.contains("Switching offset without a column"), "{said}");
}

#[test]
fn three_days_have_one_matrix_and_an_offset_each() {
    let (Some(a), Some(b), Some(c)) = (case("24_day0.csv"), case("24_day1.csv"), case("24_day2.csv")) else {
        return;
    };
    let diagnosis = diagnosed(&[&a, &b, &c]);
    let found = &diagnosis["recordings"];
    for (value, truth) in triple(&found["per_recording_ut"]).into_iter().zip([1.6, -1.0, 1.2]) {
        assert!((value - truth).abs() < 0.2, "{found}");
    }
    assert_eq!(found["recordings"].as_array().map(Vec::len), Some(3), "{found}");
    assert_eq!(diagnosis["verdict"], "complete", "{diagnosis}");
    // The calibration is of the last day: its own log agrees with it, the first one's does not.
    let here = folder("unlogged_days");
    let cal = here.join("cal.json");
    let run = ironout(["fit", text(&a), text(&b), text(&c), "-o", text(&cal)]);
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    let off = |log: &Path| {
        let object = ironout(["check", text(log), "--cal", text(&cal), "--json"]).json();
        object["rms_ut"].as_f64().expect("an error")
    };
    assert!(off(&c) < 0.5 && off(&a) > 1.0, "{} {}", off(&c), off(&a));
}

#[test]
fn a_current_that_is_logged_late_leads_its_column() {
    let Some(log) = case("10_current_logged_late.csv") else { return };
    let diagnosis = diagnosed(&[&log]);
    assert_eq!(named(&diagnosis).first().map(String::as_str), Some("offset:current_a@delay"), "{diagnosis}");
    let delay_s = &diagnosis["effects"][0]["parameters"]["delay_s"];
    assert!((delay_s.as_f64().expect("a delay") + 0.3).abs() < 0.02, "{delay_s}");
}

#[test]
fn a_slow_column_and_soft_iron_of_a_column_are_named_fitted_and_applied() {
    let here = folder("unlogged_slow");
    for (effect, seed, key) in
        [("offset:current_a~tau", "3", Some("time_constant_s")), ("soft-iron:height_m", "5", None)]
    {
        let strength = format!("{effect}=6");
        let log = simulate(&here, "log.csv", &["--seconds", "120", "--seed", seed, "--effect", &strength]);
        let diagnosis = diagnosed(&[&log]);
        let cal = here.join("cal.json");
        let run = ironout(["fit", text(&log), "--add", effect, "-o", text(&cal)]);
        assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
        if let Some(key) = key {
            let file: Value =
                serde_json::from_str(&std::fs::read_to_string(&cal).expect("a file")).expect("JSON");
            assert!(file["effects"][0]["parameters"][key].as_f64() > Some(0.5), "{file}");
        }
        let object = ironout(["check", text(&log), "--cal", text(&cal), "--json"]).json();
        let (rms, plain) =
            (object["rms_ut"].as_f64().unwrap(), diagnosis["steps"][0]["rms_ut"].as_f64().unwrap());
        assert!(rms < 0.6 * plain, "{effect}: {rms} of {plain}");
    }
}

/// A board that turns in a field that grows and shrinks by a tenth, and a reference sensor beside it.
fn surveyed() -> String {
    let mut log = String::from("t_s,mx_ut,my_ut,mz_ut,base_nt\n");
    for i in 0..3000 {
        let t = f64::from(i) * 0.05;
        let field = 50.0 + 5.0 * (t * 0.07).sin();
        let (z, turn) = ((t * 0.31).sin(), t * 1.1 + 0.4 * (t * 0.17).cos());
        let level = (1.0 - z * z).sqrt();
        let [x, y, z] = [level * turn.cos(), level * turn.sin(), z].map(|axis| axis * field);
        // Noise of some 0.05 µT, the same each time.
        let noise = |k: f64| 0.07 * ((f64::from(i) + 1.0) * k).sin();
        let read =
            [1.02 * x + 12.0 + noise(911.7), 0.97 * y - 25.0 + noise(517.3), 1.04 * z + 31.0 + noise(733.9)];
        let _ = writeln!(log, "{t:.2},{:.4},{:.4},{:.4},{:.2}", read[0], read[1], read[2], 1000.0 * field);
    }
    log
}

#[test]
fn a_logged_true_field_gives_offset_and_absolute_gains() {
    let here = folder("unlogged_reference");
    let log = write(&here, "survey.csv", surveyed());
    let fitted = ironout(["fit", text(&log), "--reference", "base_nt", "--json"]).json();
    assert_eq!(fitted["accepted"], true, "{fitted}");
    for (value, truth) in triple(&fitted["offset_ut"]).into_iter().zip([12.0, -25.0, 31.0]) {
        assert!((value - truth).abs() < 0.05, "{fitted}");
    }
    for (axis, gain) in [1.02, 0.97, 1.04].into_iter().enumerate() {
        let entry = fitted["matrix"][axis][axis].as_f64().expect("a number");
        assert!((entry * gain - 1.0).abs() < 2e-3, "{axis}: {entry}");
    }
    let without = ironout(["fit", text(&log), "--json"]).json();
    assert!(without["rms_ut"].as_f64() > Some(1.0), "one field for all is none: {without}");
    let wrong = ironout(["fit", text(&log), "--reference", "t_s,base_nt"]);
    assert!(
        wrong.status != 0 && wrong.stderr.contains("one column") && wrong.stderr.contains("three"),
        "{}",
        wrong.stderr
    );
}

#[test]
fn a_low_pass_and_a_product_are_named_though_their_columns_do_not_act_alone() {
    let here = folder("unlogged_alone");
    for (effect, id, seed) in [
        ("offset:current_a~tau=6", "offset:current_a~tau", "11"),
        ("product:servo_deg*current_a=6", "product:servo_deg*current_a", "12"),
    ] {
        let log = simulate(&here, "log.csv", &["--seconds", "150", "--seed", seed, "--effect", effect]);
        let diagnosis = diagnosed(&[&log]);
        assert_eq!(named(&diagnosis).first().map(String::as_str), Some(id), "{diagnosis}");
        let cal = here.join("cal.json");
        let run = ironout(["fit", text(&log), "--add", id, "-o", text(&cal)]);
        assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
        let object = ironout(["check", text(&log), "--cal", text(&cal), "--json"]).json();
        let plain = diagnosis["steps"][0]["rms_ut"].as_f64().expect("an error");
        assert!(object["rms_ut"].as_f64() < Some(0.5 * plain), "{id}: {object}");
        let exported = ironout(["export", text(&cal), "--as", "c"]);
        assert!(exported.status == 0 && exported.stdout.contains("current_a"), "{}", exported.stderr);
    }
    let log = here.join("log.csv");
    for (id, word) in [("product:servo_deg", "two columns"), ("product:servo_deg*nothing", "no such column")]
    {
        let run = ironout(["fit", text(&log), "--add", id]);
        assert!(run.status == 2 && run.stderr.contains(word), "{}", run.stderr);
    }
}

#[test]
fn like_named_columns_are_one_name_with_coefficients_each() {
    let here = folder("unlogged_block");
    let effects = ["offset:esc1_a=6", "offset:esc2_a=6", "offset:esc3_a=6"];
    let options = effects.iter().flat_map(|effect| ["--effect", effect]);
    let options: Vec<&str> = ["--seconds", "150", "--seed", "21"].into_iter().chain(options).collect();
    let log = simulate(&here, "log.csv", &options);
    let diagnosis = diagnosed(&[&log]);
    let block = &diagnosis["blocks"][0];
    assert_eq!(block["like"], "esc#_a", "{diagnosis}");
    assert_eq!(block["columns"].as_array().map(Vec::len), Some(3), "{block}");
    let said = ironout(["diagnose", text(&log)]).stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    let ids = ["offset:esc1_a", "offset:esc2_a", "offset:esc3_a"];
    assert!(
        said.contains("its own coefficients for each of") && ids.iter().all(|id| said.contains(id)),
        "{said}"
    );
    let cal = here.join("cal.json");
    let adds = ids.into_iter().flat_map(|id| ["--add", id]);
    let run = ironout(["fit", text(&log)].into_iter().chain(adds).chain(["-o", text(&cal)]));
    assert_eq!(run.status, 0, "{}{}", run.stdout, run.stderr);
    // One motor's vector is none of the battery's current.
    let exported = ironout(["export", text(&cal), "--as", "ardupilot"]).stdout;
    assert!(exported.contains("esc1_a+esc2_a+esc3_a") && exported.contains("COMPASS_MOT_X,0"), "{exported}");
}

/// A survey flight: four headings, small manoeuvres, a scalar magnetometer; `m = p + (1 + I) h + E dh/dt`, no gyro.
fn flown(eddy_s: [[f64; 3]; 3]) -> String {
    let body = |t: f64| {
        let field = 53.0 + 0.3 * (t * 0.031).sin() + 0.15 * (t * 0.103).cos();
        let wave = |from: f64, hertz: f64| {
            let within = (t % 90.0) > from && (t % 90.0) < from + 24.0;
            if within { (std::f64::consts::TAU * hertz * (t % 90.0 - from)).sin() } else { 0.0 }
        };
        let [roll, pitch] = [0.26 * wave(4.0, 0.25), 0.16 * wave(32.0, 0.25)];
        let yaw = std::f64::consts::FRAC_PI_2 * (t / 90.0).floor() + 0.16 * wave(60.0, 0.125);
        let [north, down] = [0.42 * field, 0.9075 * field];
        let (x, y) = (north * yaw.cos(), -north * yaw.sin());
        let (x, z) = (x * pitch.cos() - down * pitch.sin(), x * pitch.sin() + down * pitch.cos());
        let (y, z) = (y * roll.cos() + z * roll.sin(), z * roll.cos() - y * roll.sin());
        (field, [x, y, z])
    };
    let mut log = String::from("t_s,mx_ut,my_ut,mz_ut,scalar_nt\n");
    for i in 0..3600 {
        let t = f64::from(i) * 0.1;
        let (field, h) = body(t);
        let [before, after] = [body(t - 1e-3).1, body(t + 1e-3).1];
        let rate: [f64; 3] = std::array::from_fn(|axis| (after[axis] - before[axis]) / 2e-3);
        // The jump of the heading is no turn.
        let rate = if rate.iter().any(|axis| axis.abs() > 100.0) { [0.0; 3] } else { rate };
        let read: [f64; 3] = std::array::from_fn(|axis| {
            let induced = [[0.006, 0.002, -0.003], [0.002, -0.008, 0.001], [-0.003, 0.001, 0.004]][axis];
            let sum = |row: [f64; 3], v: [f64; 3]| row.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
            let noise = 0.004 * ((f64::from(i) + 1.0) * [911.7, 517.3, 733.9][axis]).sin();
            [0.3, -0.5, 0.2][axis] + h[axis] + sum(induced, h) + sum(eddy_s[axis], rate) + noise
        });
        let _ = writeln!(log, "{t:.1},{:.5},{:.5},{:.5},{:.2}", read[0], read[1], read[2], 1000.0 * field);
    }
    log
}

#[test]
fn a_survey_flight_shows_the_terms_of_tolles_and_lawson() {
    let here = folder("unlogged_survey");
    let eddy_s = [[0.0, 0.012, -0.007], [-0.009, 0.0, 0.01], [0.008, -0.011, 0.0]];
    let log = write(&here, "flight.csv", flown(eddy_s));
    let diagnosis = ironout(["diagnose", text(&log), "--reference", "scalar_nt", "--json"]).json();
    assert_eq!(named(&diagnosis).first().map(String::as_str), Some("lag"), "{diagnosis}");
    let cal = here.join("cal.json");
    let run =
        ironout(["fit", text(&log), "--reference", "scalar_nt", "--add", "lag", "-o", text(&cal), "-v"]);
    assert!(run.status == 0 && run.stdout.contains("Tolles–Lawson"), "{}{}", run.stdout, run.stderr);
    let rows: Vec<&str> = run.stdout.lines().skip_while(|line| !line.starts_with("eddy E")).take(3).collect();
    for (row, truth) in rows.iter().zip(eddy_s) {
        let numbers: Vec<f64> = row.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        for (column, truth) in truth.into_iter().enumerate().filter(|(_, truth)| *truth != 0.0) {
            assert!((numbers[column] - truth).abs() < 0.002, "{rows:?}");
        }
    }
    // The rates of turn came from the readings, and do so where the calibration is used.
    let run = ironout(["apply", text(&log), "--cal", text(&cal), "-o", text(&here.join("out.csv"))]);
    assert_eq!(run.status, 0, "{}", run.stderr);
}

#[test]
fn six_jumps_of_the_offset_are_given_with_their_times() {
    let here = folder("unlogged_jumps");
    let (at_s, mut log) = ([20.0, 47.0, 71.0, 99.0, 128.0, 150.0], String::from("t_s,mx_ut,my_ut,mz_ut\n"));
    for i in 0..5100 {
        let t = f64::from(i) * 0.0333;
        let (z, turn) = ((t * 0.31).sin(), t * 1.3 + 0.4 * (t * 0.17).cos());
        let level = (1.0 - z * z).sqrt();
        let jumps = at_s.iter().filter(|at| t >= **at).count();
        let own = [[0.0; 3], [2.0, -1.0, 1.5], [-1.0, 2.0, 0.5], [1.0, 1.0, -2.0]][jumps % 4];
        let noise = |k: f64| 0.25 * ((f64::from(i) + 1.0) * k).sin();
        let v = [level * turn.cos(), level * turn.sin(), z];
        let m: [f64; 3] =
            std::array::from_fn(|axis| 48.0 * v[axis] + own[axis] + noise([911.7, 517.3, 733.9][axis]));
        let _ = writeln!(log, "{t:.4},{:.4},{:.4},{:.4}", m[0], m[1], m[2]);
    }
    let log = write(&here, "log.csv", log);
    let diagnosis = diagnosed(&[&log]);
    let found = &diagnosis["levels"];
    let times: Vec<f64> = found["at_s"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    assert_eq!(times.len(), at_s.len(), "{diagnosis}");
    assert!(times.iter().zip(at_s).all(|(found, truth)| (found - truth).abs() < 0.6), "{times:?}");
    let said = ironout(["diagnose", text(&log)]).stdout;
    assert!(said.contains("offset changes 6 times"), "{said}");
}

#[test]
fn a_smooth_cause_that_nobody_logged_is_no_series_of_jumps() {
    let here = folder("unlogged_smooth");
    for seed in ["15", "30", "32"] {
        let log = simulate(
            &here,
            &format!("{seed}.csv"),
            &["--seed", seed, "--effect", "offset:temp_c=3", "--without", "temp_c"],
        );
        let diagnosis = diagnosed(&[&log]);
        assert!(diagnosis["levels"].is_null() && diagnosis["switching"].is_null(), "{diagnosis}");
        assert!(diagnosis["wander"]["rms_ut"].as_f64() > Some(0.4), "{diagnosis}");
    }
}

#[test]
fn what_a_calibration_cannot_store_is_left_out_of_the_next_command() {
    let Some(log) = case("21_four_steps.csv") else { return };
    let run = ironout(["diagnose", text(&log), "--json"]);
    assert_eq!(run.json()["verdict"], "missing", "{}", run.stdout);
    let said = ironout(["diagnose", text(&log)]).stdout;
    assert!(said.contains("--add 'step#4' -o") && said.contains("leaves out lag"), "{said}");
}
