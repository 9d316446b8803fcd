//! The host tool on logs: reading, and the whole diagnosis.

use crate::data::{log, write_long};
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use ironout_analysis::{Options, Table, diagnose};
use ironout_cli::input::{ReadOptions, read_stream};
use std::hint::black_box;

/// Rows of the log that is read over and over.
pub const ROWS: usize = 20_000;

/// The text of a log.
pub fn text() -> Vec<u8> {
    let mut text = Vec::new();
    write_long(ROWS, &mut text).expect("memory can be written");
    text
}

/// Reads it.
pub fn read(text: &[u8]) -> usize {
    read_stream(text, text.len() as u64, &ReadOptions::default()).expect("the log is good").rows
}

#[divan::bench(sample_count = 20)]
fn read_csv(bencher: Bencher) {
    let text = text();
    bencher
        .counter(ItemsCount::new(ROWS))
        .counter(BytesCount::of_slice(&text))
        .bench_local(|| read(black_box(&text)));
}

#[divan::bench(args = ["nothing", "offset:temp_c=3", "drift=3,eddy=3"], sample_count = 5)]
fn diagnose_80_s(bencher: Bencher, hidden: &str) {
    let log = log(if hidden == "nothing" { "" } else { hidden });
    let table = Table::from_columns(log.named()).expect("a simulated log has a magnetometer");
    let options = Options { search: true, ..Options::default() };
    bencher.bench_local(|| diagnose(black_box(&table), &options).expect("the log is good").verdict);
}
