//! Parameters for other programs: the target's own formula, written out from its source, with the numbers read back from the
//! file, gives what the calibration gives.

use crate::common::target::*;
use crate::common::{folder, ironout, text};
use ironout_cli::input::Mounting;
use serde_json::{Value, json};

/// Mountings by right angles, as `--rotate` takes them.
const MOUNTINGS: [&[&str]; 7] = [
    &[],
    &["mag:roll180"],
    &["mag:pitch180"],
    &["mag:yaw180"],
    &["mag:yaw90"],
    &["mag:pitch90"],
    &["roll90,pitch90"],
];

fn temperature() -> [Value; 2] {
    [
        offset("offset:temp_c", "temp_c", 28.5, [0.4, -0.3, 0.2], [20.0, 40.0]),
        offset("offset:temp_c^2", "temp_c", 29.0, [0.011, 0.004, -0.02], [20.0, 40.0]),
    ]
}

#[test]
fn px4_corrects_as_the_calibration_does() {
    let here = folder("exports_px4");
    let log = log(&here);
    let current = offset("offset:current_a", "current_a", 9.0, [0.31, -0.12, 0.07], [0.0, 30.0]);
    let throttle = offset("offset:throttle", "throttle", 0.4, [3.1, -4.2, 2.7], [0.0, 1.0]);
    let [warm, square] = temperature();
    let sets = [
        vec![],
        vec![current.clone()],
        vec![throttle, warm.clone()],
        vec![current, warm, square.clone()],
        vec![square],
    ];
    for rotate in MOUNTINGS {
        for (n, effects) in sets.iter().enumerate() {
            let cal = cal(&here, &SYMMETRIC, effects, reading(rotate));
            let truth = Truth::of(&cal, &log);
            let number = (n % 4).to_string();
            let file = exported(&cal, "px4", &["--number", &number, "--device-id", "396825"]);
            assert!(file.contains("represents the whole calibration"), "{file}");
            let p = px4(&file);
            assert_eq!(p[&format!("CAL_MAG{number}_ID")], 396_825.0);
            assert_eq!(p.contains_key(&format!("CAL_MAG{number}_ROT")), !rotate.is_empty(), "{rotate:?}");
            truth.assert_same(&format!("{rotate:?} {n}"), 2e-6, |row, raw| {
                px4_corrects(&p, n % 4, raw, &truth, row)
            });
        }
    }
}

#[test]
fn ardupilot_corrects_as_the_calibration_does() {
    let here = folder("exports_ardupilot");
    let log = log(&here);
    let current = offset("offset:current_a", "current_a", 9.0, [0.31, -0.12, 0.07], [0.0, 30.0]);
    let throttle = offset("offset:throttle", "throttle", 0.4, [3.1, -4.2, 2.7], [0.0, 1.0]);
    for rotate in MOUNTINGS {
        for (n, effects) in [vec![], vec![current.clone()], vec![throttle.clone()]].iter().enumerate() {
            let cal = cal(&here, &SYMMETRIC, effects, reading(rotate));
            let truth = Truth::of(&cal, &log);
            let file = exported(&cal, "ardupilot", &["--number", &(n + 1).to_string()]);
            assert!(file.contains("represents the whole calibration"), "{file}");
            let suffix = ["", "2", "3"][n];
            let p = ardupilot(&file);
            assert_eq!(p.contains_key(&format!("COMPASS_ORIENT{suffix}")), !rotate.is_empty(), "{rotate:?}");
            truth.assert_same(&format!("{rotate:?} {n}"), 2e-6, |row, raw| {
                ardupilot_corrects(&p, suffix, raw, &truth, row)
            });
        }
    }
}

#[test]
fn a_rotation_that_no_mounting_has_is_lost_and_said_and_the_magnitude_is_not() {
    let here = folder("exports_turned");
    let log = log(&here);
    let turned = product(&euler(1.5, -2.0, 2.5), &SYMMETRIC);
    for rotate in MOUNTINGS {
        let cal = cal(&here, &turned, &[], reading(rotate));
        let truth = Truth::of(&cal, &log);
        let run = ironout(["export", text(&cal), "--as", "px4", "--json"]).json();
        let lost_deg = run["lost_rotation_deg"].as_f64().expect("an angle");
        assert!((3.0..4.0).contains(&lost_deg), "{lost_deg}");
        assert!(run["not_held"][0].as_str().is_some_and(|text| text.contains("a rotation of 3.")), "{run}");
        assert!(run["text"].as_str().is_some_and(|text| text.contains("--log")), "{run}");
        let p = px4(run["text"].as_str().expect("a file"));
        let angle = truth.assert_same_magnitude(2e-6, |row, raw| px4_corrects(&p, 0, raw, &truth, row));
        assert!(angle <= lost_deg + 1e-6 && angle > 0.9 * lost_deg, "{angle} of {lost_deg}");
        let p = ardupilot(&exported(&cal, "ardupilot", &[]));
        let angle =
            truth.assert_same_magnitude(2e-6, |row, raw| ardupilot_corrects(&p, "", raw, &truth, row));
        assert!(angle <= lost_deg + 1e-6 && angle > 0.9 * lost_deg, "{angle} of {lost_deg}");
    }
    // As Euler angles all of it is held.
    for rotate in MOUNTINGS {
        let current = offset("offset:current_a", "current_a", 9.0, [0.31, -0.12, 0.07], [0.0, 30.0]);
        let cal = cal(&here, &turned, &[current], reading(rotate));
        let truth = Truth::of(&cal, &log);
        let file = exported(&cal, "px4", &["--euler"]);
        assert!(file.contains("represents the whole calibration"), "{file}");
        let p = px4(&file);
        truth.assert_same("px4 --euler", 3e-6, |row, raw| px4_corrects(&p, 0, raw, &truth, row));
        let p = ardupilot(&exported(&cal, "ardupilot", &["--euler", "--number", "2"]));
        truth
            .assert_same("ardupilot --euler", 3e-6, |row, raw| ardupilot_corrects(&p, "2", raw, &truth, row));
    }
    // Without an accelerometer the matrix is triangular, and its rotation a convention: nothing is lost.
    let triangle = [[1.07, 0.06, -0.02], [0.0, 0.94, 0.08], [0.0, 0.0, 1.01]];
    let cal = cal(&here, &triangle, &[], reading(&["mag:yaw90"]));
    let truth = Truth::of(&cal, &log);
    let file = exported(&cal, "px4", &[]);
    assert!(file.contains("No accelerometer was used") && file.contains("represents the whole calibration"));
    let p = px4(&file);
    assert_eq!(p["CAL_MAG0_ROT"], 2.0);
    truth.assert_same_magnitude(2e-6, |row, raw| px4_corrects(&p, 0, raw, &truth, row));
}

#[test]
fn ros_and_iio_correct_as_the_calibration_does() {
    let here = folder("exports_ros");
    let log = log(&here);
    let turned = product(&euler(1.5, -2.0, 2.5), &SYMMETRIC);
    for (rotate, number) in [(&[][..], 0), (&["mag:yaw90"][..], 2), (&["mag:roll180"][..], 8)] {
        let cal = cal(&here, &turned, &[], reading(rotate));
        let truth = Truth::of(&cal, &log);
        let file = exported(&cal, "ros", &[]);
        assert!(file.contains("represents the whole calibration"), "{file}");
        let value = |key: &str| -> Vec<f64> {
            let line = rows(&file).find(|line| line.trim().starts_with(key)).expect(key);
            let list = line.split_once(": ").expect("a value").1.trim_matches(['[', ']']);
            list.split(", ").map(|number| number.parse().expect("a number")).collect()
        };
        let bias = ["x", "y", "z"].map(|axis| value(&format!("initial_mag_bias_{axis}:"))[0]);
        let m = value("initial_mag_scaling_matrix:");
        let matrix: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| m[3 * i + j]));
        // The mounting is the frames' own.
        let frame = orientation(number);
        truth.assert_same("ros", 1e-8, |_, raw| {
            let unbiased = times(&matrix, [0, 1, 2].map(|axis| raw[axis] * 1e-6 - bias[axis]));
            times(&frame, unbiased.map(|tesla| tesla * 1e6))
        });
    }
    // IIO has a factor an axis and any rotation: all of a matrix that is no more than that.
    let diagonal = [[1.1, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.02]];
    let cal = cal(&here, &product(&euler(1.5, -2.0, 92.5), &diagonal), &[], reading(&[]));
    let truth = Truth::of(&cal, &log);
    let file = exported(&cal, "iio", &["--ut-per-count", "0.15,0.15,0.3"]);
    assert!(file.contains("represents the whole calibration"), "{file}");
    let value = |key: &str| {
        let line = rows(&file).find_map(|line| line.strip_prefix(&format!("{key}="))).expect(key);
        line.split([',', ';']).map(|number| number.trim().parse().expect("a number")).collect::<Vec<f64>>()
    };
    let of = |part: &str| ["x", "y", "z"].map(|axis| value(&format!("in_magn_{axis}_{part}"))[0]);
    let (add, scale, mount) = (of("offset"), of("scale"), value("in_mount_matrix"));
    let mount: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| mount[3 * i + j]));
    let counts = [0.15, 0.15, 0.3];
    truth.assert_same("iio", 1e-5, |_, raw| {
        let gauss = [0, 1, 2].map(|axis| (raw[axis] / counts[axis] + add[axis]) * scale[axis]);
        times(&mount, gauss.map(|gauss| gauss * 100.0))
    });
}

#[test]
fn betaflight_takes_away_whole_counts_in_its_own_axes() {
    let here = folder("exports_betaflight");
    // compass.c, alignSensorViaRotation: which of the driver's axes become x forward, y left, z up.
    let align = |word: &str, [x, y, z]: Vector| match word {
        "CW0" => [x, y, z],
        "CW90" => [y, -x, z],
        "CW180FLIP" => [x, -y, -z],
        "CW90FLIP" => [y, x, -z],
        other => panic!("{other}"),
    };
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // A matrix that is aligned and hardly more than a factor.
    let matrix = [[1.0, 1e-9, 0.0], [1e-9, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let offset_ut = [7.362390848010126, -25.127784235575668, -10.650318882112419];
    for (rotate, word) in [(&[][..], "CW0"), (&["mag:x,-y,-z"][..], "CW0"), (&["mag:y,-x,z"][..], "CW90FLIP")]
    {
        let counts = json!({"ut_per_count": [0.092, 0.092, 0.092], "rotate": rotate});
        let cal = cal(&here, &matrix, &[], counts);
        let file = exported(&cal, "betaflight", &[]);
        let lines: Vec<&str> = rows(&file).collect();
        let zero: Vec<f64> = lines
            .iter()
            .find_map(|line| line.strip_prefix("set mag_calibration = "))
            .expect("an offset")
            .split(',')
            .map(|count| count.parse::<i16>().expect("a whole count").into())
            .collect();
        let own = lines.iter().find_map(|line| line.strip_prefix("set align_mag = ")).unwrap_or("CW0");
        assert_eq!(own, word, "{rotate:?}: {file}");
        assert_eq!(lines.last(), Some(&"save"));
        // The offset of the calibration, back in the driver's axes and turned as Betaflight turns them.
        let mount = Mounting::parse(&rotate.iter().map(|one| one.to_string()).collect::<Vec<_>>());
        let to_body = mount.expect("a mounting").magnetometer.unwrap_or(identity);
        let transposed = std::array::from_fn(|i| std::array::from_fn(|j| to_body[j][i]));
        let sensor = times(&transposed, offset_ut).map(|ut| ut / 0.092);
        for (own, wanted) in zero.iter().zip(align(word, sensor)) {
            assert!((own - wanted).abs() <= 0.5, "{rotate:?}: {own} for {wanted}");
        }
    }
    // A mounting that none of the eight words names: as angles in tenths of a degree, those of boardalignment.c from 2026.6 on.
    for rotate in [&["mag:roll90"][..], &["mag:pitch90"], &["mag:y,z,x"], &["mag:-z,-x,y"]] {
        let counts = json!({"ut_per_count": [0.092, 0.092, 0.092], "rotate": rotate});
        let file = exported(&self::cal(&here, &matrix, &[], counts), "betaflight", &[]);
        let value = |key: &str| {
            let found = rows(&file).find_map(|line| line.strip_prefix(&format!("set {key} = ")));
            found.unwrap_or_else(|| panic!("no {key}: {file}"))
        };
        assert_eq!(value("align_mag"), "CUSTOM", "{rotate:?}");
        let [roll, pitch, yaw] = ["roll", "pitch", "yaw"].map(|name| {
            let tenths: i16 = value(&format!("mag_align_{name}")).parse().expect("a whole number");
            assert!((-1800..=3600).contains(&tenths), "{rotate:?}: {tenths}");
            f64::from(tenths) / 10.0
        });
        assert!(file.contains("2026.6"), "{file}");
        let zero: Vec<f64> =
            value("mag_calibration").split(',').map(|count| count.parse().expect("a count")).collect();
        // Counts of the driver that the calibration makes zero are zero in Betaflight too, to half a count.
        let mount = Mounting::parse(&rotate.iter().map(|one| one.to_string()).collect::<Vec<_>>());
        let to_body = mount.expect("a mounting").magnetometer.unwrap_or(identity);
        let transposed = std::array::from_fn(|i| std::array::from_fn(|j| to_body[j][i]));
        let sensor = times(&transposed, offset_ut).map(|ut| ut / 0.092);
        for (own, wanted) in zero.iter().zip(times(&euler(roll, pitch, yaw), sensor)) {
            assert!((own - wanted).abs() <= 0.5 + 1e-6, "{rotate:?}: {own} for {wanted}: {file}");
        }
        // And its axes are x forward, y left, z up.
        for axis in 0..3 {
            let unit: Vector = std::array::from_fn(|i| f64::from(i == axis));
            let [x, y, z] = times(&to_body, unit);
            let off =
                norm(std::array::from_fn(|i| times(&euler(roll, pitch, yaw), unit)[i] - [x, -y, -z][i]));
            assert!(off < 1e-9, "{rotate:?}: {file}");
        }
    }
    // A log in microtesla has no counts.
    let cal = cal(&here, &matrix, &[], reading(&[]));
    let error = ironout(["export", text(&cal), "--as", "betaflight", "--json"]).error();
    assert!(error["message"].as_str().is_some_and(|text| text.contains("--ut-per-count")), "{error}");
    let small = ["export", text(&cal), "--as", "betaflight", "--ut-per-count", "0.0001", "--json"];
    assert!(ironout(small).error()["message"].as_str().is_some_and(|text| text.contains("out of its range")));
}
