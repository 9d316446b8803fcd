//! Units of the columns of a log: how they are written, and the factor to the program's own.

use std::borrow::Cow;

/// What a unit is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Magnetic flux density; µT.
    Field,
    /// Time; s.
    Time,
    /// Specific force; m/s².
    Acceleration,
    /// Angular rate; rad/s.
    Rate,
    /// Temperature; °C.
    Temperature,
    /// Electric current; A.
    Current,
    /// Voltage; V.
    Voltage,
}

impl Quantity {
    /// The unit that the program works in, as it is said.
    pub fn own_unit(self) -> &'static str {
        match self {
            Quantity::Field => "uT",
            Quantity::Time => "s",
            Quantity::Acceleration => "m/s2",
            Quantity::Rate => "rad/s",
            Quantity::Temperature => "C",
            Quantity::Current => "A",
            Quantity::Voltage => "V",
        }
    }
}

/// A unit: `value · multiply / divide + add` is in the program's own.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// As it is said, and as `--map NAME=HEADER[UNIT]` takes it.
    pub name: Cow<'static, str>,
    /// What it is of; `None` for a bare number, which is a scale to the program's own unit.
    pub quantity: Option<Quantity>,
    /// Dates and times of day: cells are text, values are seconds already.
    pub is_date: bool,
    multiply: f64,
    divide: f64,
    add: f64,
}

impl Unit {
    /// A value in the program's own unit.
    pub fn convert(&self, value: f64) -> f64 {
        let scaled = value * self.multiply / self.divide;
        if self.add == 0.0 { scaled } else { scaled + self.add }
    }

    /// What a value is multiplied with on its way to the program's own unit.
    pub fn factor(&self) -> f64 {
        self.multiply / self.divide
    }

    /// Whether values stay as they are.
    pub fn is_own(&self) -> bool {
        self.multiply == 1.0 && self.divide == 1.0 && self.add == 0.0
    }

    /// The unit that the program works in.
    pub fn own(quantity: Quantity) -> Self {
        Unit::of(quantity.own_unit(), quantity).unwrap_or_else(|| Unit::scale(1.0))
    }

    /// A scale to the program's own unit.
    pub fn scale(factor: f64) -> Self {
        let name = Cow::Owned(format!("{factor}"));
        Unit { name, quantity: None, is_date: false, multiply: factor, divide: 1.0, add: 0.0 }
    }

    /// The unit of that quantity that is written so, in any of its spellings.
    pub fn of(text: &str, quantity: Quantity) -> Option<Self> {
        let plain = plain(text);
        let row = UNITS.iter().find(|row| row.1 == quantity && row.5.contains(&plain.as_str()))?;
        Some(from_row(row))
    }

    /// The unit that is written so, of whichever quantity; the first of the table where several are.
    pub fn any(text: &str) -> Option<Self> {
        let plain = plain(text);
        UNITS.iter().find(|row| row.5.contains(&plain.as_str())).map(from_row)
    }

    /// What stands in the brackets of `--map NAME=HEADER[…]`: a unit, a number, or both, as in `mG`, `0.1`, `1/8192 g`. A
    /// bare number is a scale to the program's own unit.
    pub fn stated(text: &str, quantity: Option<Quantity>) -> Option<Self> {
        let text = text.trim();
        let named = |text: &str| match quantity {
            Some(quantity) => Unit::of(text, quantity),
            None => Unit::any(text),
        };
        if let Some(unit) = named(text) {
            return Some(unit);
        }
        let end = text.find(|c: char| !(c.is_ascii_digit() || ".+-/eE".contains(c))).unwrap_or(text.len());
        // The last of the number may be the first of the unit: `1/16 rad/s` is split at the blank.
        let (number, rest) = text.split_at(end);
        let (over, under) = number.split_once('/').unwrap_or((number, "1"));
        let positive = |text: &str| text.parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
        let (over, under) = (positive(over)?, positive(under)?);
        let base = if rest.trim().is_empty() { Unit::scale(1.0) } else { named(rest)? };
        let (multiply, divide) = (base.multiply * over, base.divide * under);
        if base.is_date || base.add != 0.0 || !(multiply / divide).is_normal() {
            return None;
        }
        Some(Unit { name: Cow::Owned(text.to_string()), multiply, divide, ..base })
    }

    /// The units of a quantity, one spelling each.
    pub fn all(quantity: Quantity) -> impl Iterator<Item = Unit> {
        UNITS.iter().filter(move |row| row.1 == quantity && !row.0.starts_with("ISO")).map(from_row)
    }
}

type Row = (&'static str, Quantity, f64, f64, f64, &'static [&'static str]);

fn from_row(row: &Row) -> Unit {
    Unit {
        name: Cow::Borrowed(row.0),
        quantity: Some(row.1),
        is_date: row.0 == "ISO",
        multiply: row.2,
        divide: row.3,
        add: row.4,
    }
}

/// The spelling that the table knows: lower case, ASCII, no blanks.
fn plain(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for c in text.trim().chars() {
        match c {
            'µ' | 'μ' => plain.push('u'),
            '°' | 'º' => plain.push_str("deg"),
            '²' => plain.push('2'),
            '₂' | '^' | '*' | '·' | ' ' | '_' | '\u{a0}' => {}
            '⁻' | '−' => plain.push('-'),
            '¹' => plain.push('1'),
            _ => plain.extend(c.to_lowercase()),
        }
    }
    plain
}

/// Name, quantity, multiply, divide, add, spellings. Exact powers of ten divide, so that digits stay what they were.
/// The standard acceleration of gravity is that of CGPM 1901, 9.80665 m/s².
const UNITS: &[Row] = &[
    ("T", Quantity::Field, 1e6, 1.0, 0.0, &["t", "tesla"]),
    ("mT", Quantity::Field, 1e3, 1.0, 0.0, &["mt", "millitesla"]),
    ("uT", Quantity::Field, 1.0, 1.0, 0.0, &["ut", "utesla", "microtesla", "microteslas", "mutesla"]),
    ("nT", Quantity::Field, 1.0, 1e3, 0.0, &["nt", "nanotesla"]),
    ("G", Quantity::Field, 1e2, 1.0, 0.0, &["g", "ga", "gs", "gauss"]),
    ("mG", Quantity::Field, 1.0, 10.0, 0.0, &["mg", "mga", "mgs", "mgauss", "milligauss"]),
    ("s", Quantity::Time, 1.0, 1.0, 0.0, &["s", "sec", "secs", "second", "seconds", "sek", "sekunden"]),
    (
        "ms",
        Quantity::Time,
        1.0,
        1e3,
        0.0,
        &["ms", "msec", "msecs", "millisec", "millis", "millisecond", "milliseconds"],
    ),
    (
        "us",
        Quantity::Time,
        1.0,
        1e6,
        0.0,
        &["us", "usec", "usecs", "microsec", "micros", "microsecond", "microseconds"],
    ),
    (
        "ns",
        Quantity::Time,
        1.0,
        1e9,
        0.0,
        &["ns", "nsec", "nsecs", "nanosec", "nanosecs", "nanos", "nanosecond", "nanoseconds"],
    ),
    ("ISO", Quantity::Time, 1.0, 1.0, 0.0, &["iso", "iso8601"]),
    (
        "m/s2",
        Quantity::Acceleration,
        1.0,
        1.0,
        0.0,
        &["m/s2", "mps2", "m/s/s", "ms2", "ms-2", "m/sec2", "mss", "m.s-2"],
    ),
    ("g", Quantity::Acceleration, 9.80665, 1.0, 0.0, &["g", "gs", "gn", "gee", "g's"]),
    ("mg", Quantity::Acceleration, 9.80665, 1e3, 0.0, &["mg", "millig", "milli-g"]),
    (
        "rad/s",
        Quantity::Rate,
        1.0,
        1.0,
        0.0,
        &["rad/s", "radps", "rads", "rad", "rad/sec", "rads-1", "rad.s-1"],
    ),
    (
        "deg/s",
        Quantity::Rate,
        std::f64::consts::PI,
        180.0,
        0.0,
        &["deg/s", "degps", "dps", "degs", "deg", "deg/sec", "degrees/s", "degs-1", "degree/s"],
    ),
    ("mdeg/s", Quantity::Rate, std::f64::consts::PI, 180e3, 0.0, &["mdps", "mdeg/s"]),
    ("C", Quantity::Temperature, 1.0, 1.0, 0.0, &["c", "degc", "celsius", "degcelsius", "degreesc"]),
    ("K", Quantity::Temperature, 1.0, 1.0, -273.15, &["k", "kelvin", "degk"]),
    ("F", Quantity::Temperature, 5.0, 9.0, -160.0 / 9.0, &["f", "degf", "fahrenheit"]),
    ("A", Quantity::Current, 1.0, 1.0, 0.0, &["a", "amp", "amps", "ampere"]),
    ("mA", Quantity::Current, 1.0, 1e3, 0.0, &["ma", "milliamp", "milliampere"]),
    ("V", Quantity::Voltage, 1.0, 1.0, 0.0, &["v", "volt", "volts"]),
    ("mV", Quantity::Voltage, 1.0, 1e3, 0.0, &["mv", "millivolt"]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_and_factors() {
        for (text, quantity, value, expected) in [
            ("µT", Quantity::Field, 48.0, 48.0),
            ("μT", Quantity::Field, 48.0, 48.0),
            ("nT", Quantity::Field, 48_000.0, 48.0),
            ("G", Quantity::Field, 0.48, 48.0),
            ("mG", Quantity::Field, 480.0, 48.0),
            ("T", Quantity::Field, 48e-6, 48.0),
            ("ms", Quantity::Time, 20.0, 0.02),
            ("mg", Quantity::Acceleration, 1000.0, 9.80665),
            ("m/s²", Quantity::Acceleration, 9.81, 9.81),
            ("m/s^2", Quantity::Acceleration, 9.81, 9.81),
            ("°/s", Quantity::Rate, 180.0, std::f64::consts::PI),
            ("DPS", Quantity::Rate, 180.0, std::f64::consts::PI),
            ("K", Quantity::Temperature, 273.15, 0.0),
            ("°F", Quantity::Temperature, 212.0, 100.0),
            ("1/8192 g", Quantity::Acceleration, 8192.0, 9.80665),
            ("1/16 deg/s", Quantity::Rate, 16.0 * 180.0, std::f64::consts::PI),
            ("0.1", Quantity::Field, 480.0, 48.0),
            ("0.1uT", Quantity::Field, 480.0, 48.0),
        ] {
            let unit = Unit::stated(text, Some(quantity)).unwrap_or_else(|| panic!("{text}"));
            assert!((unit.convert(value) - expected).abs() < 1e-9, "{text}: {}", unit.convert(value));
        }
        for text in ["", "x", "-1", "0", "1/0", "nan", "inf", "1e400", "furlong", "2 K"] {
            assert_eq!(Unit::stated(text, Some(Quantity::Temperature)), None, "{text}");
        }
    }

    #[test]
    fn every_name_reads_back_as_itself() {
        for row in UNITS {
            let unit = Unit::of(row.0, row.1).unwrap_or_else(|| panic!("{}", row.0));
            assert_eq!((unit.name.as_ref(), unit.quantity), (row.0, Some(row.1)));
        }
    }
}
