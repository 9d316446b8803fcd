//! Parquet and Arrow files: the log of the CSV, types, nulls, what is refused, damage.

use crate::common::{folder, ironout, text};
use arrow_array::types::Int8Type;
use arrow_array::{
    ArrayRef, BooleanArray, DictionaryArray, Float32Array, Float64Array, Int16Array, ListArray, RecordBatch,
    StringArray, TimestampMicrosecondArray,
};
use arrow_ipc::writer::FileWriter;
use ironout_simulation::{World, WorldOptions};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::properties::WriterProperties;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

type Columns = Vec<(String, ArrayRef)>;

fn batch(columns: Columns) -> RecordBatch {
    let nullable = columns.into_iter().map(|(name, array)| (name, array, true));
    RecordBatch::try_from_iter_with_nullable(nullable).expect("columns")
}

fn parquet(path: &Path, batch: &RecordBatch) -> PathBuf {
    // Several row groups, so that columns are put together.
    let properties = WriterProperties::builder().set_max_row_group_row_count(Some(700)).build();
    let file = File::create(path).expect("a file");
    let mut writer = ArrowWriter::try_new(file, batch.schema(), Some(properties)).expect("a writer");
    writer.write(batch).expect("rows");
    writer.close().expect("an end");
    path.to_path_buf()
}

fn arrow(path: &Path, batch: &RecordBatch) -> PathBuf {
    let mut writer =
        FileWriter::try_new(File::create(path).expect("a file"), &batch.schema()).expect("a writer");
    writer.write(batch).expect("rows");
    writer.finish().expect("an end");
    path.to_path_buf()
}

/// A simulated log as CSV, and its columns.
fn simulated(here: &Path) -> (PathBuf, Columns) {
    let log = World::new(WorldOptions { seed: 3, seconds: 40.0, ..WorldOptions::default() }).run();
    let path = here.join("log.csv");
    let mut csv = Vec::new();
    log.write_csv(&mut csv, "a log").expect("into memory");
    std::fs::write(&path, &csv).expect("a file");
    // Of the text, so that both have the same digits.
    let csv = String::from_utf8(csv).expect("text");
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<String> = lines.next().expect("a header").split(',').map(String::from).collect();
    let rows: Vec<Vec<Option<f64>>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().ok()).collect()).collect();
    let column =
        |index: usize| -> ArrayRef { Arc::new(Float64Array::from_iter(rows.iter().map(|row| row[index]))) };
    (path, names.into_iter().enumerate().map(|(index, name)| (name, column(index))).collect())
}

fn numbers(columns: &Columns, name: &str) -> Vec<Option<f64>> {
    let (_, array) = columns.iter().find(|(own, _)| own == name).expect("a column");
    array.as_any().downcast_ref::<Float64Array>().expect("numbers").iter().collect()
}

fn replace(columns: &mut Columns, name: &str, array: ArrayRef) {
    columns.iter_mut().find(|(own, _)| own == name).expect("a column").1 = array;
}

/// The answer without the names of the file and its format, which next commands repeat.
fn without_names(run: &crate::common::Run) -> serde_json::Value {
    let mut object = run.json();
    for key in ["read_as", "input", "report"] {
        object.as_object_mut().expect("an object").remove(key).expect("every answer has it");
    }
    object
}

#[test]
fn a_log_has_the_same_digits_as_its_csv() {
    let here = folder("columnar_same");
    let (csv, columns) = simulated(&here);
    let table = batch(columns);
    let files = [parquet(&here.join("log.parquet"), &table), arrow(&here.join("log.feather"), &table)];
    for command in ["fit", "diagnose"] {
        let expected = without_names(&ironout([command, text(&csv), "--json"]));
        for file in &files {
            let run = ironout([command, text(file), "--json"]);
            assert_eq!(without_names(&run), expected, "{}", run.stderr);
        }
    }
    let words = ironout(["fit", text(&files[0])]);
    assert!(words.stderr.contains("Parquet"), "{}", words.stderr);
    // By its content, not by its name.
    let renamed = here.join("log.csv.bin");
    std::fs::copy(&files[0], &renamed).expect("a copy");
    assert_eq!(ironout(["fit", text(&renamed)]).status, 0);
}

#[test]
fn types_nulls_texts_and_lists_are_read_or_named() {
    let here = folder("columnar_types");
    let (_, mut columns) = simulated(&here);
    let times: Vec<i64> = numbers(&columns, "t_s")
        .iter()
        .map(|t| 1_780_000_000_000_000 + (t.expect("a time") * 1e6).round() as i64)
        .collect();
    let rows = times.len();
    replace(&mut columns, "t_s", Arc::new(TimestampMicrosecondArray::from(times).with_timezone("UTC")));
    let with_gap = numbers(&columns, "temp_c").into_iter().enumerate();
    let with_gap = with_gap.map(|(row, value)| value.filter(|_| row != 7).map(|value| value as f32));
    replace(&mut columns, "temp_c", Arc::new(Float32Array::from_iter(with_gap)));
    let phase: DictionaryArray<Int8Type> = (0..rows).map(|row| ["taxi", "cruise"][row % 2]).collect();
    columns.push(("phase".into(), Arc::new(phase)));
    columns.push(("armed".into(), Arc::new(BooleanArray::from_iter((0..rows).map(|row| Some(row > 900))))));
    let covariance = (0..rows).map(|_| Some(vec![Some(1.0), Some(0.0)]));
    columns.push((
        "covariance".into(),
        Arc::new(ListArray::from_iter_primitive::<arrow_array::types::Float64Type, _, _>(covariance)),
    ));
    let file = parquet(&here.join("log.parquet"), &batch(columns.clone()));
    let run = ironout(["fit", text(&file), "--json"]);
    assert_eq!(run.status, 0, "{}", run.stderr);
    for words in [
        "ignored column phase: it contains text (\"taxi\")",
        "ignored column covariance: each cell is a list. Fix: write its numbers as columns of their own",
    ] {
        // Lines are broken for a terminal.
        let said: Vec<&str> = run.stderr.split_whitespace().collect();
        assert!(said.join(" ").contains(words), "{words}: {}", run.stderr);
    }
    let read: Vec<String> = run.json()["read_as"]["columns"]
        .as_array()
        .expect("columns")
        .iter()
        .map(|column| column["name"].as_str().expect("a name").to_string())
        .collect();
    assert!(read.contains(&"armed".to_string()) && read.contains(&"t_s".to_string()), "{read:?}");

    // A null of the magnetometer is refused by its row, as an empty cell of a CSV by its line.
    let mut gap = numbers(&columns, "my_ut");
    gap[4] = None;
    replace(&mut columns, "my_ut", Arc::new(Float64Array::from_iter(gap)));
    let file = arrow(&here.join("gap.feather"), &batch(columns));
    let error = ironout(["fit", text(&file), "--json"]).error();
    assert_eq!(error["column"], "my_ut");
    let message = error["message"].as_str().expect("words");
    assert!(
        message.starts_with("row 5: the cell is empty, but the magnetometer needs a number"),
        "{message}"
    );
}

#[test]
fn names_of_others_counts_and_maps() {
    let here = folder("columnar_names");
    let (_, columns) = simulated(&here);
    let field = ["mx_ut", "my_ut", "mz_ut"].map(|name| numbers(&columns, name));
    let milligauss = |axis: usize| -> ArrayRef {
        Arc::new(Float64Array::from_iter(field[axis].iter().map(|value| value.map(|value| value * 10.0))))
    };
    let named = |names: [&str; 3]| -> Columns {
        names.into_iter().enumerate().map(|(axis, name)| (name.to_string(), milligauss(axis))).collect()
    };
    let fit = |file: &Path, more: &[&str]| {
        let run = ironout(["fit", text(file), "--json"].iter().chain(more));
        assert_eq!(run.status, 0, "{} {}", run.stdout, run.stderr);
        run.json()["offset_ut"][0].as_f64().expect("an offset")
    };
    let by_name = parquet(&here.join("a.parquet"), &batch(named(["MagX (mG)", "MagY (mG)", "MagZ (mG)"])));
    let offset_ut = fit(&by_name, &[]);
    let mapped = parquet(&here.join("b.parquet"), &batch(named(["a", "b", "c"])));
    let same = fit(&mapped, &["--map", "mx_ut=a[mG],my_ut=b[mG],mz_ut=c[mG]"]);
    assert!((same - offset_ut).abs() < 1e-9, "{same} {offset_ut}");
    let counts: Columns = (0..3)
        .map(|axis| {
            let counts = field[axis].iter().map(|value| value.map(|value| (value / 0.1).round() as i16));
            let name = ["mx_counts", "my_counts", "mz_counts"][axis].to_string();
            (name, Arc::new(Int16Array::from_iter(counts)) as ArrayRef)
        })
        .collect();
    let counts = parquet(&here.join("c.parquet"), &batch(counts));
    assert!((fit(&counts, &["--ut-per-count", "0.1"]) - offset_ut).abs() < 0.02);

    // Without a magnetometer that can be read, the column that may hold it is named.
    let list = field[0].iter().map(|value| Some(vec![*value, *value, *value]));
    let list = ListArray::from_iter_primitive::<arrow_array::types::Float64Type, _, _>(list);
    let rows = field[0].len();
    let nested: Columns = vec![
        ("t_s".into(), Arc::new(Float64Array::from_iter((0..rows).map(|row| Some(row as f64 * 0.02))))),
        ("mag".into(), Arc::new(list)),
    ];
    let nested = parquet(&here.join("d.parquet"), &batch(nested));
    let message =
        ironout(["fit", text(&nested), "--json"]).error()["message"].as_str().expect("words").to_string();
    assert!(
        message.contains("not read: column mag: each cell is a list. Fix: write its numbers"),
        "{message}"
    );
    let words: Columns = named(["mx_ut", "my_ut", "mz_ut"]).into_iter().take(2).collect();
    let texts: ArrayRef = Arc::new(StringArray::from_iter_values((0..rows).map(|_| "x")));
    let texts = parquet(&here.join("e.parquet"), &batch([words, vec![("mz_ut".into(), texts)]].concat()));
    let error = ironout(["fit", text(&texts), "--json"]).error();
    assert_eq!(error["column"], "mz_ut", "{error}");
}

#[test]
fn a_damaged_file_is_an_error_and_never_a_panic() {
    let here = folder("columnar_damaged");
    let (_, columns) = simulated(&here);
    let table = batch(columns.into_iter().map(|(name, array)| (name, array.slice(0, 200))).collect());
    let files = [parquet(&here.join("a.parquet"), &table), arrow(&here.join("a.feather"), &table)];
    let mut seed = 1_u64;
    let mut random = |n: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % n
    };
    for file in files {
        let whole = std::fs::read(&file).expect("a file");
        let damaged = here.join("damaged");
        for case in 0..60 {
            let mut bytes = whole.clone();
            if case % 3 == 0 {
                bytes.truncate(8 + random(whole.len() - 8));
            } else {
                // The index at the end decides most; some of the content, too.
                for _ in 0..=random(4) {
                    let from = if case % 3 == 1 { whole.len().saturating_sub(1500) } else { 8 };
                    let at = from + random(whole.len() - from);
                    bytes[at] = random(256) as u8;
                }
            }
            std::fs::write(&damaged, &bytes).expect("a file");
            let run = ironout(["fit", text(&damaged)]);
            assert!(
                run.status <= 2 && !run.stderr.contains("panicked"),
                "case {case}: {} {}",
                run.status,
                run.stderr
            );
            // Lines break where the path lets them.
            let said = run.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(case % 3 != 0 || said.contains("is truncated or damaged"), "{said}");
        }
    }
}

#[test]
fn batch_writes_its_table_as_parquet() {
    let here = folder("columnar_batch");
    let (csv, columns) = simulated(&here);
    let logs = here.join("logs");
    std::fs::create_dir_all(&logs).expect("a folder");
    std::fs::rename(&csv, logs.join("a.csv")).expect("moved");
    parquet(&logs.join("b.parquet"), &batch(columns));
    std::fs::write(logs.join("c.csv"), "t_s,mx_ut\n0,1\n").expect("a file");
    let (lines, table) = (here.join("fleet.jsonl"), here.join("fleet.parquet"));
    for output in [&lines, &table] {
        assert_eq!(ironout(["batch", text(&logs), "-o", text(output)]).status, 0);
    }
    let file = File::open(&table).expect("a file");
    let mut reader =
        ParquetRecordBatchReaderBuilder::try_new(file).expect("Parquet").build().expect("a reader");
    let rows = reader.next().expect("rows").expect("rows");
    let rms = rows
        .column_by_name("rms_ut")
        .expect("a column")
        .as_any()
        .downcast_ref::<Float64Array>()
        .expect("numbers");
    let verdict = rows
        .column_by_name("verdict")
        .expect("a column")
        .as_any()
        .downcast_ref::<StringArray>()
        .expect("texts");
    let lines = std::fs::read_to_string(&lines).expect("lines");
    let objects: Vec<serde_json::Value> =
        lines.lines().map(|line| serde_json::from_str(line).expect("an object")).collect();
    assert_eq!((objects.len(), rows.num_rows()), (3, 3));
    for (row, object) in objects.iter().enumerate() {
        assert_eq!(object["verdict"], verdict.value(row));
        let number = rms.iter().nth(row).flatten();
        assert_eq!(object["rms_ut"].as_f64(), number);
        assert_eq!(number.is_none(), row == 2);
    }
    // The same log twice, in two formats.
    assert_eq!(objects[0]["offset_ut"], objects[1]["offset_ut"]);
}
