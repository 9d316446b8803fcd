//! What the name of a column says about what stands behind it.

/// What a column measures, as its name says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// A temperature: the name ends in `_c`.
    Temperature,
    /// A current: the name ends in `_a`.
    Current,
    /// Anything else.
    Other,
}

impl ColumnKind {
    /// By the unit in the name.
    pub fn of(column: &str) -> Self {
        if column.ends_with("_c") {
            Self::Temperature
        } else if column.ends_with("_a") {
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
}
