//! Lines of cells: which mark separates them, where the names stand, which lines are rows.

use crate::input::names::{Kind, meaning, speaks_of_field};
use crate::input::text::grid::{Grid, GridColumn, number_of, unique};
use crate::input::text::prefix::Bare;
use crate::input::unit::{Quantity, Unit};
use std::collections::HashMap;

/// Lines that are looked at to find the layout.
const LOOK: usize = 4000;
/// Fewer numbers make no row.
pub const LEAST_NUMBERS: usize = 3;
/// A longer text is not a sensor's name.
const LONGEST_NAME: usize = 24;
/// What a monitor's time is called as a column.
pub const MONITOR: &str = "monitor";

/// What stands between cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Separator {
    /// One mark.
    Mark(char),
    /// Any run of blanks and tabs.
    Blanks,
}

impl Separator {
    const ALL: [Separator; 6] = [
        Separator::Mark(';'),
        Separator::Mark('\t'),
        Separator::Mark(','),
        Separator::Mark('|'),
        Separator::Blanks,
        Separator::Mark('/'),
    ];

    fn name(self) -> &'static str {
        match self {
            Separator::Mark(';') => "semicolons",
            Separator::Mark('\t') => "tabs",
            Separator::Mark('|') => "bars",
            Separator::Mark('/') => "slashes",
            Separator::Mark(_) => "commas",
            Separator::Blanks => "blanks",
        }
    }

    /// Cells of a line; marks in quotes separate nothing.
    fn cut<'a>(self, line: &'a str, cells: &mut Vec<&'a str>) {
        cells.clear();
        match self {
            Separator::Blanks => cells.extend(line.split_whitespace()),
            Separator::Mark(mark) if !line.contains('"') => cells.extend(line.split(mark).map(str::trim)),
            Separator::Mark(mark) => {
                let (mut start, mut inside) = (0, false);
                for (at, c) in line.char_indices() {
                    if c == '"' {
                        inside = !inside;
                    } else if c == mark && !inside {
                        cells.push(line.get(start..at).unwrap_or_default().trim());
                        start = at + c.len_utf8();
                    }
                }
                cells.push(line.get(start..).unwrap_or_default().trim());
            }
        }
    }
}

/// How the rows of a table are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// Between cells.
    pub separator: Separator,
    /// Whether 1,5 is one and a half.
    pub decimal_comma: bool,
    /// Cells of a row.
    pub cells: usize,
    /// Rows among the lines that were looked at.
    pub rows: usize,
    /// Numbers in those.
    pub numbers: usize,
    /// Whether the rows name the magnetometer as their sensor.
    pub of_field: bool,
}

/// The layout that most lines have, if any has three numbers.
pub fn layout(lines: &[Bare<'_>]) -> Option<Layout> {
    let step = (lines.len() / LOOK).max(1);
    // The beginning whole, for short logs; the rest by samples, for one with a long boot.
    let looked = || {
        lines.iter().take(LOOK).chain(lines.iter().skip(LOOK).step_by(step)).map(|line| line.text.as_ref())
    };
    let mut best: Option<Layout> = None;
    let mut cells = Vec::new();
    for separator in Separator::ALL {
        for decimal_comma in [false, true] {
            if decimal_comma
                && separator == Separator::Mark(',')
                && !looked().take(200).any(|line| line.contains('"'))
            {
                continue;
            }
            let mut counts: HashMap<usize, Width> = HashMap::new();
            for line in looked() {
                separator.cut(line, &mut cells);
                let numbers = numbers(&cells, decimal_comma);
                if numbers >= LEAST_NUMBERS {
                    let entry = counts.entry(cells.len()).or_default();
                    entry.rows += 1;
                    entry.numbers += numbers;
                    entry.of_field +=
                        usize::from(numbers < cells.len() && cells.iter().any(|cell| names_field(cell)));
                }
            }
            // Rows that name their sensor may have another width each: the magnetometer's are wanted.
            let most = counts.into_iter().max_by_key(|(cells, width)| {
                (width.of_field * 2 > width.rows && width.rows > 1, width.rows, *cells)
            });
            let Some((cells, Width { rows, numbers, of_field })) = most else { continue };
            let of_field = of_field * 2 > rows;
            // More rows; or as many, and more numbers in them (a comma that was taken for a text).
            let better =
                |best: &Layout| (rows, numbers / rows.max(1)) > (best.rows, best.numbers / best.rows.max(1));
            if best.as_ref().is_none_or(better) {
                best = Some(Layout { separator, decimal_comma, cells, rows, numbers, of_field });
            }
        }
    }
    best
}

/// Lines of one number of cells.
#[derive(Default)]
struct Width {
    rows: usize,
    numbers: usize,
    /// Rows with a word that names a magnetometer.
    of_field: usize,
}

fn is_word(cell: &str) -> bool {
    !cell.is_empty()
        && cell.chars().all(|c| c.is_alphanumeric() || c == '_')
        && cell.starts_with(|c: char| c.is_alphabetic())
}

/// Whether a cell is the name of a magnetometer (`mag`, `MAG1`).
fn names_field(cell: &str) -> bool {
    let cell = cell.trim_matches('"');
    cell.len() <= LONGEST_NAME && cell.starts_with(|c: char| c.is_alphabetic()) && speaks_of_field(cell)
}

fn numbers(cells: &[&str], decimal_comma: bool) -> usize {
    cells.iter().filter(|cell| number_of(cell, decimal_comma).is_some()).count()
}

/// Reads the table in that layout.
pub fn read(lines: &[Bare<'_>], layout: Layout) -> Grid {
    let mut grid = Grid { format: words(layout), ..Grid::default() };
    let mut cells = Vec::new();
    let first = lines.iter().position(|line| {
        layout.separator.cut(line.text.as_ref(), &mut cells);
        cells.len() == layout.cells && numbers(&cells, layout.decimal_comma) >= LEAST_NUMBERS
    });
    let Some(first) = first else { return grid };
    let header = header(lines, first, layout);
    grid.header_line = header.as_ref().map(|header| header.line as u64 + 1);
    grid.named = header.is_some();
    let (header_at, above, mut names) = match header {
        Some(header) => (Some(header.line), header.above, header.names),
        None => (None, None, Vec::new()),
    };
    // A mark at the end of every row makes a last cell that nothing is ever in.
    let mut width = if grid.named { names.len().max(1) } else { layout.cells };
    let named = names.len();
    // Cells behind the last name have none; where nothing is ever in them, they are none.
    let is_filled = |line: &Bare<'_>| {
        let mut cells = Vec::new();
        layout.separator.cut(line.text.as_ref(), &mut cells);
        cells.len() == layout.cells && cells.iter().skip(named).any(|cell| !cell.is_empty())
    };
    if named + 1 < layout.cells && lines.iter().skip(first).take(LOOK).any(is_filled) {
        width = layout.cells;
    }
    names.extend((names.len()..width).map(|column| format!("column {}", column + 1)));
    grid.columns = unique(names).into_iter().map(GridColumn::new).collect();
    let stamped =
        lines.iter().skip(first).filter(|line| line.time_s.is_some()).count() * 2 > lines.len() - first;
    let mut monitor = GridColumn::new(MONITOR);
    for (index, line) in lines.iter().enumerate() {
        let text = line.text.as_ref();
        let is_header = header_at == Some(index) || above == Some(index);
        if is_header || text.trim().is_empty() || (text.starts_with('#') && index < first) {
            continue;
        }
        layout.separator.cut(text, &mut cells);
        if cells.len() > width && cells.iter().skip(width).all(|cell| cell.is_empty()) {
            cells.truncate(width);
        }
        let number = index as u64 + 1;
        if numbers(&cells, layout.decimal_comma) < LEAST_NUMBERS.min(width) {
            grid.leave_out("not a row of the table (boot message, reply, comment)", number);
            continue;
        }
        if cells.len() != width {
            let cut_off = if index + 1 == lines.len() { ": the recording was interrupted here" } else { "" };
            let of_sensor = cells.iter().find(|cell| cell.len() <= LONGEST_NAME && is_word(cell));
            match of_sensor.filter(|_| layout.of_field) {
                Some(sensor) => grid.leave_out(&format!("rows of another sensor ({sensor})"), number),
                None => grid.leave_out(&format!("not {width} cells as in the table{cut_off}"), number),
            }
            continue;
        }
        for (column, cell) in grid.columns.iter_mut().zip(&cells) {
            column.push(cell.trim_matches('"'), number_of(cell, layout.decimal_comma));
        }
        monitor.push("", line.time_s);
        grid.lines.push(number);
    }
    if stamped {
        monitor.unit = Unit::of("s", Quantity::Time);
        grid.columns.push(monitor);
    }
    // The empty cell behind the last mark of every row.
    let mut at = 0;
    grid.columns.retain(|column| {
        at += 1;
        at <= named || column.finite() + column.texts + column.not_finite + column.dates > 0
    });
    grid
}

/// Where the header of a table of commas has half as many names as the rows have cells: numbers with decimal commas between
/// commas. Gives the header's line.
pub fn doubled(lines: &[Bare<'_>], layout: Layout) -> Option<u64> {
    let mut cells = Vec::new();
    let found = lines.iter().take(LOOK).position(|line| {
        layout.separator.cut(&line.text, &mut cells);
        let names = cells.len() >= LEAST_NUMBERS && numbers(&cells, false) == 0;
        // One whole number among them has no comma.
        names && (layout.cells == 2 * cells.len() || layout.cells + 1 == 2 * cells.len())
    });
    found
        .filter(|_| layout.separator == Separator::Mark(',') && !layout.decimal_comma)
        .map(|at| at as u64 + 1)
}

/// The line above the first row that names as many columns as rows have cells, or the first of them; with the line above it, where
/// that names groups of columns, or where it holds the units.
fn header(lines: &[Bare<'_>], first: usize, layout: Layout) -> Option<Header> {
    let mut cells = Vec::new();
    layout.separator.cut(lines.get(first)?.text.as_ref(), &mut cells);
    let filled = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
    for at in (0..first).rev() {
        let Some(mut names) = names_in(lines.get(at)?.text.as_ref(), layout, filled, &mut cells) else {
            continue;
        };
        let mut above = at.checked_sub(1);
        while above.is_some_and(|line| lines.get(line).is_some_and(|line| line.text.trim().is_empty())) {
            above = above.and_then(|line| line.checked_sub(1));
        }
        let with_above = above.and_then(|line| lines.get(line)).and_then(|line| {
            layout.separator.cut(without_mark(line.text.as_ref()), &mut cells);
            joined(&cells, &names)
        });
        let above = above.filter(|_| with_above.is_some());
        names = with_above.unwrap_or(names);
        while names.last().is_some_and(String::is_empty) {
            names.pop();
        }
        return Some(Header { line: at, above, names });
    }
    None
}

/// The names of the columns, and where they stand.
struct Header {
    line: usize,
    /// The line above that names groups, or to which this one gives the units.
    above: Option<usize>,
    names: Vec<String>,
}

fn without_mark(text: &str) -> &str {
    text.trim_start_matches(['#', '/']).trim_start_matches(' ')
}

/// The names in a line, where it can be the header of rows whose first has this many cells with something in them.
fn names_in<'a>(
    text: &'a str,
    layout: Layout,
    filled: usize,
    cells: &mut Vec<&'a str>,
) -> Option<Vec<String>> {
    let text = without_mark(text);
    if text.trim().is_empty() {
        return None;
    }
    layout.separator.cut(text, cells);
    let named = cells.iter().filter(|cell| !cell.is_empty()).count();
    let fits = cells.len() == layout.cells
        || named == layout.cells
        || (cells.len() + 1 == layout.cells && named == cells.len())
        || (layout.separator == Separator::Blanks && fewer_blanks(text, layout.cells));
    // Any three words stand above a table of blanks: there they must speak of something.
    let speaks = |cell: &&str| {
        let meaning = meaning(cell);
        meaning.axis.is_some() || meaning.kind != Kind::Other
    };
    // Fewer names than cells are those of the first cells, but not half as many: then commas stand in the numbers, too.
    let half = cells.len() * 2;
    let is_half = (half == layout.cells || half == layout.cells + 1) && filled == layout.cells;
    let of_the_first =
        cells.len() < layout.cells && named == cells.len() && !is_half && cells.iter().any(speaks);
    let fits = (fits && (layout.separator != Separator::Blanks || cells.iter().any(speaks)))
        || (of_the_first && layout.separator != Separator::Blanks);
    if !fits || named < LEAST_NUMBERS || numbers(cells, layout.decimal_comma) * 2 >= named {
        return None;
    }
    if layout.separator == Separator::Blanks && cells.len() != layout.cells {
        return Some(split_wide(text));
    }
    Some(cells.iter().map(|cell| unquoted(cell)).collect())
}

fn unquoted(cell: &str) -> String {
    cell.trim_matches('"').replace("\"\"", "\"").trim().to_string()
}

/// Names of two lines in one: units that stand below names, or names that stand below those of their groups.
fn joined(above: &[&str], names: &[String]) -> Option<Vec<String>> {
    let above: Vec<String> = above.iter().map(|cell| unquoted(cell)).collect();
    let filled = |cells: &[String]| cells.iter().filter(|cell| !cell.is_empty()).count();
    let is_text = |cell: &String| !cell.is_empty() && number_of(cell, false).is_none();
    let unit_of = |cell: &str| {
        let bare = cell.trim_matches(|c: char| "()[]".contains(c)).trim().to_string();
        Unit::any(&bare).map(|_| bare)
    };
    if filled(&above) < 2
        || above.len() + 1 < names.len()
        || !above.iter().filter(|cell| !cell.is_empty()).all(is_text)
    {
        return None;
    }
    let units = names.iter().filter(|cell| unit_of(cell).is_some()).count();
    if units >= LEAST_NUMBERS && units * 2 > filled(names) && filled(&above) >= filled(names) {
        let with_unit = |(at, name): (usize, &String)| match names.get(at).and_then(|unit| unit_of(unit)) {
            Some(unit) => format!("{name} ({unit})"),
            None => name.clone(),
        };
        return Some(above.iter().enumerate().map(with_unit).collect());
    }
    // Names that repeat need their group; those that do not are whole.
    let repeats = (0..names.len()).any(|at| {
        names
            .get(at)
            .is_some_and(|name| !name.is_empty() && names.iter().skip(at + 1).any(|other| other == name))
    });
    if !repeats || filled(&above) >= filled(names) {
        return None;
    }
    let mut group = String::new();
    let mut all = Vec::with_capacity(names.len());
    for (at, name) in names.iter().enumerate() {
        if let Some(next) = above.get(at).filter(|next| !next.is_empty()) {
            group.clone_from(next);
        }
        all.push(match (group.is_empty(), name.is_empty()) {
            (true, _) => name.clone(),
            (false, true) => above.get(at).cloned().unwrap_or_default(),
            (false, false) => format!("{group} {name}"),
        });
    }
    Some(all)
}

/// Names with a blank in them (`mag x (uT)`), separated by two blanks or a tab.
fn split_wide(text: &str) -> Vec<String> {
    text.replace('\t', "  ")
        .split("  ")
        .map(str::trim)
        .filter(|name| !name.is_empty())
        .map(String::from)
        .collect()
}

fn fewer_blanks(text: &str, cells: usize) -> bool {
    split_wide(text).len() == cells
}

fn words(layout: Layout) -> String {
    let comma = if layout.decimal_comma { ", decimal comma" } else { "" };
    format!("table separated by {}{comma}", layout.separator.name())
}
