//! The table that every layout of text becomes: named columns of numbers, and the lines they stood on.

use crate::input::number;
use crate::input::read_as::LeftOut;
use crate::input::text::clock;
use crate::input::unit::Unit;
use std::collections::HashMap;

/// More texts than this in one column are not names of sensors.
const MOST_TEXTS: usize = 64;

/// One column.
#[derive(Debug, Clone, Default)]
pub struct GridColumn {
    /// As it is called in the file, unique.
    pub header: String,
    /// What its numbers are where the layout itself says so.
    pub unit: Option<Unit>,
    /// One value a row; NaN where there is none. Dates and times of day are seconds.
    pub values: Vec<f64>,
    /// Cells that are dates or times of day.
    pub dates: usize,
    /// Cells that are text.
    pub texts: usize,
    /// NaN and infinities written out.
    pub not_finite: usize,
    /// The texts that occur, up to a number.
    pub words: Vec<String>,
    /// For a column with texts: 1 + the index into `words` of each row, 0 for none.
    pub codes: Vec<u8>,
}

impl GridColumn {
    /// An empty column of that name.
    pub fn new(header: impl Into<String>) -> Self {
        GridColumn { header: header.into(), ..GridColumn::default() }
    }

    /// Cells that are numbers.
    pub fn finite(&self) -> usize {
        self.values.iter().filter(|value| value.is_finite()).count()
    }

    /// Takes the next row's cell; `value` is what [`number_of`] made of it.
    pub fn push(&mut self, cell: &str, value: Option<f64>) {
        let cell = cell.trim();
        let value = match value {
            Some(value) if value.is_finite() => value,
            Some(_) => {
                self.not_finite += 1;
                f64::NAN
            }
            None if cell.is_empty() => f64::NAN,
            None => match clock::seconds(cell.as_bytes()) {
                Some(seconds) => {
                    self.dates += 1;
                    seconds
                }
                None => {
                    self.text(cell);
                    f64::NAN
                }
            },
        };
        self.values.push(value);
        if !self.codes.is_empty() {
            self.codes.resize(self.values.len(), 0);
        }
    }

    fn text(&mut self, cell: &str) {
        self.texts += 1;
        if self.words.len() > MOST_TEXTS {
            return;
        }
        let at = self.words.iter().position(|word| word == cell).unwrap_or_else(|| {
            self.words.push(cell.chars().take(80).collect());
            self.words.len() - 1
        });
        self.codes.resize(self.values.len() + 1, 0);
        if let (Some(code), Ok(number)) = (self.codes.last_mut(), u8::try_from(at + 1)) {
            *code = number;
        }
    }
}

/// A table, and how it was found.
#[derive(Debug, Clone, Default)]
pub struct Grid {
    /// The layout, in words.
    pub format: String,
    /// Columns, each as long as `lines`.
    pub columns: Vec<GridColumn>,
    /// The line of each row, from 1.
    pub lines: Vec<u64>,
    /// The line of the header, where there is one.
    pub header_line: Option<u64>,
    /// Whether columns have names of their own.
    pub named: bool,
    /// A time in two columns that were joined: the column of seconds, that of their parts, and the unit of the parts.
    pub joined_time: Option<(String, String, &'static str)>,
    /// What was left out so far.
    pub left_out: Vec<LeftOut>,
}

impl Grid {
    /// Rows.
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// The index of the column of that name.
    pub fn find(&self, header: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.header == header)
    }

    /// All names.
    pub fn headers(&self) -> Vec<String> {
        self.columns.iter().map(|column| column.header.clone()).collect()
    }

    /// Notes lines that are not rows.
    pub fn leave_out(&mut self, why: &str, line: u64) {
        match self.left_out.iter_mut().find(|entry| entry.why == why) {
            Some(entry) => entry.rows += 1,
            None => self.left_out.push(LeftOut { rows: 1, first_line: Some(line), why: why.to_string() }),
        }
    }
}

/// A cell as a number: quotes and blanks removed, a comma for the point where the table has it so.
pub fn number_of(cell: &str, decimal_comma: bool) -> Option<f64> {
    let cell = cell.trim().trim_matches('"').trim();
    if cell.is_empty() {
        return None;
    }
    if let Some(value) = number::parse(cell.as_bytes()) {
        // `inf`, `infinity` and `nan` are numbers to the parser, and `Infinity` is no name of a sensor.
        return Some(value);
    }
    if decimal_comma && cell.contains(',') && !cell.contains('.') && !cell.ends_with(',') {
        return number::parse(cell.replacen(',', ".", 1).as_bytes());
    }
    // A minus sign as typographers write it.
    cell.strip_prefix('−').and_then(|rest| number_of(rest, decimal_comma)).map(|value| -value)
}

/// Names made unique: the second `MagX` is `MagX#2`.
pub fn unique(names: Vec<String>) -> Vec<String> {
    let mut seen: HashMap<String, usize> = HashMap::new();
    names
        .into_iter()
        .enumerate()
        .map(|(index, name)| {
            let name = if name.is_empty() { format!("column {}", index + 1) } else { name };
            let count = seen.entry(name.clone()).or_insert(0);
            *count += 1;
            if *count == 1 { name } else { format!("{name}#{count}") }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells() {
        for (cell, comma, value) in [
            (" 1.5 ", false, Some(1.5)),
            ("\"1.5\"", false, Some(1.5)),
            ("1,5", true, Some(1.5)),
            ("-1,5E-3", true, Some(-1.5e-3)),
            ("+2", false, Some(2.0)),
            ("−2", false, Some(-2.0)),
            ("1,5", false, None),
            ("1.234,5", true, None),
            ("", true, None),
            ("x", true, None),
        ] {
            assert_eq!(number_of(cell, comma), value, "{cell}");
        }
    }

    #[test]
    fn a_column_of_texts_keeps_which_row_had_which() {
        let mut column = GridColumn::new("sensor");
        for cell in ["", "MAG", "ACC", "MAG", "12:00:00", "1"] {
            column.push(cell, number_of(cell, false));
        }
        assert_eq!((column.texts, column.dates, column.values.len()), (3, 1, 6));
        assert_eq!(column.words, ["MAG", "ACC"]);
        assert_eq!(column.codes, [0, 1, 2, 1, 0, 0]);
        assert_eq!(unique(vec!["a".into(), "a".into(), String::new()]), ["a", "a#2", "column 3"]);
    }
}
