//! A log in few bytes, to be read again in a page: columns of decimal numbers as whole numbers and their differences.

use crate::failure::{Failure, Outcome};
use crate::input::{Covariate, Log, ReadAs};
use crate::page::asked::ReadAsked;
use ironout_analysis::frame::Frame;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

const MAGIC: &[u8; 8] = b"ironlog1";
/// The most decimals that are tried.
const MOST_DECIMALS: u32 = 9;
/// Whole numbers up to here are exact in a double.
const EXACT: f64 = 9_007_199_254_740_992.0;
/// Longer logs keep columns that are not decimal numbers in single precision.
const LONG: usize = 20_000;

/// How the values of a column stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    /// Whole numbers over this power of ten, as differences; 0 stands for a missing one.
    Decimal(u32),
    /// Eight bytes each, the first of all, then the second of all, …
    Double,
    /// Four bytes each, likewise.
    Single,
}

#[derive(Debug, Serialize, Deserialize)]
struct Column {
    name: String,
    kind: Kind,
    bytes: usize,
}

#[derive(Debug, Serialize, Deserialize)]
struct Head {
    asked: ReadAsked,
    read_as: ReadAs,
    notices: Vec<String>,
    rows: usize,
    #[serde(default)]
    frame: Frame,
    ut_per_count: Option<[f64; 3]>,
    counts: bool,
    not_finite: Vec<usize>,
    columns: Vec<Column>,
}

const FIELD: [&str; 3] = ["x", "y", "z"];

/// Whether a column is of whole numbers over a power of ten, and which.
fn decimals(values: &[f64]) -> Option<u32> {
    (0..=MOST_DECIMALS).find(|decimals| {
        let power = 10_f64.powi(*decimals as i32);
        values.iter().all(|value| {
            let whole = (value * power).round();
            value.is_nan() || (whole.abs() < EXACT && whole / power == *value)
        })
    })
}

fn packed(name: String, values: &[f64], out: &mut Vec<u8>, rounded: &mut Vec<String>) -> Column {
    let from = out.len();
    let kind = match decimals(values) {
        Some(decimals) => {
            let power = 10_f64.powi(decimals as i32);
            let mut last = 0_i64;
            for value in values {
                if value.is_nan() {
                    out.push(0);
                    continue;
                }
                let whole = (value * power).round() as i64;
                let step = whole - last;
                last = whole;
                // Small steps of either sign are small numbers, and none of them is the sign of a missing value.
                let mut rest = (u128::from(((step << 1) ^ (step >> 63)).cast_unsigned())) + 1;
                while rest >= 0x80 {
                    out.push((rest & 0x7f) as u8 | 0x80);
                    rest >>= 7;
                }
                out.push(rest as u8);
            }
            Kind::Decimal(decimals)
        }
        None if values.len() > LONG => {
            rounded.push(name.clone());
            by_place(values.iter().map(|value| (*value as f32).to_le_bytes()), out);
            Kind::Single
        }
        None => {
            by_place(values.iter().map(|value| value.to_le_bytes()), out);
            Kind::Double
        }
    };
    Column { name, kind, bytes: out.len() - from }
}

/// First bytes together, then second ones: they are alike.
fn by_place<const N: usize>(values: impl Iterator<Item = [u8; N]> + Clone, out: &mut Vec<u8>) {
    for place in 0..N {
        out.extend(values.clone().filter_map(|bytes| bytes.get(place).copied()));
    }
}

/// The bytes of a log, and the columns that were rounded to single precision.
pub fn pack(log: &Log, asked: &ReadAsked) -> (Vec<u8>, Vec<String>) {
    let (mut body, mut rounded) = (Vec::new(), Vec::new());
    let mut columns = Vec::new();
    let mut add = |name: String, values: Cow<[f64]>| {
        columns.push(packed(name, &values, &mut body, &mut rounded));
    };
    for (axis, name) in FIELD.iter().enumerate() {
        match &log.counts {
            Some(counts) => {
                add(format!("m{name}"), counts.iter().map(|count| f64::from(count[axis])).collect());
            }
            None => add(format!("m{name}"), Cow::Borrowed(&log.field_ut[axis])),
        }
    }
    if let Some(time) = &log.time_s {
        add("t".into(), Cow::Borrowed(time));
    }
    for (letter, sensor) in [("a", &log.accel_mps2), ("g", &log.gyro_radps)] {
        for (axis, name) in sensor.iter().flatten().zip(FIELD) {
            add(format!("{letter}{name}"), Cow::Borrowed(axis));
        }
    }
    if let Some(heading) = &log.heading_deg {
        add("heading".into(), Cow::Borrowed(heading));
    }
    for column in &log.covariates {
        add(format!("={}", column.name), Cow::Borrowed(&column.values));
    }
    let head = Head {
        asked: asked.clone(),
        read_as: log.read_as.clone(),
        notices: log.notices.clone(),
        rows: log.rows,
        frame: log.frame.clone(),
        ut_per_count: log.ut_per_count,
        counts: log.counts.is_some(),
        not_finite: log.covariates.iter().map(|column| column.not_finite).collect(),
        columns,
    };
    let head = serde_json::to_vec(&head).unwrap_or_default();
    let mut out = MAGIC.to_vec();
    out.extend((head.len() as u32).to_le_bytes());
    out.extend(head);
    out.extend(body);
    (out, rounded)
}

fn unpacked(kind: Kind, rows: usize, bytes: &[u8]) -> Option<Vec<f64>> {
    let mut values = Vec::with_capacity(rows.min(bytes.len()));
    match kind {
        Kind::Decimal(decimals) if decimals <= MOST_DECIMALS => {
            let power = 10_f64.powi(decimals as i32);
            let mut rest = bytes.iter();
            let mut last = 0_i64;
            for _ in 0..rows {
                let (mut number, mut shift) = (0_u128, 0);
                loop {
                    let byte = *rest.next()?;
                    number |= u128::from(byte & 0x7f) << shift;
                    if byte < 0x80 {
                        break;
                    }
                    shift += 7;
                    if shift > 70 {
                        return None;
                    }
                }
                let Some(step) = number.checked_sub(1) else {
                    values.push(f64::NAN);
                    continue;
                };
                let step = step as u64;
                last = last.wrapping_add((step >> 1).cast_signed() ^ -((step & 1).cast_signed()));
                values.push(last as f64 / power);
            }
        }
        Kind::Decimal(_) => return None,
        Kind::Double => {
            for row in 0..rows {
                let each: Option<Vec<u8>> = (0..8).map(|i| bytes.get(i * rows + row).copied()).collect();
                values.push(f64::from_le_bytes(each?.try_into().ok()?));
            }
        }
        Kind::Single => {
            for row in 0..rows {
                let each: Option<Vec<u8>> = (0..4).map(|i| bytes.get(i * rows + row).copied()).collect();
                values.push(f64::from(f32::from_le_bytes(each?.try_into().ok()?)));
            }
        }
    }
    Some(values)
}

/// The log of such bytes.
///
/// # Errors
/// They are not what [`pack`] gives.
pub fn unpack(bytes: &[u8]) -> Outcome<(Log, ReadAsked)> {
    parse(bytes).ok_or_else(|| Failure::usage("the log in this page is damaged. Create the page again"))
}

fn parse(bytes: &[u8]) -> Option<(Log, ReadAsked)> {
    let rest = bytes.strip_prefix(MAGIC)?;
    let (length, rest) = rest.split_first_chunk::<4>()?;
    let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
    let head: Head = serde_json::from_slice(rest.get(..length)?).ok()?;
    let mut body = rest.get(length..)?;
    if head.rows > body.len() {
        return None;
    }
    let mut log = Log {
        path: head.asked.name.clone().into(),
        rows: head.rows,
        frame: head.frame,
        ut_per_count: head.ut_per_count,
        read_as: head.read_as,
        notices: head.notices,
        ..Log::default()
    };
    let mut own: Vec<(String, Vec<f64>)> = Vec::new();
    for column in &head.columns {
        let (mine, others) = body.split_at_checked(column.bytes)?;
        body = others;
        own.push((column.name.clone(), unpacked(column.kind, head.rows, mine)?));
    }
    let mut take = |name: &str| -> Option<Vec<f64>> {
        let at = own.iter().position(|(own, _)| own == name)?;
        Some(own.remove(at).1)
    };
    log.time_s = take("t");
    log.heading_deg = take("heading");
    let mut triple = |letter: &str| -> Option<[Vec<f64>; 3]> {
        let [x, y, z] = FIELD.map(|axis| take(&format!("{letter}{axis}")));
        Some([x?, y?, z?])
    };
    log.accel_mps2 = triple("a");
    log.gyro_radps = triple("g");
    let field = triple("m")?;
    log.field_ut = match (head.counts, head.ut_per_count) {
        (true, Some(scale)) => {
            let [x, y, z] = &field;
            let counts = x.iter().zip(y).zip(z).map(|((x, y), z)| [*x as i16, *y as i16, *z as i16]);
            log.counts = Some(counts.collect());
            let mut axes = field.into_iter().zip(scale);
            let mut next = || axes.next().map(|(axis, scale)| axis.into_iter().map(|v| v * scale).collect());
            [next()?, next()?, next()?]
        }
        _ => field,
    };
    for (index, (name, values)) in own.into_iter().enumerate() {
        let empty = values.iter().filter(|value| value.is_nan()).count();
        let not_finite = head.not_finite.get(index).copied().unwrap_or(0);
        let name = name.strip_prefix('=')?.to_string();
        log.covariates.push(Covariate { name, values, empty, not_finite });
    }
    Some((log, head.asked))
}
