//! What the tests of exports share: calibrations, a log, and the formulas of PX4 and ArduPilot, written out from their sources.

use super::{ironout, text, write};
use ironout_analysis::{Corrector, Table};
use ironout_cli::cal_file::CalFile;
use ironout_cli::input::{Log, Mounting, ReadOptions, read_log};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub type Vector = [f64; 3];
pub type Matrix = [[f64; 3]; 3];

pub fn times(m: &Matrix, v: Vector) -> Vector {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

pub fn norm(v: Vector) -> f64 {
    v.iter().map(|value| value * value).sum::<f64>().sqrt()
}

pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// `Rz(yaw) · Ry(pitch) · Rx(roll)`, as both autopilots take their angles.
pub fn euler(roll: f64, pitch: f64, yaw: f64) -> Matrix {
    let ((sr, cr), (sp, cp)) = (roll.to_radians().sin_cos(), pitch.to_radians().sin_cos());
    let (sy, cy) = yaw.to_radians().sin_cos();
    let x = [[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]];
    let y = [[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]];
    let z = [[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]];
    product(&z, &product(&y, &x))
}

/// The mountings that the cases use, by the number of `MAV_SENSOR_ORIENTATION` (mavlink common.xml).
pub fn orientation(number: usize) -> Matrix {
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
pub fn log(here: &Path) -> PathBuf {
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

pub const SYMMETRIC: Matrix = [[1.07, 0.031, -0.012], [0.031, 0.94, 0.045], [-0.012, 0.045, 1.01]];

/// An entry of a calibration file.
pub fn offset(id: &str, column: &str, reference: f64, theta: Vector, range: [f64; 2]) -> Value {
    json!({
        "id": id, "name": "", "columns": [column], "coefficients": theta, "std_errors": [1e-3, 1e-3, 1e-3], "unit": "",
        "reference": {column: reference}, "parameters": {}, "range": {column: range},
    })
}

/// A calibration file.
pub fn cal(here: &Path, matrix: &Matrix, effects: &[Value], reading: Value) -> PathBuf {
    let fixture = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/cal.json"));
    let mut file: Value =
        serde_json::from_str(&std::fs::read_to_string(fixture).expect("text")).expect("JSON");
    file["effects"] = effects.into();
    file["matrix"] = json!(matrix);
    file["reading"] = reading;
    write(here, "cal.json", file.to_string())
}

pub fn reading(rotate: &[&str]) -> Value {
    json!({"ut_per_count": null, "rotate": rotate})
}

/// What the calibration makes of every row, and the row as the sensor gave it.
pub struct Truth {
    pub log: Log,
    pub raw: Log,
    pub corrected: Vec<Vector>,
}

impl Truth {
    pub fn of(cal: &Path, path: &Path) -> Self {
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

    pub fn column(&self, name: &str, row: usize) -> f64 {
        self.log.covariate(name).unwrap_or_else(|| panic!("{name}")).values[row]
    }

    /// Every row against what the target makes of it, within `most_ut`.
    pub fn assert_same(&self, what: &str, most_ut: f64, target: impl Fn(usize, Vector) -> Vector) {
        for (row, wanted) in self.corrected.iter().enumerate() {
            let own = target(row, self.raw.field(row));
            let off = norm(std::array::from_fn(|axis| own[axis] - wanted[axis]));
            assert!(off <= most_ut, "{what}, row {row}: {own:?} for {wanted:?}");
        }
    }

    /// Magnitudes alone, within `most_ut`, and the largest angle between the two, degrees.
    pub fn assert_same_magnitude(&self, most_ut: f64, target: impl Fn(usize, Vector) -> Vector) -> f64 {
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

pub fn exported(cal: &Path, form: &str, options: &[&str]) -> String {
    let run = ironout(["export", text(cal), "--as", form].iter().chain(options));
    assert_eq!(run.status, 0, "{form}: {}", run.stderr);
    run.stdout
}

/// The rows of a file that are no comments.
pub fn rows(file: &str) -> impl Iterator<Item = &str> {
    file.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty())
}

/// PX4: name and value, with the type that MAVLink has for it.
pub fn px4(file: &str) -> BTreeMap<String, f64> {
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

pub fn mag_angle(p: &BTreeMap<String, f64>, n: usize, name: &str) -> f64 {
    p[&format!("CAL_MAG{n}_{name}")]
}

/// `Magnetometer::Correct` and `TemperatureCompensation::calc_thermal_offsets_3D` of PX4, in µT.
pub fn px4_corrects(
    p: &BTreeMap<String, f64>,
    n: usize,
    raw_ut: Vector,
    truth: &Truth,
    row: usize,
) -> Vector {
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
pub fn ardupilot(file: &str) -> BTreeMap<String, f64> {
    rows(file)
        .map(|line| {
            let (name, value) = line.split_once(',').expect("NAME,VALUE");
            assert!(name.len() <= 16, "a name of MAVLink: {line}");
            (name.to_string(), value.parse().expect("a number"))
        })
        .collect()
}

/// `rotate_field` and `correct_field` of AP_Compass_Backend, in µT.
pub fn ardupilot_corrects(
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
