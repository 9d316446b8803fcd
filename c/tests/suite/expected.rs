//! What `c/tests/bits.c` has to print, computed with the Rust library alone, none of it through the C interface.

use super::trace::{self, FIELD_UT, RATE_HZ, Row, UT_PER_COUNT};
use core::fmt::Write;
use ironout::calibration::Calibration;
use ironout::clock::Extended;
use ironout::extended::Live;
use ironout::fit::FitReport;
use ironout::heading::heading_deg;
use ironout::monitor::{Condition, Monitor};
use ironout::record::Record;
use ironout::sensor::Sample;
use ironout::session::{Session, SessionConfig, Status};

/// Samples between two lines of corrected values.
const STEP: usize = 97;

/// What the session of the C interface is made of.
pub fn config() -> SessionConfig {
    let scaled = SessionConfig::scaled(UT_PER_COUNT.map(f64::from), f64::from(RATE_HZ));
    SessionConfig { field_ut: Some(f64::from(FIELD_UT)), ..scaled }
}

/// A session that has taken so many rows.
pub fn session_of(rows: &[Row]) -> Session {
    let mut session = Session::new(config());
    session.start();
    let mut last_ms = None;
    for row in rows {
        // As the header says: four periods of 10 ms.
        if last_ms.replace(row.t_ms).is_some_and(|last_ms: u32| row.t_ms.wrapping_sub(last_ms) > 40) {
            session.interrupt();
        }
        let make = if row.out_of_range { Sample::out_of_range } else { Sample::valid };
        session.push(make(row.counts));
    }
    session
}

/// µT of a row, in single precision.
pub fn measured_ut(row: &Row) -> [f32; 3] {
    core::array::from_fn(|axis| f32::from(row.counts[axis]) * UT_PER_COUNT[axis])
}

fn bits(values: &[f32]) -> String {
    values.iter().map(|value| format!(" {:08x}", value.to_bits())).collect()
}

fn figures(out: &mut String, name: &str, status: &Status) {
    let single = |value: Option<f64>| value.map_or(f32::NAN, |value| value as f32);
    let figures = [single(status.rms_ut), single(status.noise_ut), single(status.predicted_error)];
    let (counts, coverage) = (status.counts, bits(&[status.coverage, status.gap_deg]));
    let ironout::session::Counts { n, skipped, saturated } = counts;
    writeln!(out, "{name} {n} {skipped} {saturated}{coverage}{}", bits(&figures)).expect("a string");
}

fn calibration(out: &mut String, name: &str, calibration: &Calibration<f32>) {
    let Calibration { offset_ut, matrix, field_ut } = calibration;
    let lines = [bits(offset_ut), bits(matrix.as_flattened()), bits(&[*field_ut])].concat();
    writeln!(out, "{name}{lines}").expect("a string");
}

/// The solution of the whole trace.
pub fn report() -> FitReport {
    let mut session = session_of(&trace::rows());
    session.stop().expect("it collects");
    session.solution().expect("the trace is good").clone()
}

/// The record of the trace with this sequence number.
pub fn record(sequence: u32) -> Record {
    Record { sequence, ..Record::of(&report()) }
}

/// Everything, line by line.
pub fn text() -> String {
    let (rows, mut out) = (trace::rows(), String::new());
    for part in [200, 900, 1600] {
        figures(&mut out, "status", &session_of(&rows[..part]).status());
    }
    let mut session = session_of(&rows);
    session.stop().expect("it collects");
    figures(&mut out, "stopped", &session.status());
    let single = report().calibration.cast::<f32>();
    calibration(&mut out, "accepted", &single);
    let record = record(3);
    let encoded = record.encode().expect("a record without effects fits");
    let hex: String = encoded.as_bytes().iter().map(|byte| format!("{byte:02x}")).collect();
    writeln!(out, "record {} {hex}", encoded.as_bytes().len()).expect("a string");
    let error = record.predicted_error.share().expect("it is known") * record.calibration.field_ut;
    let noise = [record.noise_ut as f32, record.rms_ut as f32, error as f32];
    calibration(&mut out, "decoded", &record.calibration.cast());
    writeln!(out, "decoded {}{}", record.samples, bits(&noise)).expect("a string");

    let report = report();
    let mut monitor = Monitor::new(single.field_ut, report.noise_ut as f32, report.predicted_error_ut as f32);
    let mut clock = Extended::new();
    let with_effects = trace::record_with_effects(record);
    let (on_own_clock, origin_s) = with_effects.extended().on_own_clock();
    let mut live = Live::new(&on_own_clock.cast::<f32>()).expect("it is regular");
    for (index, row) in rows.iter().enumerate() {
        let corrected = single.apply(measured_ut(row));
        monitor.push(clock.at(row.t_ms), corrected, Some(row.accel_mps2));
        if index % STEP != 0 {
            continue;
        }
        let heading = heading_deg(corrected.map(f64::from), row.accel_mps2.map(f64::from), 3.5);
        let heading = heading.map_or(String::from(" none"), |heading| bits(&[heading as f32]));
        let condition = match monitor.condition() {
            Condition::Good => 0,
            Condition::Disturbed => 1,
            Condition::Outdated => 2,
        };
        writeln!(out, "sample {index}{}{heading} {condition}", bits(&corrected)).expect("a string");
        live.set("temp_c", 5.0 + index as f32 * 0.02);
        live.advance(1000.0 + index as f64 * 0.1 - origin_s);
        let corrected = live.apply(measured_ut(row), None).expect("every column is known");
        write!(out, "live {index}{}", bits(&corrected)).expect("a string");
        for outside in live.outside() {
            write!(out, " {}", outside.column).expect("a string");
        }
        out.push('\n');
    }
    out
}
