//! Columns that are made of the field: known by what they are, left out of a diagnosis and named; columns that are not are left alone.
//! `IRONOUT_COPIES_LOGS=1000` looks at so many simulated logs.

use crate::common::{case, ironout, text};
use ironout_analysis::Table;
use ironout_analysis::plausible::causes::no_causes;
use ironout_analysis::samples::faults::{FaultKind, find};
use ironout_cli::input::{ReadOptions, read_stream};
use ironout_simulation::truths::{Kind, draw};
use std::io::Write;
use std::path::Path;

#[test]
fn copies_of_the_field_are_left_out_of_a_diagnosis_and_named() {
    for (name, verdict) in
        [("c1_filtered_copies.csv", "complete"), ("c2_filtered_copies_long.csv", "unexplained")]
    {
        let Some(path) = case(name) else { return };
        let run = ironout(["diagnose", text(&path), "--json"]);
        assert!(run.said().contains("ironout ignores heading_deg"), "{}", run.stderr);
        let object = run.json();
        assert_eq!(object["verdict"], verdict, "{object}");
        assert_eq!(object["steps"].as_array().map(Vec::len), Some(1), "{object}");
        for column in ["fx_uT", "fy_uT", "fz_uT", "Bf_uT"] {
            let id = format!("offset:{column}");
            let rows = object["candidates"].as_array().expect("candidates");
            let row = rows
                .iter()
                .find(|row| row["id"] == id.as_str())
                .unwrap_or_else(|| panic!("{column}: {object}"));
            let why = row["why"].as_str().unwrap_or_default();
            assert!(row["status"] == "untestable" && why.contains("of the field"), "{row}");
        }
    }
}

/// Copies of each kind, made from simulated logs, beside columns that are none: which are known.
#[test]
fn copies_of_every_kind_are_known_and_causes_are_not() {
    let (mut known, mut made, mut alarms, mut logs) = (0, 0, Vec::new(), 0);
    let wanted: u64 = std::env::var("IRONOUT_COPIES_LOGS").ok().and_then(|n| n.parse().ok()).unwrap_or(24);
    for number in 0..wanted {
        let kind = Kind::ALL[(number % Kind::ALL.len() as u64) as usize];
        let drawn = draw(kind, 0xc0_91e5, number);
        let log = drawn.world.run();
        let own = Table::from_columns(log.named()).expect("columns");
        logs += 1;
        for one in no_causes(&own) {
            alarms.push(format!(
                "{} {number} [{}]: {} is {}",
                kind.name(),
                drawn.words,
                own.covariates[one.covariate].name,
                one.what
            ));
        }
        if number % 4 != 0 {
            continue;
        }
        let [x, y, z] = own.field_ut;
        let norm: Vec<f64> =
            (0..own.rows()).map(|row| own.field(row).iter().map(|v| v * v).sum::<f64>().sqrt()).collect();
        let smooth = |values: &[f64], weight: f64| {
            let mut mean = values[0];
            values
                .iter()
                .map(|value| {
                    mean += weight * (value - mean);
                    mean
                })
                .collect::<Vec<f64>>()
        };
        let late = |values: &[f64], rows: usize| {
            (0..values.len()).map(|row| values[row.saturating_sub(rows)]).collect::<Vec<f64>>()
        };
        let copies = [
            smooth(x, 0.3),
            smooth(z, 0.1),
            late(y, 3),
            x.iter().map(|v| 0.1 * v + 7.0).collect(),
            norm.clone(),
            smooth(&norm, 0.2),
            y.iter().zip(z).map(|(y, z)| 0.6 * y - 0.8 * z).collect(),
            x.iter().zip(y).map(|(x, y)| (y.atan2(*x).to_degrees() * 10.0).round() / 10.0).collect(),
        ];
        for copy in &copies {
            let mut columns = log.named().collect::<Vec<_>>();
            columns.push(("copy", copy));
            let table = Table::from_columns(columns).expect("columns");
            let turned = drawn.words.contains("Tumbling")
                || drawn.words.contains("Eights")
                || drawn.words.contains("Acro");
            if turned {
                made += 1;
                known += usize::from(
                    no_causes(&table).iter().any(|one| table.covariates[one.covariate].name == "copy"),
                );
            }
        }
    }
    println!("{logs} logs: {} false alarms; {known} of {made} copies known", alarms.len());
    assert!(alarms.is_empty(), "{alarms:#?}");
    assert!(known * 10 >= made * 9, "{known} of {made}");
}

/// First and last time of readings that are a copy of earlier ones.
fn copied_rows(table: &Table) -> Vec<(Option<f64>, Option<f64>)> {
    let faults = find(table).list.into_iter().filter(|fault| fault.kind == FaultKind::CopiedRows);
    faults.map(|fault| (fault.from_s, fault.to_s)).collect()
}

/// Logs as they are and in coarse steps, where a board that turns evenly comes by the same readings again and again; and the same with
/// a part of them written twice.
#[test]
fn readings_that_are_there_twice_are_found_and_no_others_are() {
    let wanted: u64 = std::env::var("IRONOUT_COPIES_LOGS").ok().and_then(|n| n.parse().ok()).unwrap_or(48);
    let (mut alarms, mut found, mut made) = (Vec::new(), 0, 0);
    for number in 0..wanted {
        let kind = Kind::ALL[(number % Kind::ALL.len() as u64) as usize];
        let drawn = draw(kind, 0x00c0_91ed, number);
        let log = drawn.world.run();
        let own: Vec<(&str, &[f64])> = log.named().collect();
        for step_ut in [0.0, 0.15, 1.0, 3.4] {
            let coarse = |name: &str, values: &[f64]| -> Vec<f64> {
                let is_field = ["mx_ut", "my_ut", "mz_ut"].contains(&name) && step_ut > 0.0;
                values.iter().map(|v| if is_field { (v / step_ut).round() * step_ut } else { *v }).collect()
            };
            let columns: Vec<(&str, Vec<f64>)> =
                own.iter().map(|(name, values)| (*name, coarse(name, values))).collect();
            let table = Table::from_columns(columns.iter().map(|(name, values)| (*name, values.as_slice())));
            if let [(from, to), ..] = copied_rows(&table.expect("columns"))[..] {
                alarms.push(format!(
                    "{} {number} [{}] in {step_ut} µT: {from:?} to {to:?} s",
                    kind.name(),
                    drawn.words
                ));
            }
            // Some tenth of the log again, behind it, on a clock that goes on.
            let rows = columns[0].1.len();
            let (from, count) = (rows / 3, rows / 10);
            let twice: Vec<(&str, Vec<f64>)> = columns
                .iter()
                .map(|(name, values)| {
                    let again = values[from..from + count].iter();
                    let late = if *name == "t_s" { values[rows - 1] - values[from] + 1.0 } else { 0.0 };
                    (*name, values.iter().copied().chain(again.map(|value| value + late)).collect())
                })
                .collect();
            let table = Table::from_columns(twice.iter().map(|(name, values)| (*name, values.as_slice())));
            if step_ut == 0.15 {
                made += 1;
                found += usize::from(!copied_rows(&table.expect("columns")).is_empty());
            }
        }
    }
    println!("{wanted} logs, four ways each: {} false alarms; {found} of {made} copies found", alarms.len());
    assert!(alarms.is_empty(), "{alarms:#?}");
    // A board at rest in coarse steps has nothing that tells a copy.
    assert!(found * 10 >= made * 9, "{found} of {made}");
}

#[test]
fn no_column_of_a_recording_is_taken_for_a_copy() {
    let shared = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data"));
    let folders = [shared.to_path_buf(), shared.join("broad")];
    let mut looked = 0;
    for folder in folders {
        let Ok(entries) = std::fs::read_dir(&folder) else {
            let _ = writeln!(std::io::stderr(), "SKIPPED: the recordings are not here");
            return;
        };
        for path in entries.flatten().map(|entry| entry.path()) {
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_string();
            if !name.ends_with(".csv") || name.contains("truth") {
                continue;
            }
            let options = ReadOptions { default_ut_per_count: Some([0.1; 3]), ..ReadOptions::default() };
            let bytes = std::fs::read(&path).expect("a recording");
            let log = read_stream(bytes.as_slice(), 0, &options)
                .unwrap_or_else(|failure| panic!("{name}: {failure}"));
            let table = Table::from(&log);
            let found = no_causes(&table);
            assert!(
                found.is_empty(),
                "{name}: {found:?} of {:?}",
                log.covariates.iter().map(|c| &c.name).collect::<Vec<_>>()
            );
            assert!(!ironout_analysis::plausible::causes::heading_is_computed(&table), "{name}");
            assert_eq!(copied_rows(&table), [], "{name}");
            assert_eq!(ironout_analysis::plausible::directions::equal_magnitudes(&table), None, "{name}");
            looked += 1;
        }
    }
    assert!(looked >= 20, "{looked}");
}
