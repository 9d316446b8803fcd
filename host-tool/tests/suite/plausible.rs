//! Units, axes and clock of a log are held against each other: what cannot be is refused or left out with the option that
//! mends it, and a log that is right is left alone.

use crate::common::{changed, folder, ironout, recording, simulate, text, write};
use ironout_analysis::Table;
use ironout_analysis::plausible::{clock, field, gravity, turning};
use ironout_simulation::{EffectSpec, Log, Motion, World, WorldOptions};
use std::path::{Path, PathBuf};

/// What the four checks say of a log, in one word each.
fn alarms(table: &Table) -> Vec<String> {
    let mut list = Vec::new();
    list.extend(clock::odd(table).map(|odd| format!("clock {odd:?}")));
    list.extend(
        field::size(table).filter(field::FieldSize::contradicts_earth).map(|size| format!("field {size:?}")),
    );
    let turning = turning::judge(table);
    list.extend(turning.axes.map(|axes| format!("axes {axes:?}")));
    list.extend(turning.rate.map(|rate| format!("rate {rate:?}")));
    list.extend(gravity::odd(table).map(|odd| format!("gravity {odd:?}")));
    list
}

fn table(log: &Log) -> Table<'_> {
    Table::from_columns(log.named()).expect("columns")
}

/// Logs of boards that have nothing to do with each other: motion, noise, rate, field, dip, iron and hidden effects vary.
fn worlds() -> Vec<(String, Log)> {
    const EFFECTS: [&str; 10] = [
        "offset:temp_c=6",
        "offset:current_a=20",
        "gain:temp_c=6",
        "drift=10",
        "step=10",
        "lag=6",
        "nonlinearity=6",
        "cross-axis=6",
        "periodic=10",
        "offset:current_a=3",
    ];
    let mut list = Vec::new();
    for seed in 0..360_u64 {
        let pick = |n: u64, salt: u64| (seed.wrapping_mul(2_654_435_761).wrapping_add(salt * 97) >> 5) % n;
        let motion = match pick(5, 1) {
            0 | 1 => Motion::Sphere,
            2 => Motion::Hand,
            3 => Motion::Cap(0.25),
            _ => [Motion::Planar, Motion::Rest][pick(2, 2) as usize],
        };
        let strong = [None, Some([250.0, -400.0, 120.0]), Some([-35.0, 90.0, 10.0])][pick(3, 3) as usize];
        let soft = [None, Some([[1.35, 0.15, 0.0], [0.1, 0.8, -0.2], [0.05, 0.0, 1.1]])][pick(2, 4) as usize];
        let effects = (0..pick(3, 5)).map(|k| EFFECTS[pick(10, 6 + k) as usize]);
        let options = WorldOptions {
            seed,
            seconds: [30.0, 80.0, 200.0][pick(3, 8) as usize],
            rate_hz: [10.0, 50.0, 100.0][pick(3, 9) as usize],
            noise_ut: [0.05, 0.25, 1.0][pick(3, 10) as usize],
            field_ut: [23.0, 48.0, 66.0][pick(3, 11) as usize],
            dip_deg: [-70.0, 5.0, 60.0, 85.0][pick(4, 12) as usize],
            hard_iron_ut: strong,
            soft_iron: soft,
            motion,
            accel_noise_mps2: [0.05, 0.5][pick(2, 13) as usize],
            gyro_noise_radps: [0.005, 0.05][pick(2, 14) as usize],
            effects: effects.map(|text| EffectSpec::parse(text).expect("an effect")).collect(),
            ..WorldOptions::default()
        };
        let what = format!("seed {seed} {motion:?} {} Hz", options.rate_hz);
        list.push((what, World::new(options).run()));
    }
    list
}

/// Multiplies columns.
fn scaled(log: &Log, names: [&str; 3], factor: f64) -> Log {
    let mut log = log.clone();
    for name in names {
        if let Some(index) = log.position(name) {
            log.columns[index].iter_mut().for_each(|value| *value *= factor);
        }
    }
    log
}

const FIELD: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
const GYRO: [&str; 3] = ["gx_radps", "gy_radps", "gz_radps"];
const ACCEL: [&str; 3] = ["ax_mps2", "ay_mps2", "az_mps2"];

#[test]
fn sensors_whose_columns_are_always_zero_are_ignored() {
    let here = folder("plausible_silent");
    let log = simulate(&here, "log.csv", &["--seed", "3"]);
    let silent = changed(&here, &log, "silent.csv", |place, cells| {
        for name in ["ax_mps2", "ay_mps2", "az_mps2", "gx_radps", "gy_radps", "gz_radps"] {
            cells[place(name)] = 0.0;
        }
    });
    let run = ironout(["diagnose", text(&silent), "--json"]);
    assert_eq!(run.json()["verdict"], "complete", "{}", run.stdout);
    for sensor in ["accelerometer", "gyro"] {
        assert!(
            run.said().contains(&format!("ironout ignores the {sensor}: its columns are always zero")),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn logs_that_are_right_are_left_alone_and_faults_are_found() {
    let worlds = worlds();
    let (mut false_alarms, mut wrong) = (Vec::new(), Vec::new());
    // For each fault: logs that tell of the field or of the turning at all, and those in which the fault was named.
    let mut named = [0_usize; 6];
    let (mut spheres, mut turned, mut moving) = (0, 0, 0);
    for (what, log) in &worlds {
        false_alarms.extend(alarms(&table(log)).into_iter().map(|alarm| format!("{what}: {alarm}")));
        let is_sphere = field::size(&table(log)).is_some_and(|size| size.is_radius());
        spheres += usize::from(is_sphere);
        const UNITS: [(&str, f64); 6] =
            [("nT", 1e-3), ("mG", 0.1), ("G", 100.0), ("uT", 1.0), ("mT", 1e3), ("T", 1e6)];
        for (place, (unit, size)) in UNITS.into_iter().take(3).enumerate() {
            let other = scaled(log, FIELD, 1.0 / size);
            let found = field::size(&table(&other)).filter(field::FieldSize::contradicts_earth);
            let can: Vec<&str> = found
                .iter()
                .flat_map(|found| UNITS.into_iter().filter(|(_, ut)| found.can_be_earth(*ut)))
                .map(|(name, _)| name)
                .collect();
            if found.as_ref().is_some_and(field::FieldSize::is_radius) && !can.contains(&unit) {
                wrong.push(format!("{what}: {unit} taken for {can:?}"));
            }
            named[place] += usize::from(can == [unit]);
        }
        let sphere = what.contains("Sphere") || what.contains("Hand");
        moving += usize::from(sphere);
        let other = scaled(log, GYRO, 180.0 / std::f64::consts::PI);
        let found = turning::judge(&table(&other));
        turned += usize::from(sphere && found.rate.as_ref().is_some_and(|rate| rate.unit.is_some()));
        // Where it is turned over a small part of the sphere, the factor is rough and no unit is named.
        let is_deg = |rate: &turning::OddRate| rate.unit.is_none_or(|unit| unit.0 == "deg/s");
        wrong.extend(
            found.rate.iter().filter(|rate| !is_deg(rate)).map(|rate| format!("{what}: deg/s as {rate:?}")),
        );
        named[3] += usize::from(found.rate.is_some_and(|rate| rate.unit.is_some()));
        let mut other = log.clone();
        let places = GYRO.map(|name| log.position(name).expect("a gyro"));
        other.columns.swap(places[0], places[1]);
        let found = turning::judge(&table(&other)).axes;
        let right = found.as_ref().map(|axes| axes.orders.len() == 1 && axes.orders[0].name() == "y,x,z");
        // Where it is turned too little to tell the order, it is among those that are named.
        let among = found.as_ref().is_none_or(|axes| axes.orders.iter().any(|order| order.name() == "y,x,z"));
        if !among {
            wrong.push(format!("{what}: y,x,z as {found:?}"));
        }
        named[4] += usize::from(right == Some(true));
        let other = scaled(log, ACCEL, 1.0 / 9.806_65);
        let found = gravity::odd(&table(&other)).and_then(|odd| odd.unit);
        named[5] += usize::from(found.is_some_and(|unit| unit.0 == "g"));
    }
    let n = worlds.len();
    println!(
        "{n} logs: {} false alarms; of {spheres} in which the radius shows: nT {}, mG {}, G {}; deg/s {} (of {moving} turned \
         freely {turned}), swapped gyro axes {}, g {}",
        false_alarms.len(),
        named[0],
        named[1],
        named[2],
        named[3],
        named[4],
        named[5]
    );
    assert!(false_alarms.is_empty() && wrong.is_empty(), "{false_alarms:#?} {wrong:#?}");
    assert!(
        spheres * 5 > 4 * moving && named[..3].iter().all(|count| *count * 50 >= spheres * 49),
        "{named:?} of {spheres}"
    );
    assert!(turned * 10 >= moving * 9 && named[4] * 10 >= moving * 8, "{named:?} of {moving}");
    assert!(named[5] * 10 >= n * 9, "{named:?}");
}

#[test]
fn recordings_are_left_alone_unless_their_sensors_disagree() {
    let turned = "--rotate gyro:-x,-y,z";
    for (name, options, told) in [
        ("cubesat-magnetorquer-mag1.csv", &[][..], &[][..]),
        ("cubesat-magnetorquer-mag2.csv", &[], &[]),
        ("hand-rotated-counts.csv", &["--ut-per-count", "0.1"], &[]),
        // One source, one fault: its gyro stands turned by half a turn beside accelerometer and magnetometer, which agree.
        ("hmc5883l-mpu6050-full-sphere.csv", &[], &["of accelerometer and", turned]),
        ("hmc5883l-mpu6050-roll-and-tilt-at-45-90.csv", &[], &["too few axes", "-x,-y,z"]),
        // Here it is the magnetometer that stands turned: the dip says the same order.
        ("hmc5883l-mpu6050-tilt-sphere.csv", &[], &["of gyro and accelerometer", "--rotate mag:x,z,-y"]),
        // The source labels its gyro rad/s, and its provenance doubts it.
        ("imu-gnss-board.csv", &["--ut-per-count", "0.1"], &["so they are in deg/s", "*pi/180"]),
        ("lsm9ds1-hand-outliers.csv", &[], &[]),
        ("px4-quad-flight.csv", &[], &[]),
        ("qmc5883l-filtered.csv", &["--ut-per-count", "0.0333"], &[]),
        ("qmc5883l-noisy.csv", &["--ut-per-count", "0.0333"], &[]),
    ] {
        let Some(log) = recording(name) else { continue };
        let run = ironout(["fit", text(&log)].iter().chain(options));
        assert!(run.status <= 1, "{name}: {}", run.stderr);
        assert_eq!(run.said().contains("note: "), !told.is_empty(), "{name}: {}", run.stderr);
        let words = run.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(told.iter().all(|word| words.contains(word)), "{name}: {words}");
    }
}

/// A simulated log with some of its columns multiplied.
fn multiplied(here: &Path, name: &str, columns: &[(&str, f64)]) -> PathBuf {
    let log = simulate(here, "right.csv", &["--seed", "8", "--seconds", "90"]);
    let content = std::fs::read_to_string(log).expect("text");
    let mut header: Vec<String> = Vec::new();
    let mut out = String::new();
    for line in content.lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split(',').collect();
        if header.is_empty() {
            header = cells.iter().map(ToString::to_string).collect();
            out.push_str(line);
        } else {
            let cell =
                |(place, cell): (usize, &&str)| match columns.iter().find(|(name, _)| *name == header[place])
                {
                    Some((_, factor)) => format!("{}", cell.parse::<f64>().expect("a number") * factor),
                    None => (*cell).to_string(),
                };
            out.push_str(&cells.iter().enumerate().map(cell).collect::<Vec<_>>().join(","));
        }
        out.push('\n');
    }
    write(here, name, out)
}

fn field_in(factor: f64) -> [(&'static str, f64); 3] {
    FIELD.map(|name| (name, factor))
}

/// The lines of a message that are to be pasted.
fn pasteable(message: &str) -> Vec<String> {
    message.lines().filter(|line| line.starts_with("    ")).map(|line| line.trim().to_string()).collect()
}

/// Runs a line of a shell, with `$IRONOUT` as the program.
#[cfg(unix)]
fn shell(line: &str) -> std::process::Output {
    let mut command = std::process::Command::new("sh");
    command.args(["-c", line]).env("IRONOUT", env!("CARGO_BIN_EXE_ironout"));
    command.output().expect("a shell")
}

#[cfg(unix)]
#[test]
fn a_field_in_another_unit_is_refused_with_the_options_that_read_it() {
    let here = folder("plausible_field");
    let right = multiplied(&here, "ut.csv", &[]);
    let whole: serde_json::Value = ironout(["fit", text(&right), "--json"]).json();
    for (unit, factor, decimals) in [("nT", 1e3, 1e-2), ("mG", 10.0, 1e-3), ("G", 1e-2, 0.2)] {
        let log = multiplied(&here, &format!("it's in {unit}.csv"), &field_in(factor));
        for command in ["fit", "diagnose"] {
            let run = ironout([command, text(&log)]);
            assert_eq!(run.status, 2, "{command} {unit}: {}", run.stdout);
            assert!(run.said().contains(&format!("In {unit} it would be")), "{}", run.stderr);
            assert!(run.stderr.lines().all(|line| line.chars().count() <= 110 || line.starts_with("    ")));
        }
        let message =
            ironout(["fit", text(&log), "--json"]).error()["message"].as_str().expect("words").to_string();
        let options = pasteable(&message);
        let quoted = text(&log).replace('\'', r"'\''");
        let output = shell(&format!("\"$IRONOUT\" fit '{quoted}' --json {}", options[0]));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let mended: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        for axis in 0..3 {
            let of = |object: &serde_json::Value| object["offset_ut"][axis].as_f64().expect("a number");
            assert!((of(&mended) - of(&whole)).abs() < decimals, "{unit}: {mended}");
        }
    }
}

#[test]
fn a_coil_is_said_with_field_and_a_scale_is_found_with_it() {
    let here = folder("plausible_coil");
    let coil = multiplied(&here, "coil.csv", &field_in(8.0));
    assert_eq!(ironout(["fit", text(&coil)]).status, 2);
    let good = ironout(["fit", text(&coil), "--field", "400", "-o", text(&here.join("coil.json"))]);
    assert_eq!(good.status, 0, "{}{}", good.stdout, good.stderr);
    // Its calibration knows the coil.
    let cal = here.join("coil.json");
    for command in ["apply", "check"] {
        let run = ironout([command, text(&coil), "--cal", text(&cal)]);
        assert_eq!(run.status, 0, "{command}: {}", run.stderr);
    }
    let nano = multiplied(&here, "nano.csv", &field_in(8000.0));
    for command in ["apply", "check"] {
        let run = ironout([command, text(&nano), "--cal", text(&cal)]);
        assert!(
            run.status == 2 && run.said().contains("the calibration's log showed"),
            "{command}: {}",
            run.stderr
        );
    }
    // A field that is said and is not there.
    let run = ironout(["fit", text(&nano), "--field", "50"]);
    assert!(run.status == 2 && run.said().contains("--field or --at says 50"), "{}", run.stderr);
    // Counts of an unknown scale.
    let options = ["--map", "mx_counts=mx_ut,my_counts=my_ut,mz_counts=mz_ut", "--ut-per-count", "1"];
    let counts = |more: &[&str]| ironout(["fit", text(&coil)].iter().chain(&options).chain(more));
    let refused = counts(&[]);
    assert!(refused.status == 2 && refused.said().contains("--ut-per-count 0.1"), "{}", refused.stderr);
    let found = counts(&["--field", "50"]);
    assert!(
        found.status == 0 && found.said().contains("The scale of the counts is probably 0.12"),
        "{}",
        found.stderr
    );
}

#[cfg(unix)]
#[test]
fn a_gyro_in_degrees_is_left_out_and_read_as_told() {
    let here = folder("plausible_gyro");
    let degrees = GYRO.map(|name| (name, 180.0 / std::f64::consts::PI));
    let log = multiplied(&here, "deg.csv", &degrees);
    let run = ironout(["fit", text(&log)]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    assert!(
        run.said().contains("ironout ignores the gyro") && run.said().contains("57.3 ×"),
        "{}",
        run.stderr
    );
    let options = pasteable(&run.stderr);
    let mended = shell(&format!("\"$IRONOUT\" fit {} {}", text(&log), options[0]));
    let told = String::from_utf8_lossy(&mended.stderr).into_owned();
    assert!(mended.status.success() && !told.contains("ignores the gyro"), "{told}");
    // What uses the gyro does not get it: no lag is tested with it.
    let object = ironout(["diagnose", text(&log), "--json"]).json();
    let lag =
        object["candidates"].as_array().expect("candidates").iter().find(|row| row["id"] == "lag").cloned();
    assert!(lag.is_none_or(|row| row["status"] == "untestable"), "{object}");
    // Axes of another order.
    let swapped = std::fs::read_to_string(multiplied(&here, "same.csv", &[])).expect("text");
    let swapped = swapped.replacen("gx_radps,gy_radps", "gy_radps,gx_radps", 1);
    let swapped = write(&here, "swapped.csv", swapped);
    let run = ironout(["fit", text(&swapped)]);
    assert!(run.said().contains("gyro's axes") && run.said().contains("a mirror"), "{}", run.stderr);
    let mended = shell(&format!("\"$IRONOUT\" fit {} {}", text(&swapped), pasteable(&run.stderr)[0]));
    let told = String::from_utf8_lossy(&mended.stderr).into_owned();
    assert!(mended.status.success() && !told.contains("gyro's axes"), "{told}");
}

#[test]
fn an_accelerometer_in_g_is_said() {
    let here = folder("plausible_accel");
    let right = ironout(["fit", text(&multiplied(&here, "mps2.csv", &[])), "--json"]).json();
    let log = multiplied(&here, "g.csv", &ACCEL.map(|name| (name, 1.0 / 9.806_65)));
    let run = ironout(["fit", text(&log), "--json"]);
    assert!(run.said().contains("gravity in g, not in m/s²"), "{}", run.stderr);
    let heading = |object: &serde_json::Value| object["heading_error_deg"].as_f64().expect("a number");
    assert!((heading(&run.json()) - heading(&right)).abs() < 1e-3);
}

#[test]
fn a_time_that_no_sensor_has_is_left_out() {
    let here = folder("plausible_clock");
    // Milliseconds: the gyro knows how long it took.
    let run = ironout(["fit", text(&multiplied(&here, "ms.csv", &[("t_s", 1e3)])), "--json"]);
    let message = run.error()["message"].as_str().expect("words").to_string();
    assert!(message.contains("20.0 s apart") && message.contains("[ms]"), "{message}");
    // Without a gyro it could be a satellite: it is said, and not refused.
    let bare = simulate(&here, "bare.csv", &["--without", "gx_radps", "--seconds", "60"]);
    let content = std::fs::read_to_string(&bare).expect("text").replacen("t_s,", "t_ms,", 1);
    assert!(content.contains("t_ms"));
    let slow: String = content
        .lines()
        .map(|line| match line.split_once(',') {
            Some((time, rest)) if !line.starts_with('#') => match time.parse::<f64>() {
                Ok(time) => format!("{},{rest}\n", time * 1e3),
                Err(_) => format!("t_s,{rest}\n"),
            },
            _ => String::new(),
        })
        .collect();
    let slow = write(&here, "slow.csv", slow);
    let run = ironout(["fit", text(&slow)]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    assert!(run.said().contains("20.0 s apart") && run.said().contains("[ms]"), "{}", run.stderr);
    for factor in [1e6, 1e-6] {
        let log = multiplied(&here, "odd.csv", &[("t_s", factor)]);
        let run = ironout(["fit", text(&log)]);
        assert!(
            run.said().contains("which is implausible for a magnetometer")
                // One unit would make it right, or none: then it is reads the log without time.
                && (run.status == 2 && run.said().contains("t_s=t_s[us]") && factor > 1.0
                    || run.status < 2 && run.said().contains("reads the log without time") && factor < 1.0),
            "{factor}: {}",
            run.stderr
        );
    }
}
