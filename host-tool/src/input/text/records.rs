//! Lines that are not a table: labelled prints, JSON, MotionCal's lines, the streams of this project's boards.

use crate::input::names::meaning;
use crate::input::text::grid::{Grid, GridColumn};
use crate::input::text::labels::{self, Labelled};
use crate::input::text::prefix::Bare;
use crate::input::text::table::MONITOR;
use crate::input::unit::{Quantity, Unit};
use std::collections::HashMap;

/// This share of the labelled lines with the same labels makes each line a record of its own.
const ONE_KIND: f64 = 0.9;
/// Lines without a record.
const NO_RECORD: &str = "not a record (boot message, reply, comment)";

/// The streams that are told by the beginning of their lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// `Raw:` nine integers: accelerometer 1/8192 g, gyroscope 1/16 °/s, magnetometer 0.1 µT (MotionCal).
    Raw,
    /// `Uni:` nine numbers in m/s², rad/s and µT (Adafruit's sketches write it next to `Raw:`).
    Uni,
    /// `R,t_ms,x,y,z` in counts (this project's boards).
    Counts,
    /// `C,t_ms,x_ut,y_ut,z_ut,norm_ut,residual_ut`, corrected on the board.
    Corrected,
}

impl Stream {
    const ALL: [Stream; 4] = [Stream::Raw, Stream::Uni, Stream::Counts, Stream::Corrected];

    fn head(self) -> &'static str {
        match self {
            Stream::Raw => "Raw:",
            Stream::Uni => "Uni:",
            Stream::Counts => "R,",
            Stream::Corrected => "C,",
        }
    }

    fn format(self) -> &'static str {
        match self {
            Stream::Raw => "MotionCal lines (Raw:)",
            Stream::Uni => "MotionCal lines (Uni:, which has a finer resolution than Raw:)",
            Stream::Counts => "stream of an ironout board, counts (R,)",
            Stream::Corrected => "stream of an ironout board, corrected by the board's own calibration (C,)",
        }
    }

    /// Names and units of the values; an empty name is not read.
    fn columns(self) -> Vec<(&'static str, Option<(&'static str, Quantity)>)> {
        let nine = |accel, gyro, mag| {
            let unit = |unit: &'static str, quantity| Some((unit, quantity));
            ["ax", "ay", "az", "gx", "gy", "gz", "mx", "my", "mz"]
                .into_iter()
                .enumerate()
                .map(|(index, name)| match index / 3 {
                    0 => (name, unit(accel, Quantity::Acceleration)),
                    1 => (name, unit(gyro, Quantity::Rate)),
                    _ => (name, unit(mag, Quantity::Field)),
                })
                .collect()
        };
        let (ms, ut) = (Some(("ms", Quantity::Time)), Some(("uT", Quantity::Field)));
        match self {
            Stream::Raw => nine("1/8192 g", "1/16 deg/s", "0.1 uT"),
            Stream::Uni => nine("m/s2", "rad/s", "uT"),
            Stream::Counts => {
                vec![("t_ms", ms), ("mx_counts", None), ("my_counts", None), ("mz_counts", None)]
            }
            Stream::Corrected => {
                vec![("t_ms", ms), ("mx_ut", ut), ("my_ut", ut), ("mz_ut", ut), ("", None), ("", None)]
            }
        }
    }

    fn values(self, line: &str) -> Option<Vec<f64>> {
        let rest = line.trim().strip_prefix(self.head())?;
        // The board says so where it is tilted further than its calibration is for.
        let rest =
            if self == Stream::Corrected { rest.strip_suffix(",tilted").unwrap_or(rest) } else { rest };
        let parsed: Option<Vec<f64>> = rest
            .split(',')
            .map(|cell| cell.trim().parse::<f64>().ok().filter(|value| value.is_finite()))
            .collect();
        parsed.filter(|values| values.len() == self.columns().len())
    }
}

/// How many lines each stream has.
pub fn streams(lines: &[Bare<'_>]) -> Vec<(Stream, usize)> {
    Stream::ALL
        .into_iter()
        .map(|stream| (stream, lines.iter().filter(|line| stream.values(&line.text).is_some()).count()))
        .collect()
}

/// Reads the lines of one stream; the others are left out, each kind by its name.
pub fn read_stream(lines: &[Bare<'_>], stream: Stream) -> Grid {
    let columns = stream.columns();
    let mut grid = Grid { format: stream.format().to_string(), named: true, ..Grid::default() };
    grid.columns = columns
        .iter()
        .map(|(name, unit)| {
            let mut column = GridColumn::new(*name);
            column.unit = unit.and_then(|(text, quantity)| Unit::stated(text, Some(quantity)));
            column
        })
        .collect();
    let has_time = columns.iter().any(|(name, _)| *name == "t_ms");
    let mut monitor = GridColumn::new(MONITOR);
    for (index, line) in lines.iter().enumerate() {
        let number = index as u64 + 1;
        let text = line.text.trim();
        if text.is_empty() {
            continue;
        }
        let Some(values) = stream.values(text) else {
            let other =
                Stream::ALL.into_iter().find(|other| *other != stream && other.values(text).is_some());
            let why = match other {
                Some(other) => {
                    format!("lines of another stream ({})", other.head().trim_end_matches([',', ':']))
                }
                None if text.starts_with(stream.head()) => {
                    format!("a truncated {} line", stream.head())
                }
                None => "not sensor data (replies, messages)".to_string(),
            };
            grid.leave_out(&why, number);
            continue;
        };
        for (column, value) in grid.columns.iter_mut().zip(values) {
            column.push("", Some(value));
        }
        monitor.push("", line.time_s);
        grid.lines.push(number);
    }
    grid.columns.retain(|column| !column.header.is_empty());
    if !has_time {
        add_monitor(&mut grid, monitor);
    }
    grid
}

fn add_monitor(grid: &mut Grid, mut monitor: GridColumn) {
    monitor.unit = Unit::of("s", Quantity::Time);
    if !grid.lines.is_empty() && monitor.finite() * 2 > grid.rows() {
        grid.columns.push(monitor);
    }
}

/// Lines of labelled numbers, whether any, and how 1,5 is to be read.
pub struct Prints {
    lines: Vec<(usize, Vec<Labelled>)>,
    format: &'static str,
    /// The numbers in all of them.
    pub numbers: usize,
}

/// Finds labelled numbers in the lines.
pub fn prints(lines: &[Bare<'_>]) -> Prints {
    let scan = |decimal_comma: bool| -> Vec<(usize, Vec<Labelled>)> {
        let found =
            lines.iter().enumerate().map(|(index, line)| (index, labels::scan(&line.text, decimal_comma)));
        found.filter(|(_, pairs)| !pairs.is_empty()).collect()
    };
    let plain = scan(false);
    // A comma is a decimal one where every label then has one number, and no number has a point.
    let listed = |found: &[(usize, Vec<Labelled>)]| {
        found.iter().flat_map(|(_, pairs)| pairs).filter(|pair| pair.name.ends_with("[1]")).count()
    };
    let points =
        plain.iter().take(500).any(|(at, _)| lines.get(*at).is_some_and(|line| line.text.contains('.')));
    let is_json = lines.iter().filter(|line| line.text.starts_with('{')).count() * 2 > plain.len();
    let (found, format) = if is_json {
        (plain, "JSON lines")
    } else if listed(&plain) > 0 && !points {
        let commas = scan(true);
        if listed(&commas) == 0 {
            (commas, "labelled numbers, decimal comma")
        } else {
            (plain, "labelled numbers")
        }
    } else {
        (plain, "labelled numbers")
    };
    let numbers = found.iter().map(|(_, pairs)| pairs.len()).sum();
    Prints { lines: found, format, numbers }
}

/// One JSON array of objects, as some telephones export.
pub fn json_array(text: &str) -> Option<Prints> {
    if !text.trim_start().starts_with('[') {
        return None;
    }
    let value: serde_json::Value = serde_json::from_str(text).ok()?;
    let found: Vec<(usize, Vec<Labelled>)> = value
        .as_array()?
        .iter()
        .map(labels::object)
        .enumerate()
        .filter(|(_, pairs)| !pairs.is_empty())
        .collect();
    let numbers = found.iter().map(|(_, pairs)| pairs.len()).sum();
    (numbers > 0).then_some(Prints { lines: found, format: "JSON array", numbers })
}

/// Puts labelled numbers together to rows: each line is one where they have the same labels; else a row begins
/// with the label that the first of them has.
pub fn read_prints(lines: &[Bare<'_>], prints: &Prints) -> Grid {
    let mut grid = Grid { format: prints.format.to_string(), named: true, ..Grid::default() };
    let mut kinds: HashMap<Vec<&str>, usize> = HashMap::new();
    for (_, pairs) in &prints.lines {
        *kinds.entry(pairs.iter().map(|pair| pair.name.as_str()).collect()).or_default() += 1;
    }
    // The same count twice must not depend on the map's order.
    let usual = kinds.iter().max_by(|a, b| (a.1, a.0.len(), b.0).cmp(&(b.1, b.0.len(), a.0)));
    let Some((labels, count)) = usual else { return grid };
    let fields = labels.iter().filter(|label| meaning(label).axis.is_some()).count();
    let one_kind = *count as f64 >= ONE_KIND * prints.lines.len() as f64 && (fields >= 3 || labels.len() > 3);
    let is_json = prints.format.starts_with("JSON");
    let mut rows: Vec<(usize, Vec<&Labelled>)> = Vec::new();
    let mut broken: Vec<usize> = Vec::new();
    if one_kind || is_json {
        for (at, pairs) in &prints.lines {
            let same = is_json || pairs.iter().map(|pair| pair.name.as_str()).eq(labels.iter().copied());
            if same { rows.push((*at, pairs.iter().collect())) } else { broken.push(*at) }
        }
    } else {
        joined(prints, &mut rows, &mut broken);
    }
    let mut index: HashMap<&str, usize> = HashMap::new();
    let mut monitor = GridColumn::new(MONITOR);
    let mut used = vec![false; lines.len()];
    for (row, (at, pairs)) in rows.iter().enumerate() {
        for pair in pairs {
            let column = *index.entry(pair.name.as_str()).or_insert_with(|| {
                grid.columns
                    .push(GridColumn { values: vec![f64::NAN; row], ..GridColumn::new(pair.name.clone()) });
                grid.columns.len() - 1
            });
            if let Some(column) = grid.columns.get_mut(column).filter(|column| column.values.len() == row) {
                match &pair.text {
                    Some(text) => column.push(text, Some(pair.value).filter(|value| value.is_finite())),
                    None => column.push("", Some(pair.value)),
                }
            }
        }
        for column in &mut grid.columns {
            if column.values.len() == row {
                column.push("", None);
            }
        }
        monitor.push("", lines.get(*at).and_then(|line| line.time_s));
        grid.lines.push(*at as u64 + 1);
    }
    prints.lines.iter().for_each(|(at, _)| {
        if let Some(slot) = used.get_mut(*at) {
            *slot = true;
        }
    });
    for at in broken {
        grid.leave_out("a truncated record", at as u64 + 1);
    }
    if prints.format != "JSON array" {
        for (at, line) in lines.iter().enumerate() {
            if !used.get(at).copied().unwrap_or(true) && !line.text.trim().is_empty() {
                grid.leave_out(NO_RECORD, at as u64 + 1);
            }
        }
    }
    grid.left_out.sort_by_key(|entry| entry.first_line);
    spread_units(&mut grid);
    add_monitor(&mut grid, monitor);
    grid
}

/// Rows from several lines each: one begins with the label that is there most often, and is whole where it has all that
/// are there about as often.
fn joined<'a>(prints: &'a Prints, rows: &mut Vec<(usize, Vec<&'a Labelled>)>, broken: &mut Vec<usize>) {
    let mut order: Vec<&str> = Vec::new();
    let mut counts: HashMap<&str, usize> = HashMap::new();
    for pair in prints.lines.iter().flat_map(|(_, pairs)| pairs) {
        let count = counts.entry(&pair.name).or_insert(0);
        if *count == 0 {
            order.push(&pair.name);
        }
        *count += 1;
    }
    let count = |name: &str| counts.get(name).copied().unwrap_or(0);
    let most = order.iter().map(|name| count(name)).max().unwrap_or(0);
    let needed: Vec<&str> = order.into_iter().filter(|name| count(name) * 2 > most).collect();
    let Some(anchor) = needed.first().copied() else { return };
    let mut row: Vec<&Labelled> = Vec::new();
    let mut begun: Option<usize> = None;
    let mut whole = true;
    let mut close = |row: &mut Vec<&'a Labelled>, begun: Option<usize>, whole: bool| {
        let Some(at) = begun else { return };
        let row = std::mem::take(row);
        let all = needed.iter().all(|name| row.iter().any(|pair| pair.name == *name));
        if all && whole { rows.push((at, row)) } else { broken.push(at) }
    };
    for (at, pairs) in &prints.lines {
        for pair in pairs {
            if pair.name == anchor {
                close(&mut row, begun, whole);
                (begun, whole) = (Some(*at), true);
            } else if row.iter().any(|known| known.name == pair.name) {
                whole = false;
            }
            row.push(pair);
        }
    }
    close(&mut row, begun, whole);
}

/// `X: 1 Y: 2 Z: 3 uT`: a unit that stands once behind a vector is that of all three.
fn spread_units(grid: &mut Grid) {
    let meanings: Vec<_> = grid.columns.iter().map(|column| meaning(&column.header)).collect();
    for (at, own) in meanings.iter().enumerate() {
        if own.unit.is_some() || own.axis.is_none() {
            continue;
        }
        let near = meanings.iter().enumerate().skip(at.saturating_sub(2)).take(5);
        let mut same =
            near.filter(|(_, other)| other.stem == own.stem && other.axis.is_some() && other.unit.is_some());
        if let (Some((_, other)), Some(column)) = (same.next(), grid.columns.get_mut(at)) {
            column.unit = other.unit.clone();
        }
    }
}
