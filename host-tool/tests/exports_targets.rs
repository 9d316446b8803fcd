//! Parameters for other programs: the target's own formula, written out here from its source, with the numbers read back from the
//! file, gives what the calibration gives.

mod common;

use common::{folder, ironout, simulate, text, write};
use ironout_analysis::{Corrector, Table};
use ironout_cli::cal_file::CalFile;
use ironout_cli::input::{Log, Mounting, ReadOptions, read_log};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

type Vector = [f64; 3];
type Matrix = [[f64; 3]; 3];

fn times(m: &Matrix, v: Vector) -> Vector {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn norm(v: Vector) -> f64 {
    v.iter().map(|value| value * value).sum::<f64>().sqrt()
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// `Rz(yaw) · Ry(pitch) · Rx(roll)`, as both autopilots take their angles.
fn euler(roll: f64, pitch: f64, yaw: f64) -> Matrix {
    let ((sr, cr), (sp, cp)) = (roll.to_radians().sin_cos(), pitch.to_radians().sin_cos());
    let (sy, cy) = yaw.to_radians().sin_cos();
    let x = [[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]];
    let y = [[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]];
    let z = [[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]];
    product(&z, &product(&y, &x))
}

/// The mountings that the cases use, by the number of `MAV_SENSOR_ORIENTATION` (mavlink common.xml).
fn orientation(number: usize) -> Matrix {
    match number {
        0 => euler(0.0, 0.0, 0.0),
        2 => euler(0.0, 0.0, 90.0),
        4 => euler(0.0, 0.0, 180.0),
        6 => euler(0.0, 0.0, 270.0),
        8 => euler(180.0, 0.0, 0.0),
        12 => euler(0.0, 180.0, 0.0),
        24 => euler(0.0, 90.0, 0.0),
        28 => euler(90.0, 90.0, 0.0),
        other => panic!("no case is mounted as {other}"),
    }
}

/// A log of the test's own: any directions, and columns that wander.
fn log(here: &Path) -> PathBuf {
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut csv = "t_s,mx_ut,my_ut,mz_ut,temp_c,current_a,motor_a,throttle\n".to_string();
    for row in 0..80 {
        let v: Vec<String> = (0..3).map(|_| format!("{:.3}", 120.0 * random() - 60.0)).collect();
        csv += &format!(
            "{:.2},{},{:.3},{:.3},{:.3},{:.4}\n",
            f64::from(row) * 0.02,
            v.join(","),
            21.0 + 18.0 * random(),
            30.0 * random(),
            12.0 * random(),
            random()
        );
    }
    write(here, "log.csv", csv)
}

const SYMMETRIC: Matrix = [[1.07, 0.031, -0.012], [0.031, 0.94, 0.045], [-0.012, 0.045, 1.01]];

/// An entry of a calibration file.
fn offset(id: &str, column: &str, reference: f64, theta: Vector, range: [f64; 2]) -> Value {
    json!({
        "id": id, "name": "", "columns": [column], "coefficients": theta, "std_errors": [1e-3, 1e-3, 1e-3], "unit": "",
        "reference": {column: reference}, "parameters": {}, "range": {column: range},
    })
}

/// A calibration file.
fn cal(here: &Path, matrix: &Matrix, effects: &[Value], reading: Value) -> PathBuf {
    let fixture = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/cal.json"));
    let mut file: Value =
        serde_json::from_str(&std::fs::read_to_string(fixture).expect("text")).expect("JSON");
    file["effects"] = effects.into();
    file["matrix"] = json!(matrix);
    file["reading"] = reading;
    write(here, "cal.json", file.to_string())
}

fn reading(rotate: &[&str]) -> Value {
    json!({"ut_per_count": null, "rotate": rotate})
}

/// What the calibration makes of every row, and the row as the sensor gave it.
struct Truth {
    log: Log,
    raw: Log,
    corrected: Vec<Vector>,
}

impl Truth {
    fn of(cal: &Path, path: &Path) -> Self {
        let file = CalFile::read(cal).expect("a calibration");
        let rotate = file.reading.as_ref().map_or_else(Vec::new, |reading| reading.rotate.clone());
        let options =
            ReadOptions { mounting: Mounting::parse(&rotate).expect("a mounting"), ..ReadOptions::default() };
        let log = read_log(path, &options).expect("a log");
        let raw = read_log(path, &ReadOptions::default()).expect("a log");
        let corrected = {
            let table = Table::from(&log);
            let corrector = Corrector::new(file.extended().expect("effects"), &table).expect("columns");
            (0..log.rows).map(|row| corrector.correct(row).expect("finite")).collect()
        };
        Truth { log, raw, corrected }
    }

    fn column(&self, name: &str, row: usize) -> f64 {
        self.log.covariate(name).unwrap_or_else(|| panic!("{name}")).values[row]
    }

    /// Every row against what the target makes of it, within `most_ut`.
    fn assert_same(&self, what: &str, most_ut: f64, target: impl Fn(usize, Vector) -> Vector) {
        for (row, wanted) in self.corrected.iter().enumerate() {
            let own = target(row, self.raw.field(row));
            let off = norm(std::array::from_fn(|axis| own[axis] - wanted[axis]));
            assert!(off <= most_ut, "{what}, row {row}: {own:?} for {wanted:?}");
        }
    }

    /// Magnitudes alone, within `most_ut`, and the largest angle between the two, degrees.
    fn assert_same_magnitude(&self, most_ut: f64, target: impl Fn(usize, Vector) -> Vector) -> f64 {
        let rows = self.corrected.iter().enumerate();
        rows.map(|(row, wanted)| {
            let own = target(row, self.raw.field(row));
            assert!((norm(own) - norm(*wanted)).abs() <= most_ut, "row {row}: {own:?} for {wanted:?}");
            let dot: f64 = own.iter().zip(wanted).map(|(a, b)| a * b).sum();
            (dot / norm(own) / norm(*wanted)).clamp(-1.0, 1.0).acos().to_degrees()
        })
        .fold(0.0, f64::max)
    }
}

fn exported(cal: &Path, form: &str, options: &[&str]) -> String {
    let run = ironout(["export", text(cal), "--as", form].iter().chain(options));
    assert_eq!(run.status, 0, "{form}: {}", run.stderr);
    run.stdout
}

/// The rows of a file that are no comments.
fn rows(file: &str) -> impl Iterator<Item = &str> {
    file.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty())
}

/// PX4: name and value, with the type that MAVLink has for it.
fn px4(file: &str) -> BTreeMap<String, f64> {
    rows(file)
        .map(|line| {
            let cells: Vec<&str> = line.split('\t').collect();
            assert_eq!((cells.len(), cells[0], cells[1]), (5, "1", "1"), "{line}");
            assert!(cells[2].len() <= 16, "a name of MAVLink: {line}");
            match cells[4] {
                "6" => assert!(cells[3].parse::<i32>().is_ok(), "{line}"),
                "9" => assert!(cells[3].contains('.') && !cells[3].contains('e'), "{line}"),
                other => panic!("type {other}"),
            }
            (cells[2].to_string(), cells[3].parse().expect("a number"))
        })
        .collect()
}

fn mag_angle(p: &BTreeMap<String, f64>, n: usize, name: &str) -> f64 {
    p[&format!("CAL_MAG{n}_{name}")]
}

/// `Magnetometer::Correct` and `TemperatureCompensation::calc_thermal_offsets_3D` of PX4, in µT.
fn px4_corrects(p: &BTreeMap<String, f64>, n: usize, raw_ut: Vector, truth: &Truth, row: usize) -> Vector {
    let get = |name: &str| p.get(name).copied().unwrap_or(0.0);
    let mag = |part: &str| ["X", "Y", "Z"].map(|axis| get(&format!("CAL_MAG{n}_{axis}{part}")));
    let (off, scale, odiag, comp) = (mag("OFF"), mag("SCALE"), mag("ODIAG"), mag("COMP"));
    let power = match get("CAL_MAG_COMP_TYP") as i32 {
        2 => truth.column("current_a", row) * 0.001,
        1 => truth.column("throttle", row),
        _ => 0.0,
    };
    let mut thermal = [0.0; 3];
    if get("TC_M_ENABLE") == 1.0 {
        let tc = |part: &str| get(&format!("TC_M{n}_{part}"));
        let delta = truth.column("temp_c", row).clamp(tc("TMIN"), tc("TMAX")) - tc("TREF");
        thermal = [0, 1, 2]
            .map(|axis| (0..4).map(|power| tc(&format!("X{power}_{axis}")) * delta.powi(power)).sum::<f64>());
    }
    let s = [[scale[0], odiag[0], odiag[1]], [odiag[0], scale[1], odiag[2]], [odiag[1], odiag[2], scale[2]]];
    let centred = [0, 1, 2].map(|axis| raw_ut[axis] / 100.0 + power * comp[axis] - thermal[axis] - off[axis]);
    let rotation = match get(&format!("CAL_MAG{n}_ROT")) as usize {
        100 => euler(mag_angle(p, n, "ROLL"), mag_angle(p, n, "PITCH"), mag_angle(p, n, "YAW")),
        number => orientation(number),
    };
    times(&rotation, times(&s, centred)).map(|gauss| gauss * 100.0)
}

/// ArduPilot: name and value.
fn ardupilot(file: &str) -> BTreeMap<String, f64> {
    rows(file)
        .map(|line| {
            let (name, value) = line.split_once(',').expect("NAME,VALUE");
            assert!(name.len() <= 16, "a name of MAVLink: {line}");
            (name.to_string(), value.parse().expect("a number"))
        })
        .collect()
}

/// `rotate_field` and `correct_field` of AP_Compass_Backend, in µT.
fn ardupilot_corrects(
    p: &BTreeMap<String, f64>,
    suffix: &str,
    raw_ut: Vector,
    truth: &Truth,
    row: usize,
) -> Vector {
    let get = |name: String| p.get(&name).copied().unwrap_or(0.0);
    let three = |part: &str| ["X", "Y", "Z"].map(|axis| get(format!("COMPASS_{part}{suffix}_{axis}")));
    let (ofs, dia, odi, mot) = (three("OFS"), three("DIA"), three("ODI"), three("MOT"));
    let mat = [[dia[0], odi[0], odi[1]], [odi[0], dia[1], odi[2]], [odi[1], odi[2], dia[2]]];
    let rotation = match get(format!("COMPASS_ORIENT{suffix}")) as usize {
        101 => {
            assert_eq!(p["CUST_ROT_ENABLE"], 1.0);
            euler(p["CUST_ROT1_ROLL"], p["CUST_ROT1_PITCH"], p["CUST_ROT1_YAW"])
        }
        number => orientation(number),
    };
    let mag = times(&rotation, raw_ut.map(|ut| ut * 10.0));
    let factor = get(format!("COMPASS_SCALE{suffix}"));
    let mag = times(&mat, [0, 1, 2].map(|axis| (mag[axis] + ofs[axis]) * factor));
    let power = match get("COMPASS_MOTCT".into()) as i32 {
        2 => truth.column("current_a", row),
        1 => truth.column("throttle", row),
        _ => 0.0,
    };
    [0, 1, 2].map(|axis| (mag[axis] + mot[axis] * power) / 10.0)
}

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
            assert!(file.contains("Nothing of the calibration is lost"), "{file}");
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
            assert!(file.contains("Nothing of the calibration is lost"), "{file}");
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
        assert!(file.contains("Nothing of the calibration is lost"), "{file}");
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
    assert!(
        file.contains("not aligned to an accelerometer")
            && file.contains("Nothing of the calibration is lost")
    );
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
        assert!(file.contains("Nothing of the calibration is lost"), "{file}");
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
    assert!(file.contains("Nothing of the calibration is lost"), "{file}");
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
    // A log in microtesla has no counts.
    let cal = cal(&here, &matrix, &[], reading(&[]));
    let error = ironout(["export", text(&cal), "--as", "betaflight", "--json"]).error();
    assert!(error["message"].as_str().is_some_and(|text| text.contains("--ut-per-count")), "{error}");
    let small = ["export", text(&cal), "--as", "betaflight", "--ut-per-count", "0.0001", "--json"];
    assert!(ironout(small).error()["message"].as_str().is_some_and(|text| text.contains("does not fit")));
}

#[test]
fn what_is_lost_is_said_and_with_the_log_what_it_costs() {
    let here = folder("exports_cost");
    let log = simulate(
        &here,
        "log.csv",
        &["--seconds", "40", "--seed", "3", "--effect", "offset:current_a=6", "--effect", "offset:temp_c=4"],
    );
    let cal = here.join("cal.json");
    let fit = ["fit", text(&log), "-o", text(&cal), "--add", "offset:current_a", "--add", "offset:temp_c"];
    assert_eq!(ironout(fit).status, 0);
    let truth = Truth::of(&cal, &log);
    let field_ut = CalFile::read(&cal).expect("a calibration").fit.field_ut.expect("a field");
    let with = |form: &str, more: &[&str]| {
        let run = ironout(["export", text(&cal), "--as", form, "--json"].iter().chain(more));
        assert_eq!(run.status, 0, "{}", run.stderr);
        run.json()
    };
    let rms = |p: &BTreeMap<String, f64>| {
        let squares: f64 = (0..truth.raw.rows)
            .map(|row| {
                (norm(ardupilot_corrects(p, "", truth.raw.field(row), &truth, row)) - field_ut).powi(2)
            })
            .sum();
        (squares / truth.raw.rows as f64).sqrt()
    };
    // ArduPilot has no temperature: without the log that is said, with it the rest is fitted anew.
    let blind = with("ardupilot", &[]);
    assert!(blind["cost"].is_null() && blind["fitted_anew"] == false, "{blind}");
    assert!(blind["not_held"].to_string().contains("offset:temp_c"), "{blind}");
    assert!(
        blind["text"].as_str().is_some_and(|text| text.contains("is not known: give the log with --log"))
    );
    let seen = with("ardupilot", &["--log", text(&log)]);
    let cost = &seen["cost"];
    let (whole, held) = (cost["rms_ut"].as_f64().expect("rms"), cost["held_rms_ut"].as_f64().expect("rms"));
    assert!(seen["fitted_anew"] == true && held > 2.0 * whole, "{cost}");
    let [before, after] = [&blind, &seen].map(|one| ardupilot(one["text"].as_str().expect("a file")));
    // The error that is printed is that of the file, and no better one is near it.
    assert!((rms(&after) - held).abs() < 2e-3 * held, "{} against {held}", rms(&after));
    assert!(rms(&after) < rms(&before), "{} against {}", rms(&after), rms(&before));
    for (name, step) in
        [("COMPASS_OFS_X", 2.0), ("COMPASS_DIA_Y", 0.004), ("COMPASS_ODI_Z", 0.004), ("COMPASS_MOT_Y", 0.5)]
    {
        for sign in [-1.0, 1.0] {
            let mut moved = after.clone();
            *moved.get_mut(name).expect(name) += sign * step;
            assert!(rms(&moved) > rms(&after), "{name} by {}", sign * step);
        }
    }
    // The less a target holds, the more it costs; and what holds the magnitude loses nothing of it.
    let costs = ["px4", "ardupilot", "betaflight"].map(|form| {
        let scale: &[&str] = if form == "betaflight" { &["--ut-per-count", "0.1"] } else { &[] };
        let run = with(form, &[&["--log", text(&log)], scale].concat());
        run["cost"]["held_rms_ut"].as_f64().expect("an error")
    });
    assert!((costs[0] - whole).abs() < 1e-6 && costs[1] > whole && costs[2] > costs[1], "{costs:?}");
    let heading = &with("px4", &["--log", text(&log)])["cost"]["heading"];
    let between = heading["between_deg"].as_f64().expect("an angle");
    assert!(between > 0.5, "the rotation that is lost shows in the heading: {heading}");
    assert!(heading["held_error_deg"].as_f64() > heading["error_deg"].as_f64(), "{heading}");
}

#[test]
fn what_cannot_be_written_is_refused_with_the_remedy() {
    let here = folder("exports_refused");
    let plain = cal(&here, &SYMMETRIC, &[], reading(&[]));
    let message = |options: &[&str]| {
        let run = ironout(["export", text(&plain), "--json"].iter().chain(options));
        run.error()["message"].as_str().expect("text").to_string()
    };
    assert!(message(&["--as", "px4", "--number", "4"]).contains("from 0 to 3"));
    assert!(message(&["--as", "ardupilot", "--number", "0"]).contains("from 1 to 3"));
    assert!(message(&["--as", "rust", "--number", "1"]).contains("--number says nothing to --as rust"));
    assert!(message(&["--as", "ros", "--device-id", "1"]).contains("leave it out"));
    assert!(message(&["--as", "ros", "--euler"]).contains("--euler says nothing"));
    assert!(message(&["--as", "iio"]).contains("--ut-per-count"));
    assert!(message(&["--as", "iio", "--ut-per-count", "-1"]).contains("positive"));
    assert!(message(&["--as", "px4", "--log", "nothing.csv"]).contains("no such file"));
    let short = log(&here);
    assert!(message(&["--as", "px4", "--log", text(&short)]).contains("too few samples"));
    let mirrored = cal(&here, &SYMMETRIC, &[], reading(&["mag:-x,y,z"]));
    let error = ironout(["export", text(&mirrored), "--as", "px4", "--json"]).error();
    assert!(error["message"].as_str().is_some_and(|text| text.contains("mirror")), "{error}");
    let needs =
        cal(&here, &SYMMETRIC, &[offset("offset:load_a", "load_a", 1.0, [0.1; 3], [0.0, 2.0])], reading(&[]));
    let run = ironout(["export", text(&needs), "--as", "px4", "--log", text(&short), "--json"]);
    assert_eq!(run.error()["column"], "load_a");
}

#[test]
fn of_two_currents_the_one_that_moves_more_is_held() {
    let here = folder("exports_two");
    let log = log(&here);
    let effects = [
        offset("offset:motor_a", "motor_a", 4.0, [0.01, 0.02, 0.0], [0.0, 12.0]),
        offset("offset:current_a", "current_a", 9.0, [0.31, -0.12, 0.07], [0.0, 30.0]),
        json!({
            "id": "gain:temp_c", "name": "", "columns": ["temp_c"], "coefficients": [1e-4, 2e-4, -1e-4],
            "std_errors": [1e-5, 1e-5, 1e-5], "unit": "", "reference": {"temp_c": 25.0}, "parameters": {},
        }),
    ];
    let cal = cal(&here, &SYMMETRIC, &effects, reading(&[]));
    let file = exported(&cal, "px4", &[]);
    assert!(file.contains("the effect offset:motor_a: PX4 has room for one current or throttle"), "{file}");
    assert!(file.contains("the effect gain:temp_c: PX4 has no place for it"), "{file}");
    let p = px4(&file);
    assert!((p["CAL_MAG0_XCOMP"] + 3.1).abs() < 1e-6, "{p:?}");
    // Without those two it is the calibration.
    let less = common::write(&here, "less.json", {
        let mut value: Value =
            serde_json::from_str(&std::fs::read_to_string(&cal).expect("text")).expect("JSON");
        value["effects"] = json!([effects[1]]);
        value.to_string()
    });
    let truth = Truth::of(&less, &log);
    truth.assert_same("two currents", 2e-6, |row, raw| px4_corrects(&p, 0, raw, &truth, row));
}
