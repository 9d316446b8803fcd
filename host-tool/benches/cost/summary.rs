//! The last lines: side by side with `magcal`, and the long log.

use crate::{child, data, files, flight};
use ironout::fit::Method;
use ironout_analysis::{Options, Table, diagnose};
use std::fmt::Write as _;
use std::hint::black_box;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;
use std::time::Instant;

/// Rows of the long log.
const LONG: usize = 1_000_000;
/// Bytes of the long flight.
const FLIGHT: usize = 100_000_000;
/// Runs on it; the fastest counts, for the sake of machines that have other work.
const RUNS: usize = 3;

fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Median times of two works run in turn, so that whatever else runs slows both.
fn in_turn(ours: impl FnMut(), theirs: impl FnMut()) -> [f64; 2] {
    turns(101, ours, theirs)
}

/// The same for works that take long.
fn in_turn_few(ours: impl FnMut(), theirs: impl FnMut()) -> [f64; 2] {
    turns(5, ours, theirs)
}

fn turns(count: usize, mut ours: impl FnMut(), mut theirs: impl FnMut()) -> [f64; 2] {
    let both: Vec<[f64; 2]> = (0..count).map(|_| [seconds(&mut ours), seconds(&mut theirs)]).collect();
    [0, 1].map(|i| median(both.iter().map(|times| times[i]).collect()))
}

/// How many programs want a processor besides this one, where Linux says: times on a busy machine are not its best.
fn load() -> Option<String> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    let mean: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(format!("{:.0}", (mean - 1.0).max(0.0)))
}

/// Measures, and says it in words.
///
/// # Errors
/// The long log cannot be written, or the program does not run.
pub fn measure() -> io::Result<String> {
    let mut text = format!(
        "{} processor, {} cores{}; medians\n\n{:<44} ironout   magcal   ratio\n",
        std::env::consts::ARCH,
        std::thread::available_parallelism().map_or(0, usize::from),
        load().map_or_else(String::new, |load| format!(", {load} other programs at work")),
        "the same 10 000 counts in the same run"
    );
    beside_magcal(&mut text);
    text.push('\n');
    logs(&mut text);
    long(&mut text)?;
    Ok(text)
}

fn beside_magcal(text: &mut String) {
    let counts = data::counts();
    let sums = data::moments(&counts);
    let mut solver = data::magcal_solver(&counts);
    let found = solver.solve_ellipsoid().expect("the samples are good");
    let calibration = data::calibration();
    let a_sample = 1e9 / data::SAMPLES as f64;
    let push = in_turn(
        || _ = black_box(data::moments(black_box(&counts))),
        || {
            _ = black_box(data::magcal_solver(black_box(&counts)));
        },
    );
    let mut solved = |method| {
        in_turn(
            || _ = black_box(data::solve(black_box(&sums), method)),
            || {
                _ = black_box(solver.solve_ellipsoid());
            },
        )
    };
    let (trace, adjusted) = (solved(Method::Trace), solved(Method::Adjusted));
    let apply = in_turn(|| data::apply(&calibration, &counts), || data::apply_magcal(&found, &counts));
    for (what, [ours, theirs], unit) in [
        ("push (exact; magcal in f32), ns a sample", push, a_sample),
        ("solve, trace, with standard errors, µs", trace, 1e6),
        ("solve, adjusted, with errors and noise, µs", adjusted, 1e6),
        ("apply, ns a sample", apply, a_sample),
    ] {
        let _ =
            writeln!(text, "  {what:<42} {:7.2}  {:7.2}  {:6.2}", ours * unit, theirs * unit, ours / theirs);
    }
    let (mut live, slots) = data::live();
    let alone = |work: &mut dyn FnMut()| median((0..31).map(|_| seconds(&mut *work)).collect()) * a_sample;
    let effects = alone(&mut || data::apply_effects(&mut live, slots, &counts));
    let study = alone(&mut || _ = black_box(data::study(&calibration, &counts)));
    let _ = writeln!(text, "  {:<42} {effects:7.2}        –       –", "apply with two effects, ns a sample");
    let _ = writeln!(text, "  {:<42} {study:7.2}        –       –", "study push, 22 columns, ns a sample");
}

fn logs(text: &mut String) {
    let csv = files::text();
    let read = median((0..15).map(|_| seconds(|| _ = black_box(files::read(&csv)))).collect());
    let _ = writeln!(
        text,
        "reading a log of 21 columns: {:.2} million rows a second, {:.0} MB/s",
        files::ROWS as f64 / read / 1e6,
        csv.len() as f64 / read / 1e6
    );
    let ulog = flight::ulog(FLIGHT);
    let rows = flight::read(&ulog).rows;
    let [read, passed] = in_turn_few(
        || _ = black_box(flight::read(black_box(&ulog))),
        || _ = black_box(black_box(&ulog).iter().fold(0_u64, |sum, byte| sum + u64::from(*byte))),
    );
    let _ = writeln!(
        text,
        "a ULog of {} MB, {rows} rows of the magnetometer: {read:.2} s, {:.0} MB/s (adding its bytes up: {passed:.2} s)",
        ulog.len() / 1_000_000,
        ulog.len() as f64 / read / 1e6
    );
    drop(ulog);
    let log = data::log("offset:temp_c=3");
    let table = Table::from_columns(log.named()).expect("a simulated log has a magnetometer");
    let options = Options { search: true, ..Options::default() };
    let study = median((0..5).map(|_| seconds(|| _ = black_box(diagnose(&table, &options)))).collect());
    let _ = writeln!(text, "diagnose, 80 s at 50 Hz, a temperature offset hidden: {study:.2} s");
}

fn long(text: &mut String) -> io::Result<()> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bench-long.csv");
    eprintln!("writing a log of a million rows …");
    let mut out = BufWriter::new(std::fs::File::create(&path)?);
    data::write_long(LONG, &mut out)?;
    out.flush()?;
    let bytes = std::fs::metadata(&path)?.len();
    let log = path.to_str().ok_or_else(|| io::Error::other("the path of the log is no text"))?;
    for command in ["fit", "diagnose"] {
        let program = Path::new(env!("CARGO_BIN_EXE_ironout"));
        let mut ran = child::run(program, &[command, log, "--json"])?;
        for _ in 1..RUNS {
            let again = child::run(program, &[command, log, "--json"])?;
            ran = if again.wall < ran.wall { again } else { ran };
        }
        let answer: serde_json::Value = serde_json::from_str(&ran.answer)?;
        // Fast and wrong would be no answer.
        if command == "diagnose" && answer["steps"][1]["added"] != "offset:current_a" {
            return Err(io::Error::other("the hidden current was not found in the long log"));
        }
        let unknown = || "unknown on this system".to_string();
        let _ = writeln!(
            text,
            "{command}, a million rows, 10 covariates, {} MB: {:.1} s (processor time {}), peak memory {}",
            bytes / 1_000_000,
            ran.wall.as_secs_f64(),
            ran.cpu.map_or_else(unknown, |cpu| format!("{:.1} s", cpu.as_secs_f64())),
            ran.peak.map_or_else(unknown, |peak| format!("{} MB", peak / 1_000_000)),
        );
    }
    std::fs::remove_file(&path)
}
