//! What the name of a column says about what stands behind it.

/// What a column measures, as its name says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// A temperature: the name ends in `_c`, case aside.
    Temperature,
    /// A current: the name ends in `_a`, case aside.
    Current,
    /// Anything else.
    Other,
}

impl ColumnKind {
    /// By the unit in the name.
    pub fn of(column: &str) -> Self {
        if Usual::TEMPERATURE.is_of(column) {
            Self::Temperature
        } else if Usual::CURRENT.is_of(column) {
            Self::Current
        } else {
            Self::Other
        }
    }

    /// By what stands behind the column: what a motor is told is followed by its current.
    pub fn behind(column: &str) -> Self {
        match Self::of(column) {
            Self::Other if holds(column, "throttle") || holds(column, "motor") => Self::Current,
            kind => kind,
        }
    }
}

/// `text.contains(word)`, without the searcher of core, which is three kilobytes on a board.
fn holds(text: &str, word: &str) -> bool {
    text.as_bytes().windows(word.len()).any(|part| part == word.as_bytes())
}

/// A column that a log should have for the sake of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Usual {
    /// Its name.
    pub column: &'static str,
    /// What such names end in.
    pub suffix: &'static str,
    /// What it is, in words.
    pub what: &'static str,
}

impl Usual {
    /// The sensor's temperature.
    pub const TEMPERATURE: Self = Usual { column: "temp_c", suffix: "_c", what: "temperature" };
    /// A current near the sensor.
    pub const CURRENT: Self = Usual { column: "current_a", suffix: "_a", what: "current" };

    /// Whether a column is such a one by its name, case aside.
    pub fn is_of(&self, column: &str) -> bool {
        let (name, end) = (column.as_bytes(), self.suffix.as_bytes());
        name.len()
            .checked_sub(end.len())
            .and_then(|at| name.get(at..))
            .is_some_and(|own| own.eq_ignore_ascii_case(end))
    }
}
