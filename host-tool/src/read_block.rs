//! The *read as* block: what was decided while a log was read, and the options that pin it.

use crate::input::{Log, ReadAs, ReadColumn};
use crate::output::json_number;
use crate::shell::typed_option;
use serde_json::{Map, Value, json};

/// Columns shown, a vector counted once.
const SHOWN: usize = 24;
/// Lines of words are broken here.
const WIDTH: usize = 110;

/// The block for people; one line for the program's own CSV.
pub fn text(log: &Log) -> String {
    let read = &log.read_as;
    let mut out = format!("read as  {} ({}, {} rows)\n", read.format, log.path.display(), log.rows);
    if read.own_csv {
        let other: Vec<&ReadColumn> =
            read.columns.iter().filter(|column| column.name != column.source).collect();
        other.iter().for_each(|column| out.push_str(&format!("  {}\n", words(column))));
        return out;
    }
    let rows = vectors(&read.columns);
    rows.iter().take(SHOWN).for_each(|row| push(&mut out, "  ", row));
    if rows.len() > SHOWN {
        push(&mut out, "  ", &format!("… and {} more columns", rows.len() - SHOWN));
    }
    read.reasons.iter().for_each(|reason| push(&mut out, "  because: ", reason));
    read.taken_out.iter().for_each(|what| push(&mut out, "  adjusted: ", what));
    if let Some(instance) = &read.instance {
        let name = |number: &usize, what: &str| format!("{number} ({what})");
        let is = |there: &&(usize, String)| there.0 == instance.taken;
        let taken =
            instance.there.iter().find(is).map_or(instance.taken.to_string(), |(n, what)| name(n, what));
        let others: Vec<String> =
            instance.there.iter().filter(|there| !is(there)).map(|(n, what)| name(n, what)).collect();
        push(
            &mut out,
            "  instance: ",
            &format!("{taken}; there are also {}: --instance N", others.join(", ")),
        );
    }
    for entry in &read.left_out {
        let line = entry.first_line.map_or(String::new(), |line| format!(", first on line {line}"));
        push(
            &mut out,
            "  skipped: ",
            &format!(
                "{} {}{line}: {}",
                entry.rows,
                if entry.rows == 1 { "line" } else { "lines" },
                entry.why
            ),
        );
    }
    // What ends with options to paste stands by itself.
    let (long, short): (Vec<&String>, Vec<&String>) =
        read.not_read.iter().partition(|what| what.contains('\n'));
    if !short.is_empty() {
        let all: Vec<&str> = short.into_iter().map(String::as_str).collect();
        push(&mut out, "  not read: ", &all.join("; "));
    }
    long.into_iter().for_each(|what| push(&mut out, "  not read: ", what));
    // One line, however long: it is to be pasted.
    let pins = pins(read);
    if !pins.is_empty() {
        out.push_str(&format!("  read the same again with{pins}\n"));
    }
    out
}

/// The options that pin the reading, as a POSIX shell takes them, each after a blank.
pub fn pins(read: &ReadAs) -> String {
    read.pins.iter().map(|(option, value)| typed_option(option, value)).collect()
}

/// What a JSON answer says of its input, next to the answer itself: the program's version, the input, its notes, how it was read.
pub fn context(log: &Log) -> Map<String, Value> {
    let seconds = log.time_s.as_ref().and_then(|time| Some(time.last()? - time.first()?));
    let mut map = Map::new();
    map.insert("version".into(), env!("CARGO_PKG_VERSION").into());
    map.insert(
        "input".into(),
        json!({"path": log.path.display().to_string(), "rows": log.rows, "seconds": json_number(seconds)}),
    );
    map.insert("notes".into(), json!(log.notices));
    map.insert("read_as".into(), json(log));
    map
}

/// The same for `--json`, under `read_as`.
pub fn json(log: &Log) -> Value {
    let read = &log.read_as;
    json!({
        "frame": log.frame,
        "format": read.format,
        "columns": read.columns.iter().map(|c| json!({"name": c.name, "source": c.source, "unit": c.unit})).collect::<Vec<_>>(),
        "reasons": read.reasons,
        "taken_out": read.taken_out,
        "instance": read.instance.as_ref().map(|instance| json!({
            "taken": instance.taken,
            "there": instance.there.iter().map(|(n, what)| json!({"number": n, "what": what})).collect::<Vec<_>>(),
        })),
        "left_out": read.left_out.iter().map(|entry| json!({
            "rows": entry.rows, "first_line": entry.first_line, "why": entry.why,
        })).collect::<Vec<_>>(),
        "not_read": read.not_read,
        "pins": read.pins.iter().map(|(option, value)| json!([option, value])).collect::<Vec<_>>(),
    })
}

fn words(column: &ReadColumn) -> String {
    let unit = if column.unit.is_empty() { String::new() } else { format!(", in {}", column.unit) };
    format!("{} from {}{unit}", column.name, column.source)
}

/// One row a column, three axes of a sensor together.
fn vectors(columns: &[ReadColumn]) -> Vec<String> {
    let mut rows = Vec::new();
    let mut rest = columns;
    while let Some(first) = rest.first() {
        let axis = |column: &ReadColumn, letter: &str| column.name.get(1..2) == Some(letter);
        let sensor = ["m", "a", "g"].iter().any(|head| first.name.starts_with(head));
        match rest {
            [x, y, z, tail @ ..]
                if sensor && axis(x, "x") && axis(y, "y") && axis(z, "z") && x.unit == z.unit =>
            {
                rows.push(words(&ReadColumn {
                    name: format!("{}, {}, {}", x.name, y.name, z.name),
                    source: format!("{}, {}, {}", x.source, y.source, z.source),
                    unit: x.unit.clone(),
                }));
                rest = tail;
            }
            [one, tail @ ..] => {
                rows.push(words(one));
                rest = tail;
            }
            [] => {}
        }
    }
    rows
}

/// A labelled line, broken at blanks; lines that are broken already stay so.
fn push(out: &mut String, label: &str, text: &str) {
    let mut line = label.to_string();
    for (index, part) in text.split('\n').enumerate() {
        if index > 0 {
            out.push_str(line.trim_end());
            out.push('\n');
            // A line of its own is an option to paste: not broken.
            line = part.to_string();
            continue;
        }
        for word in part.split(' ') {
            if line.chars().count() + word.chars().count() > WIDTH && line.len() > label.len() {
                out.push_str(line.trim_end());
                out.push('\n');
                line = " ".repeat(label.chars().count().min(12));
            }
            line.push_str(word);
            line.push(' ');
        }
    }
    out.push_str(line.trim_end());
    out.push('\n');
}
