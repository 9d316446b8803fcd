//! ArduPilot DataFlash, binary and text: files of the test's own writer against the CSV they were made from.

use crate::common::write;
use crate::writers::dataflash::Cell::{N, T};
use crate::writers::dataflash::Dataflash;
use crate::writers::fuzz::fuzz;
use crate::writers::truth::{
    Truth, assert_column, assert_same_calibration, assert_sensors, fitted, python, python_has, read,
    read_with, times,
};
use ironout_cli::input::ReadOptions;

/// What ArduPilot applied to a compass: `M·((raw + offset)·scale) + motor`, mG.
struct Applied {
    offset: [f64; 3],
    matrix: [[f64; 3]; 3],
    scale: f64,
    /// A sample of motor compensation, mG a row of the log.
    motor: [f64; 3],
}

const NOTHING: Applied = Applied {
    offset: [0.0; 3],
    matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    scale: 1.0,
    motor: [0.0; 3],
};

const APPLIED: Applied = Applied {
    offset: [-120.4, 333.25, 51.5],
    matrix: [[1.05, 0.02, -0.01], [0.02, 0.96, 0.03], [-0.01, 0.03, 1.02]],
    scale: 1.1,
    motor: [0.01, -0.02, 0.03],
};

fn flight(truth: &Truth, applied: &Applied) -> Dataflash {
    let mut file = Dataflash::new();
    file.message("MSG", &[N(1000.0), T("ArduCopter V4.5.7 (2a3dc4b7)")]);
    let mut parameter =
        |name: &str, value: f64| file.message("PARM", &[N(2000.0), T(name), N(value), N(0.0)]);
    // Compass 0 by priority is the second that was detected.
    parameter("COMPASS_PRIO1_ID", 658953.0);
    parameter("COMPASS_DEV_ID", 97539.0);
    parameter("COMPASS_DEV_ID2", 658953.0);
    parameter("COMPASS_PRIO2_ID", 97539.0);
    for (letter, offset, diagonal) in [("X", 7.0, 2.0), ("Y", 0.0, 1.0), ("Z", 0.0, 1.0)] {
        parameter(&format!("COMPASS_OFS_{letter}"), offset);
        parameter(&format!("COMPASS_DIA_{letter}"), diagonal);
    }
    parameter("COMPASS_SCALE2", applied.scale);
    for (axis, letter) in ["X", "Y", "Z"].iter().enumerate() {
        parameter(&format!("COMPASS_OFS2_{letter}"), applied.offset[axis]);
        parameter(&format!("COMPASS_DIA2_{letter}"), applied.matrix[axis][axis]);
    }
    for (letter, (i, j)) in ["X", "Y", "Z"].iter().zip([(0, 1), (0, 2), (1, 2)]) {
        parameter(&format!("COMPASS_ODI2_{letter}"), applied.matrix[i][j]);
    }
    for row in 0..truth.log.rows {
        let time = N(3e6 + truth.micros(row) as f64);
        let (g, a) = (truth.gyro(row), truth.accel(row));
        let rest = [N(0.0), N(0.0), N(35.5), N(1.0), N(1.0), N(1000.0), N(1000.0)];
        for instance in [0.0, 1.0] {
            // The second IMU says something else, and must not be mixed in.
            let [gx, gy, gz] = g.map(|value| N(value + instance));
            let [ax, ay, az] = a.map(|value| N(value + instance));
            file.message("IMU", &[&[time, N(instance), gx, gy, gz, ax, ay, az][..], &rest].concat());
        }
        let current = N(truth.covariate("current_a", row));
        let zero = N(0.0);
        file.message("BAT", &[time, zero, N(16.0), N(16.0), current, zero, zero, zero, N(21.5), zero]);
        if row % 10 == 0 {
            let place = [N(-35.363_261), N(149.165_237), N(584.0)];
            file.message(
                "GPS",
                &[&[time, zero, N(3.0), zero, zero, N(9.0), N(0.8)][..], &place, &[zero, zero]].concat(),
            );
            file.message(
                "RCOU",
                &[time, N(1100.0 + f64::from(row as u16 / 10)), N(1200.0), N(1300.0), N(1400.0)],
            );
            file.message(
                "ESC",
                &[time, N(2.0), N(9000.0), zero, N(15.9), N(7.25), N(44.5), zero, zero, zero],
            );
        }
        let raw = truth.field(row).map(|value| value * 10.0);
        let sum = [0, 1, 2].map(|i| (raw[i] + applied.offset[i]) * applied.scale);
        let motor = applied.motor.map(|share| (share * row as f64).trunc());
        let corrected = times(&applied.matrix, sum);
        let [mx, my, mz] = [0, 1, 2].map(|i| N(corrected[i] + motor[i]));
        let [ox, oy, oz] = applied.offset.map(|value| N(value.trunc()));
        let [px, py, pz] = motor.map(N);
        file.message("MAG", &[time, zero, mx, my, mz, ox, oy, oz, px, py, pz, N(1.0), zero]);
        file.message(
            "MAG",
            &[time, N(1.0), N(100.0), N(200.0), N(300.0), N(7.0), zero, zero, zero, zero, zero, N(1.0), zero],
        );
    }
    file
}

#[test]
fn both_forms_give_what_the_csv_gives_with_and_without_a_calibration_applied() {
    let truth = Truth::new("dataflash");
    let own = fitted(&truth.csv, &[]);
    for (name, applied) in [("raw", &NOTHING), ("applied", &APPLIED)] {
        let file = flight(&truth, applied);
        for (form, bytes) in [("bin", file.binary.as_slice()), ("log", file.text.as_bytes())] {
            let log = read(bytes).unwrap_or_else(|failure| panic!("{name}.{form}: {failure}"));
            // Whole milligauss, half of one either way, through the inverse of the matrix.
            assert_sensors(&log, &truth, 0.06, 2e-6, 1e-6);
            let column =
                |name: &str| log.covariate(name).unwrap_or_else(|| panic!("no {name}")).values.clone();
            let current = column("current_a");
            assert_column("current_a", &current, |row| truth.covariate("current_a", row), 1e-5);
            assert_column("output_1", &column("output_1"), |row| 1100.0 + row as f64 / 10.0, 1e-6);
            assert_column("lat_deg", &column("lat_deg"), |_| -35.363_261, 1e-7);
            assert_column("esc_3_a", &column("esc_3_a"), |_| 7.25, 1e-6);
            assert_column("battery_c", &column("battery_c"), |_| 21.5, 1e-6);
            assert!(log.notices.is_empty(), "{:?}", log.notices);
            assert!(log.read_as.format.contains("ArduCopter V4.5.7"), "{}", log.read_as.format);
            let told = log.read_as.taken_out.join("\n");
            assert!(told.contains("COMPASS_*2"), "the parameters of the second that was detected: {told}");
            assert_eq!(told.contains("MOX"), name == "applied", "{told}");
            let path = write(&truth.here, &format!("{name}.{form}"), bytes);
            // Rounding to 0.1 µT over 3000 rows.
            assert_same_calibration(&own, &fitted(&path, &[]), 0.02, 5e-4);
        }
    }
    let second = ReadOptions { instance: Some(1), ..ReadOptions::default() };
    let log = read_with(&flight(&truth, &APPLIED).binary, &second).expect("the second compass");
    // Its parameters are those of the first that was detected.
    assert_eq!(log.read_as.instance.as_ref().map(|instance| instance.taken), Some(1));
    for (axis, expected) in [4.3, 20.0, 30.0].into_iter().enumerate() {
        assert_eq!(assert_column("field", &log.field_ut[axis], |_| expected, 1e-9), log.rows);
    }
}

#[test]
fn what_is_cut_off_or_missing_is_said() {
    let truth = Truth::new("dataflash-broken");
    let file = flight(&truth, &APPLIED);
    let log = read(&file.binary[..file.binary.len() / 2 + 7]).expect("half a log");
    assert!(log.rows > 1300 && log.rows < 1700, "{}", log.rows);
    assert!(
        log.notices.iter().any(|notice| notice.contains("truncated inside a message")),
        "{:?}",
        log.notices
    );
    let half = &file.text.as_bytes()[..file.text.len() / 2];
    assert!(read(half).expect("half a text").rows > 1300);
    let mut holed = file.binary.clone();
    let middle = holed.len() / 2;
    holed[middle..middle + 500].fill(0x33);
    let log = read(&holed).expect("a log with a hole");
    assert!(
        log.rows > 2900 && log.notices.iter().any(|notice| notice.contains("not messages")),
        "{:?}",
        log.notices
    );
    let refused = {
        let mut without = Dataflash::new();
        without.message("RCOU", &[N(1.0), N(1.0), N(2.0), N(3.0), N(4.0)]);
        [read(&without.binary), read(without.text.as_bytes())]
    };
    for refused in refused {
        let refused = refused.expect_err("no compass");
        for part in ["MAG, MAG2, MAG3", "RCOU (1)", "LOG_BITMASK"] {
            assert!(refused.message.contains(part), "{refused}");
        }
    }
}

#[test]
fn readers_of_others_read_what_the_writer_wrote() {
    let truth = Truth::new("dataflash-readback");
    let file = flight(&truth, &APPLIED);
    let mags = ardupilot_binlog::Reader::new(file.binary.as_slice())
        .map(|entry| entry.expect("a good message"))
        .filter(|entry| entry.name == "MAG" && entry.get("I").and_then(|value| value.as_f64()) == Some(0.0));
    let fields: Vec<f64> =
        mags.map(|entry| entry.get("OfsY").and_then(|v| v.as_f64()).expect("a number")).collect();
    assert_eq!(fields.len(), truth.log.rows);
    assert!(fields.iter().all(|value| *value == 333.0));
    if python_has("pymavlink") {
        let path = write(&truth.here, "log.bin", &file.binary);
        let program = "import sys\nfrom pymavlink import DFReader\nr=DFReader.DFReader_binary(sys.argv[1])\nn=0\n\
                       while True:\n m=r.recv_match(type='MAG')\n if m is None: break\n n+=m.I==0 and m.OfsY==333\nprint(n)";
        assert_eq!(python(program, &path).trim(), truth.log.rows.to_string());
    }
}

#[test]
fn broken_files_are_answered_or_refused() {
    let truth = Truth::new("dataflash-fuzz");
    let file = flight(&truth, &APPLIED);
    let (binary, text) = (&file.binary[..30_000], &file.text.as_bytes()[..30_000]);
    let accepted = fuzz("DataFlash", &[binary, text], 4000);
    assert!(accepted > 300, "{accepted}");
    // A definition of a length that cannot be.
    for length in [0, 1, 2, 3] {
        let mut bytes = file.binary[..2000].to_vec();
        bytes[4 + 89] = length;
        let _ = read(&bytes);
    }
}
