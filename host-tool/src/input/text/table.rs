//! Lines of cells: which mark separates them, where the names stand, which lines are rows.

use crate::input::names::{Kind, meaning};
use crate::input::text::grid::{Grid, GridColumn, number_of, unique};
use crate::input::text::prefix::Bare;
use std::collections::HashMap;

/// Lines that are looked at to find the layout.
const LOOK: usize = 4000;
/// Fewer numbers make no row.
pub const LEAST_NUMBERS: usize = 3;
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
    const ALL: [Separator; 5] = [
        Separator::Mark(';'),
        Separator::Mark('\t'),
        Separator::Mark(','),
        Separator::Mark('|'),
        Separator::Blanks,
    ];

    fn name(self) -> &'static str {
        match self {
            Separator::Mark(';') => "semicolons",
            Separator::Mark('\t') => "tabs",
            Separator::Mark('|') => "bars",
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
            let mut counts: HashMap<usize, (usize, usize)> = HashMap::new();
            for line in looked() {
                separator.cut(line, &mut cells);
                let numbers = numbers(&cells, decimal_comma);
                if numbers >= LEAST_NUMBERS {
                    let entry = counts.entry(cells.len()).or_default();
                    *entry = (entry.0 + 1, entry.1 + numbers);
                }
            }
            let most = counts.into_iter().max_by_key(|(cells, (rows, _))| (*rows, *cells));
            let Some((cells, (rows, numbers))) = most else { continue };
            // More rows; or as many, and more numbers in them (a comma that was taken for a text).
            let better =
                |best: &Layout| (rows, numbers / rows.max(1)) > (best.rows, best.numbers / best.rows.max(1));
            if best.as_ref().is_none_or(better) {
                best = Some(Layout { separator, decimal_comma, cells, rows, numbers });
            }
        }
    }
    best
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
    grid.header_line = header.as_ref().map(|(line, _)| *line as u64 + 1);
    grid.named = header.is_some();
    let (header_at, names) = match header {
        Some((at, names)) => (Some(at), names),
        None => (None, Vec::new()),
    };
    // A mark at the end of every row makes a last cell that nothing is ever in.
    let width = if grid.named { names.len().max(1) } else { layout.cells };
    let names =
        if grid.named { names } else { (1..=width).map(|number| format!("column {number}")).collect() };
    grid.columns = unique(names).into_iter().map(GridColumn::new).collect();
    let stamped =
        lines.iter().skip(first).filter(|line| line.time_s.is_some()).count() * 2 > lines.len() - first;
    let mut monitor = GridColumn::new(MONITOR);
    for (index, line) in lines.iter().enumerate() {
        let text = line.text.as_ref();
        if Some(index) == header_at || text.trim().is_empty() || (text.starts_with('#') && index < first) {
            continue;
        }
        layout.separator.cut(text, &mut cells);
        if cells.len() > width && cells.iter().skip(width).all(|cell| cell.is_empty()) {
            cells.truncate(width);
        }
        let number = index as u64 + 1;
        if numbers(&cells, layout.decimal_comma) < LEAST_NUMBERS.min(width) {
            grid.leave_out("no row of the table (a boot message, a reply, a comment)", number);
            continue;
        }
        if cells.len() != width {
            let cut_off = if index + 1 == lines.len() { ": the recording was cut off here" } else { "" };
            grid.leave_out(&format!("not the table's {width} cells{cut_off}"), number);
            continue;
        }
        for (column, cell) in grid.columns.iter_mut().zip(&cells) {
            column.push(cell.trim_matches('"'), number_of(cell, layout.decimal_comma));
        }
        monitor.push("", line.time_s);
        grid.lines.push(number);
    }
    if stamped {
        grid.columns.push(monitor);
    }
    // The empty cell behind the last mark of every row.
    if !grid.named {
        grid.columns.retain(|column| column.finite() + column.texts + column.not_finite > 0);
    }
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

/// The line above the first row that names as many columns as rows have cells.
fn header(lines: &[Bare<'_>], first: usize, layout: Layout) -> Option<(usize, Vec<String>)> {
    let mut cells = Vec::new();
    for at in (0..first).rev() {
        let text = lines.get(at)?.text.as_ref();
        let text = text.trim_start_matches(['#', '/']).trim_start_matches(' ');
        if text.trim().is_empty() {
            continue;
        }
        layout.separator.cut(text, &mut cells);
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
        let fits = fits && (layout.separator != Separator::Blanks || cells.iter().any(speaks));
        if fits && named >= LEAST_NUMBERS && numbers(&cells, layout.decimal_comma) * 2 < named {
            let mut names: Vec<String> =
                if layout.separator == Separator::Blanks && cells.len() != layout.cells {
                    split_wide(text)
                } else {
                    cells
                        .iter()
                        .map(|cell| cell.trim_matches('"').replace("\"\"", "\"").trim().to_string())
                        .collect()
                };
            while names.last().is_some_and(String::is_empty) {
                names.pop();
            }
            return Some((at, names));
        }
    }
    None
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
