//! From a table and the decisions about it to a [`Log`].

use crate::failure::{Failure, Outcome};
use crate::input::columns::{Column, Role};
use crate::input::log::{Log, ReadOptions};
use crate::input::map::entry;
use crate::input::plan::Plan;
use crate::input::read_as::LeftOut;
use crate::input::store::Store;
use crate::input::text::choice::{Choice, Taken};
use crate::input::text::clock::DAY_S;
use crate::input::text::grid::Grid;
use crate::input::text::rest::rounded;
use crate::input::text::shared::share_out;
use crate::input::text::table::MONITOR;

/// Times later than this are dates: the log counts from its first row.
const DATE_S: f64 = 1e8;
/// Where counters of 32 bits begin again.
const WRAP: f64 = 4_294_967_296.0;
/// More rows than this share with a time before that of the row above: the log is of two recordings.
const MOST_BACKWARD: f64 = 0.02;

/// The log of the chosen columns and rows.
///
/// # Errors
/// No row with a whole magnetometer, or time that runs backward.
pub fn build(mut grid: Grid, choice: Choice, options: &ReadOptions) -> Outcome<Log> {
    let Choice { taken, mut rows, instance, pin_instance, program, added, reasons, not_read, set_aside: _ } =
        choice;
    let mut taken_out = Vec::new();
    let order = |taken: &Taken| (rank(Role::of(&taken.name).1), taken.column);
    let mut taken = taken;
    taken.sort_by_key(order);
    let strict: Vec<usize> = taken
        .iter()
        .filter(|t| matches!(Role::of(&t.name).1, Role::Time | Role::FieldUt(_) | Role::FieldCounts(_)))
        .map(|t| t.column)
        .collect();
    for columns in &added {
        take_out(&mut grid, &taken, *columns);
        let names =
            columns.map(|column| grid.columns.get(column).map(|c| c.header.as_str()).unwrap_or_default());
        taken_out.push(format!(
            "subtracted {} from the field (DIA, ODI and SCALE are not in this table, so ironout uses 1)",
            names.join(", ")
        ));
    }
    let before = rows.len();
    let mut first_line = None;
    rows.retain(|row| {
        let whole = strict.iter().all(|column| {
            grid.columns.get(*column).and_then(|c| c.values.get(*row)).is_some_and(|value| value.is_finite())
        });
        if !whole && first_line.is_none() {
            first_line = grid.lines.get(*row).copied();
        }
        whole
    });
    if rows.len() < before {
        let why = "no number in the column of time or of the magnetometer".to_string();
        grid.left_out.push(LeftOut { rows: before - rows.len(), first_line, why });
    }
    if rows.is_empty() {
        let failure = Failure::usage("no row has a number in every column of the magnetometer and of time");
        return Err(match grid.header_line.or(grid.lines.first().copied()) {
            Some(line) => failure.at_line(line),
            None => failure,
        });
    }
    let time = taken.iter().position(|t| Role::of(&t.name).1 == Role::Time);
    let times =
        time.and_then(|at| taken.get(at)).map(|time| forward(&mut grid, time, &mut rows, &mut taken_out));
    let (times, reasons, not_read) = match times {
        Some(Ok((times, shared))) => {
            (Some(times), reasons.into_iter().chain(shared).collect::<Vec<_>>(), not_read)
        }
        Some(Err(backward)) => (None, reasons, not_read.into_iter().chain([backward]).collect::<Vec<_>>()),
        None => (None, reasons, not_read),
    };
    // A time that is none is not read.
    let time = match (time, &times) {
        (Some(at), None) => {
            taken.remove(at);
            None
        }
        (time, _) => time,
    };
    let mut stores = Vec::with_capacity(taken.len());
    let mut columns = Vec::with_capacity(taken.len());
    for (at, entry) in taken.iter().enumerate() {
        let Some(source) = grid.columns.get(entry.column) else { continue };
        let (name, role, _) = Role::of(&entry.name);
        let is_time = Some(at) == time;
        let unit = entry.unit.clone().filter(|unit| !unit.is_own() && !is_time);
        let column = Column { name, role, unit };
        columns.push(column.clone());
        let mut store = Store::new(column, source.header.clone(), rows.len());
        store.values = match &times {
            Some(times) if is_time => times.clone(),
            _ => rows.iter().map(|row| source.values.get(*row).copied().unwrap_or(f64::NAN)).collect(),
        };
        store.empty = store.values.iter().filter(|value| value.is_nan()).count();
        stores.push(store);
    }
    let plain = ReadOptions { map: Vec::new(), ..options.clone() };
    let line = grid.header_line.or(grid.lines.first().copied()).unwrap_or(1);
    let rows_read = rows.len();
    let mut log = Plan::new(&columns, &plain, line)?.finish(stores, rows_read, &plain)?;
    // Time was made seconds before its rows were sorted out; it is said in the unit of the file.
    for (read, entry) in log.read_as.columns.iter_mut().zip(&taken) {
        read.unit = entry.unit.as_ref().map_or(String::new(), |unit| unit.name.to_string());
    }
    let mut format = std::mem::take(&mut grid.format);
    if let Some(program) = program {
        format = format!("{}, {format}", program.name());
    }
    if !grid.named {
        format.push_str(", no header");
    }
    log.read_as.format = format;
    log.read_as.taken_out.splice(0..0, taken_out);
    log.read_as.left_out.splice(0..0, std::mem::take(&mut grid.left_out));
    log.read_as.reasons = reasons;
    log.read_as.not_read = not_read;
    log.read_as.pins = pins(&grid, &taken);
    if let (Some(found), true) = (&instance, pin_instance) {
        log.read_as.pins.push(("--instance".into(), found.taken.to_string()));
    }
    if let (Some(_), Some(scale)) = (log.ut_per_count, options.ut_per_count) {
        let text = scale.map(|value| value.to_string()).join(",");
        log.read_as.pins.push(("--ut-per-count".into(), text));
    }
    log.read_as.instance = instance;
    Ok(log)
}

/// The log's order: time, magnetometer, accelerometer, gyroscope, heading, the rest as in the file.
fn rank(role: Role) -> (usize, usize) {
    match role {
        Role::Time => (0, 0),
        Role::FieldUt(axis) | Role::FieldCounts(axis) => (1, axis),
        Role::Accel(axis) => (2, axis),
        Role::Gyro(axis) => (3, axis),
        Role::Heading => (4, 0),
        Role::Covariate | Role::Unnamed => (5, 0),
    }
}

/// Subtracts what the autopilot had added, in the file's own unit.
fn take_out(grid: &mut Grid, taken: &[Taken], added: [usize; 3]) {
    for (axis, column) in added.into_iter().enumerate() {
        let field = taken
            .iter()
            .find(|t| matches!(Role::of(&t.name).1, Role::FieldUt(a) | Role::FieldCounts(a) if a == axis));
        let (Some(field), Some(offsets)) = (field, grid.columns.get(column).map(|c| c.values.clone())) else {
            continue;
        };
        if let Some(values) = grid.columns.get_mut(field.column) {
            values.values.iter_mut().zip(offsets).for_each(|(value, offset)| *value -= offset);
        }
    }
}

/// Time in seconds, and how rows share it out; or why it is not read. Running forward: midnights and overflowing counters undone, dates counted from the first row, rows that
/// run backward left out.
fn forward(
    grid: &mut Grid,
    time: &Taken,
    rows: &mut Vec<usize>,
    taken_out: &mut Vec<String>,
) -> Result<(Vec<f64>, Option<String>), String> {
    let Some(column) = grid.columns.get(time.column) else { return Ok((Vec::new(), None)) };
    let header = column.header.clone();
    let raw: Vec<f64> = rows.iter().filter_map(|row| column.values.get(*row)).copied().collect();
    let of_day = (header == MONITOR || time.unit.as_ref().is_some_and(|unit| unit.is_date))
        && raw.iter().all(|value| (0.0..=DAY_S).contains(value));
    let counter =
        time.unit.as_ref().is_some_and(|unit| !unit.is_date) && raw.iter().all(|v| v.fract() == 0.0);
    let (mut add, mut turns, mut last) = (0.0, 0, f64::NEG_INFINITY);
    let mut times = Vec::with_capacity(raw.len());
    for value in raw {
        let fell = last - value;
        if of_day && fell > DAY_S / 2.0 {
            (add, turns) = (add + DAY_S, turns + 1);
        } else if counter && fell > 0.9 * WRAP && last < WRAP {
            (add, turns) = (add + WRAP, turns + 1);
        }
        last = value;
        let value = value + add;
        times.push(time.unit.as_ref().map_or(value, |unit| unit.convert(value)));
    }
    if turns > 0 {
        let what = if of_day { "midnight" } else { "an overflow of its 32 bits" };
        taken_out.push(format!("{header} passes {what}, {turns} times"));
    }
    if let Some(first) = times.first().copied().filter(|first| *first > DATE_S) {
        times.iter_mut().for_each(|value| *value -= first);
        let date =
            jiff::Timestamp::from_second(first as i64).map_or(String::new(), |stamp| format!(" ({stamp})"));
        taken_out.push(format!("t_s counts from the first row, at {header} {first} s{date}"));
    }
    let mut kept = (Vec::with_capacity(times.len()), Vec::with_capacity(rows.len()));
    let (mut latest, mut backward, mut first_line) = (f64::NEG_INFINITY, 0_usize, None);
    for (value, row) in times.into_iter().zip(rows.iter()) {
        if value < latest {
            backward += 1;
            first_line = first_line.or(grid.lines.get(*row).copied());
            continue;
        }
        latest = value;
        kept.0.push(value);
        kept.1.push(*row);
    }
    if backward as f64 > MOST_BACKWARD * rows.len() as f64 {
        let first = first_line.map_or(String::new(), |line| format!(", first on line {line}"));
        return Err(format!(
            "{header} (it decreases in {backward} of {} rows{first}. ironout reads the log without time. To use it, sort \
             the log, or split it at the restart of the recorder)",
            rows.len()
        ));
    }
    if backward > 0 {
        grid.left_out.push(LeftOut {
            rows: backward,
            first_line,
            why: "time before that of the row above".into(),
        });
    }
    *rows = kept.1;
    let shared = share_out(&mut kept.0).map(|step_s| {
        format!(
            "{header} repeats one time for several rows. ironout spaces them evenly, {} s per row",
            rounded(step_s)
        )
    });
    Ok((kept.0, shared))
}

/// The options that read the same again.
fn pins(grid: &Grid, taken: &[Taken]) -> Vec<(String, String)> {
    let parts: Vec<String> = taken
        .iter()
        .filter_map(|taken| {
            let header = grid.columns.get(taken.column)?.header.as_str();
            // What keeps its name and has no unit is read so by itself.
            let plain = Role::of(&taken.name).1 == Role::Covariate && taken.unit.is_none();
            (!plain).then(|| entry(&taken.name, header, taken.unit.as_ref().map(|unit| unit.name.as_ref())))
        })
        .collect();
    vec![("--map".to_string(), parts.join(","))]
}
