//! Tables as people really have them: the unit from the sphere's radius, columns known by what they are, headers of two lines, rows
//! of other widths. Each case has its right value, and variants of the same class: other units, offsets, rates, orders, separators.

use crate::common::{case, ironout, text};
use ironout_cli::failure::Failure;
use ironout_cli::input::{Log, ReadOptions, parse_map, read_stream};
use ironout_cli::read_block;

fn read(content: &str, map: &[&str]) -> Result<Log, Failure> {
    let map: Vec<String> = map.iter().map(|part| part.to_string()).collect();
    let options = ReadOptions { map: parse_map(&map)?, ..ReadOptions::default() };
    read_stream(content.as_bytes(), 0, &options)
}

/// A field of `field` in every direction about an offset, as a person turns a telephone: 1 s a row is not said.
struct Turned {
    field: f64,
    offset: [f64; 3],
    noise: f64,
    rows: usize,
    /// From pole to pole, or the other way round.
    upward: bool,
}

impl Turned {
    fn new(field: f64, offset: [f64; 3]) -> Self {
        Turned { field, offset, noise: 0.005 * field, rows: 90, upward: false }
    }

    fn reading(&self, row: usize) -> [f64; 3] {
        let t = (row as f64 + 0.5) / self.rows as f64;
        let z = if self.upward { 2.0 * t - 1.0 } else { 1.0 - 2.0 * t };
        let (r, turn) = ((1.0 - z * z).sqrt(), row as f64 * 2.399_963);
        let noise = |axis: usize| {
            let n = (row as u32 + 1).wrapping_mul(2_654_435_761) ^ (axis as u32).wrapping_mul(0x9e37_79b9);
            self.noise * (f64::from(n.wrapping_mul(0x85eb_ca6b) >> 16) / 32_768.0 - 1.0)
        };
        let direction = [r * turn.cos(), r * turn.sin(), z];
        [0, 1, 2].map(|axis| self.field * direction[axis] + self.offset[axis] + noise(axis))
    }

    fn table(&self, header: &str, mut line: impl FnMut(usize, [f64; 3]) -> String) -> String {
        let head = if header.is_empty() { String::new() } else { format!("{header}\n") };
        (0..self.rows).fold(head, |text, row| text + &line(row, self.reading(row)) + "\n")
    }
}

/// Unit, and µT of one.
const UNITS: [(&str, f64); 5] = [("uT", 1.0), ("mG", 0.1), ("G", 100.0), ("nT", 1e-3), ("T", 1e6)];

#[track_caller]
fn unit_of(log: &Log) -> String {
    let column = log.read_as.columns.iter().find(|column| column.name == "mx_ut");
    column.unwrap_or_else(|| panic!("no field: {}", read_block::text(log))).unit.clone()
}

#[track_caller]
fn source_of(log: &Log, name: &str) -> String {
    let column = log.read_as.columns.iter().find(|column| column.name == name);
    column.map(|column| column.source.clone()).unwrap_or_default()
}

#[test]
fn the_radius_decides_the_unit_whatever_the_offset_order_separator_and_header() {
    for (unit, ut) in UNITS {
        for field_ut in [22.0, 36.0, 48.0, 66.0] {
            for offset_fields in [[0.0; 3], [3.1, -10.4, 1.2], [-0.4, 0.5, 0.6]] {
                let offset = offset_fields.map(|share| share * field_ut / ut);
                for upward in [false, true] {
                    let turned = Turned { upward, ..Turned::new(field_ut / ut, offset) };
                    let logs = [
                        turned.table("x,y,z", |_, [x, y, z]| format!("{x},{y},{z}")),
                        turned.table("time_s;z;x;y", |row, [x, y, z]| {
                            format!("{:.2};{z:e};{x:e};{y:e}", row as f64 * 0.02)
                        }),
                        turned.table("", |_, [x, y, z]| format!("{x}\t{y}\t{z}")),
                        turned
                            .table("", |row, [x, y, z]| format!("{:.3} {x} {y} {z}", 7.0 + row as f64 * 0.1)),
                        turned.table("MagX MagY MagZ", |_, [x, y, z]| format!("{x} {y} {z}")),
                        turned.table("t_ms|Mag_x|Mag_y|Mag_z|temp_c", |row, [x, y, z]| {
                            format!("{}|{x}|{y}|{z}|21.5", row * 20)
                        }),
                    ];
                    for log in logs {
                        let found = read(&log, &[]).unwrap_or_else(|failure| {
                            panic!("{unit} {field_ut} {offset:?} {upward}: {failure}\n{}", &log[..200])
                        });
                        assert_eq!(unit_of(&found), unit, "{field_ut} {offset:?} {upward}\n{}", &log[..200]);
                    }
                }
            }
        }
    }
}

#[test]
fn a_field_that_no_unit_makes_the_earths_is_neither_offered_nor_accepted() {
    for radius in [1.0, 4.4, 10.0, 14.0, 100.0, 150.0] {
        for decade in [1e-6, 1e-3, 1.0, 1e3] {
            let turned = Turned::new(radius * decade, [2.0 * radius * decade, 0.0, -radius * decade]);
            for log in [
                turned.table("x,y,z", |_, [x, y, z]| format!("{x},{y},{z}")),
                turned.table("", |_, [x, y, z]| format!("{x} {y} {z}")),
            ] {
                let failure = read(&log, &[]).map(|log| read_block::text(&log)).expect_err("a question");
                assert!(failure.message.contains("in no unit"), "{radius} {decade}: {failure}");
                assert!(!failure.message.contains("mx_ut="), "{radius} {decade}: {failure}");
            }
        }
    }
    // Stated, and contradicted by the radius, with the unit that is right.
    for (name, factor, right) in
        [("mx_ut", 10.0, "mG"), ("mx_mg", 1.0, "uT"), ("mx_ut", 0.01, "G"), ("mx_nt", 1.0, "uT")]
    {
        let here = crate::common::folder("cases_tables_stated");
        let names = ["x", "y", "z"].map(|axis| name.replacen('x', axis, 1)).join(",");
        let turned = Turned::new(48.0 * factor, [20.0 * factor, 300.0 * factor, 0.0]);
        let log = turned
            .table(&format!("t_s,{names}"), |row, [x, y, z]| format!("{},{x},{y},{z}", row as f64 * 0.5));
        let path = crate::common::write(&here, "log.csv", log);
        let run = ironout(["fit", text(&path)]);
        assert_eq!(run.status, 2, "{name}: {}{}", run.stdout, run.stderr);
        assert!(run.said().contains(&format!("mx_ut={name}[{right}]")), "{name}: {}", run.stderr);
    }
}

#[test]
fn a_sensor_that_was_hardly_turned_is_asked_about_and_one_level_turn_bounds_the_field() {
    // 48 µT, of which 20 are horizontal.
    let level = |row: usize| {
        let turn = row as f64 * 0.1;
        [20.0 * turn.cos() + 310.0, 20.0 * turn.sin() - 90.0, 43.6]
    };
    let log = (0..200).fold("x,y,z\n".to_string(), |text, row| {
        let [x, y, z] = level(row);
        text + &format!("{x:.3},{y:.3},{:.3}\n", z + 0.01 * (row % 7) as f64)
    });
    assert_eq!(unit_of(&read(&log, &[]).expect("one unit")), "uT");
    let log = (0..200).fold("x,y,z\n".to_string(), |text, row| {
        let n = |k: usize| ((row * k) % 17) as f64 * 0.03;
        text + &format!("{:.3},{:.3},{:.3}\n", 20.0 + n(7), -30.0 + n(11), 40.0 + n(13))
    });
    let failure = read(&log, &[]).map(|log| read_block::text(&log)).expect_err("a question");
    for word in ["rotated too little", "mx_ut=x[uT]", "mx_ut=x[mG]"] {
        assert!(failure.message.contains(word), "{failure}");
    }
}

#[test]
fn directions_are_refused_under_every_name() {
    for (length, digits) in [(1.0, 4), (48.0, 5), (48.0, 3), (50_000.0, 1), (1e-4, 12)] {
        let turned = Turned { noise: 0.0, ..Turned::new(length, [0.0; 3]) };
        for header in ["t_s,mx_ut,my_ut,mz_ut", "time_s,MagX,MagY,MagZ", "", "t_s,x,y,z"] {
            let log = turned.table(header, |row, [x, y, z]| {
                format!("{:.2},{x:.digits$},{y:.digits$},{z:.digits$}", row as f64 * 0.1)
            });
            let here = crate::common::folder("cases_tables_directions");
            let path = crate::common::write(&here, "log.csv", log);
            let run = ironout(["fit", text(&path)]);
            // Columns without names need not even be taken for a magnetometer.
            let named = header.contains("mx") || header.contains("Mag");
            let told = run.said().contains("the vectors are normalised") || !named;
            assert!(run.status == 2 && told, "{length} {header}: {}{}", run.stdout, run.stderr);
        }
    }
}

#[test]
fn columns_without_names_are_known_by_what_they_are() {
    let gravity = |row: usize| {
        let (a, b) = (row as f64 * 0.7, row as f64 * 1.3);
        [9.8 * a.cos() * b.cos(), 9.8 * a.sin() * b.cos(), -9.8 * b.sin()]
    };
    let quaternion = |row: usize| {
        let half = row as f64 * 0.02;
        [half.cos(), half.sin() * 0.6, 0.0, half.sin() * 0.8]
    };
    let joined = |values: &[f64]| values.iter().map(|value| format!("{value:.5}")).collect::<Vec<_>>();
    for upward in [false, true] {
        let turned = Turned { upward, ..Turned::new(0.48, [0.05, -0.9, 0.3]) };
        for separator in [",", "\t", ";", " "] {
            for order in 0..4 {
                let mut place = 0;
                let log = turned.table("", |row, m| {
                    let time = vec![format!("{:.2}", row as f64 * 0.1)];
                    let (m, a, q) = (joined(&m), joined(&gravity(row)), joined(&quaternion(row)));
                    let norm =
                        vec![format!("{:.5}", turned.reading(row).iter().map(|v| v * v).sum::<f64>().sqrt())];
                    let parts: Vec<Vec<String>> = match order {
                        0 => vec![time, q, a, m],
                        1 => vec![time, m, norm, a, q],
                        2 => vec![m, norm, time, a],
                        _ => vec![time, a, m],
                    };
                    place = [9, 2, 1, 5][order];
                    parts.concat().join(separator)
                });
                let found = read(&log, &[])
                    .unwrap_or_else(|failure| panic!("{separator:?} {order} {upward}: {failure}"));
                let said = read_block::text(&found);
                assert_eq!(
                    source_of(&found, "mx_ut"),
                    format!("column {place}"),
                    "{separator:?} {order} {upward}\n{said}"
                );
                assert!(
                    unit_of(&found) == "G" && found.time_s.is_some() && found.accel_mps2.is_some(),
                    "{order} {said}"
                );
                assert!(found.covariates.is_empty(), "{order} {said}");
            }
        }
    }
}

#[test]
fn headers_of_two_lines_shorter_headers_and_sensors_of_other_widths() {
    let turned = Turned::new(48.0, [10.0, -200.0, 5.0]);
    let row =
        |values: &[f64], mark: &str| values.iter().map(|v| format!("{v:.4}")).collect::<Vec<_>>().join(mark);
    for mark in [";", ",", "\t"] {
        let cells = |text: &str| text.replace(';', mark);
        let groups = cells("Time;Accelerometer;;;Magnetometer;;") + "\n" + &cells("s;X;Y;Z;X;Y;Z");
        let units =
            cells("time;ax;ay;az;magx;magy;magz") + "\n" + &cells("(s);(m/s²);(m/s²);(m/s²);(µT);(µT);(µT)");
        for header in [groups, units] {
            let log =
                turned.table(&header, |at, [x, y, z]| row(&[at as f64 * 0.1, 0.1, 0.2, 9.8, x, y, z], mark));
            let found = read(&log, &[]).unwrap_or_else(|failure| panic!("{header}: {failure}"));
            let said = read_block::text(&found);
            assert!(
                found.rows == 90 && found.field_ut[1][3] == (turned.reading(3)[1] * 1e4).round() / 1e4,
                "{said}"
            );
            assert!(found.time_s.is_some() && unit_of(&found) == "uT", "{said}");
            assert!(found.read_as.left_out.is_empty(), "{said}");
        }
        let short = cells("Id;MagX;MagY;MagZ");
        for tail in ["", "7.5"] {
            let log = turned
                .table(&short, |at, [x, y, z]| row(&[at as f64, x, y, z], mark) + mark + mark + tail + mark);
            let found = read(&log, &[]).unwrap_or_else(|failure| panic!("{short} {tail:?}: {failure}"));
            assert_eq!(source_of(&found, "mz_ut"), "MagZ", "{}", read_block::text(&found));
        }
        for (word, other) in [("mag", "imu"), ("MAG", "ACC"), ("magnetometer", "gyro")] {
            let log = turned.table("", |at, [x, y, z]| {
                let time = format!("{:.1}", at as f64 * 100.0);
                let mag = [time.clone(), word.into(), row(&[x, y, z], mark)].join(mark);
                let imu = [time, other.into(), row(&[0.1, 0.2, 9.8, 0.0, 0.1, 0.2], mark)].join(mark);
                format!("{imu}\n{mag}")
            });
            let found = read(&log, &[]).unwrap_or_else(|failure| panic!("{word}: {failure}"));
            let said = read_block::text(&found);
            assert!(found.rows == 90 && unit_of(&found) == "uT" && said.contains(other), "{said}");
        }
    }
}

#[test]
fn one_axis_a_line_and_slashes() {
    let turned = Turned::new(48.0, [10.0, -20.0, 5.0]);
    let log = turned.table("", |row, m| {
        let lines = ["X", "Y", "Z"].iter().zip(m).map(|(axis, value)| {
            format!("[12:{:02}:{:02}][D][sensor:094]: 'QMC5883L Field Strength {axis}': Sending state {value:.5} µT with 1 decimals of accuracy", row / 60, row % 60)
        });
        lines.collect::<Vec<_>>().join("\n")
    });
    let found = read(&log, &[]).expect("ESPHome");
    assert!(
        found.rows == 90 && unit_of(&found) == "uT" && found.time_s.is_some(),
        "{}",
        read_block::text(&found)
    );
    let log = turned.table("", |_, m| {
        let lines =
            ["x", "y", "z"].iter().zip(m).map(|(axis, value)| format!("'Mag {axis}' >> {value:.2} µT"));
        lines.collect::<Vec<_>>().join("\n")
    });
    assert_eq!(read(&log, &[]).expect("ESPHome of 2025").rows, 90);
    for (line, unit) in [("Raw {} heading 12", "uT"), ("mag: {} uT", "uT"), ("{}", "uT")] {
        let log = turned.table("", |_, [x, y, z]| line.replace("{}", &format!("{x:.3}/{y:.3}/{z:.3}")));
        let found = read(&log, &[]).unwrap_or_else(|failure| panic!("{line}: {failure}"));
        assert!(found.rows == 90 && unit_of(&found) == unit, "{}", read_block::text(&found));
    }
}

#[test]
fn nothing_that_cannot_be_a_field_is_proposed() {
    for name in ["p1_no_magnetometer.json", "p2_rotation_matrix.txt"] {
        let Some(path) = case(name) else { return };
        let run = ironout(["fit", text(&path)]);
        assert_eq!(run.status, 2, "{}", run.stdout);
        assert!(
            run.said().contains("no magnetometer found") && run.said().contains("mx_ut=HEADER"),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn the_shared_cases_have_their_right_values() {
    // Unit, columns and radius, µT.
    for (name, unit, first, field_ut) in [
        ("u1_uncal_no_header.txt", "uT", "column 2", 48.0),
        ("u2_uncal_sensor_logger.csv", "uT", "x", 48.0),
        ("u3_asked_uT_or_mG.csv", "uT", "x", 44.0),
        ("h1_two_header_rows.csv", "G", "Unit Magnetometer X", 48.0),
        ("h2_quaternion_no_header.csv", "G", "column 9", 48.0),
        ("h3_rows_longer_than_header.csv", "uT", "MagX", 48.0),
        ("s1_sensor_names_rows_of_two_widths.csv", "G", "column 3", 48.0),
        ("p3_nT_norm_time_step.txt", "nT", "column 1", 48.0),
        ("20_esphome.txt", "uT", "HMC5883L Field Strength X (µT)", 51.4),
        ("20_slash.txt", "G", "Raw[0]", 51.4),
    ] {
        let Some(path) = case(name) else { return };
        let object = ironout(["fit", text(&path), "--json"]).json();
        let mx =
            object["read_as"]["columns"].as_array().expect("columns").iter().find(|c| c["name"] == "mx_ut");
        let mx = mx.unwrap_or_else(|| panic!("{name}: {object}"));
        assert_eq!((mx["unit"].as_str(), mx["source"].as_str()), (Some(unit), Some(first)), "{name}");
        let field = object["field_ut"].as_f64().expect("a field");
        assert!((field / field_ut - 1.0).abs() < 0.02, "{name}: {field}");
    }
    for (name, words) in [
        ("n1_normalised_48.csv", &["the same magnitude", "normalised"][..]),
        ("n2_normalised_ros.csv", &["the same magnitude", "normalised"]),
        ("e6_ros_normalised.mcap", &["the same magnitude", "normalised"]),
        ("n3_accelerometer_g_no_header.txt", &["radius 1.00", "accelerometer in g", "--ut-per-count"]),
        ("14_motioncal_int.txt", &["10 times too small", "mx_ut=mx[uT]"]),
        ("e5_ros_in_microtesla.mcap", &["1000000 times too large", "48.0 µT", "[uT]"]),
    ] {
        let Some(path) = case(name) else { return };
        let message =
            ironout(["fit", text(&path), "--json"]).error()["message"].as_str().expect("words").to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{name}: {message}");
    }
    let Some(path) = case("14_motioncal_int.txt") else { return };
    let run = ironout(["fit", text(&path), "--map", "mx_ut=mx[uT],my_ut=my[uT],mz_ut=mz[uT]", "--json"]);
    let offset = run.json()["offset_ut"].clone();
    for (axis, truth) in [12.0, -25.0, 31.0].into_iter().enumerate() {
        assert!((offset[axis].as_f64().expect("a number") - truth).abs() < 0.5, "{offset}");
    }
    // Its gyro hardly moves while the field goes all round: without a time column that is no rest.
    let run = ironout(["diagnose", text(&path), "--map", "mx_ut=mx[uT],my_ut=my[uT],mz_ut=mz[uT]", "--json"]);
    assert_eq!(run.json()["verdict"], "complete", "{}", run.stdout);
}
