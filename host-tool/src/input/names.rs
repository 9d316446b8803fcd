//! What people call the columns of their logs.

use crate::input::unit::{Quantity, Unit};
use crate::input::vocabulary::{
    ACCEL, ASIDE, ATTITUDE, COUNTER, FIELD, GYRO, INSTANCE, MAGNITUDE, TEMPERATURE, TIME,
};

/// What a name speaks of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A magnetic field.
    Field,
    /// Specific force.
    Accel,
    /// Angular rate.
    Gyro,
    /// Time.
    Time,
    /// A temperature.
    Temperature,
    /// An electric current or a voltage.
    Electric,
    /// The magnitude of a field, or what another program made of one: it holds what is to be found.
    Derived,
    /// Attitude: computed from the field that is to be calibrated.
    Attitude,
    /// Numbers of rows.
    Counter,
    /// Which sensor a row is of.
    Instance,
    /// Anything else.
    Other,
}

/// A name, understood.
#[derive(Debug, Clone, PartialEq)]
pub struct Meaning {
    /// What it speaks of.
    pub kind: Kind,
    /// 0, 1, 2 for x, y, z; indices as they stand, which may count from 1.
    pub axis: Option<usize>,
    /// The unit in the name.
    pub unit: Option<Unit>,
    /// Whether the name says that values are counts of the sensor.
    pub counts: bool,
    /// What is left without axis and unit: columns of one vector have the same.
    pub stem: String,
    /// Among vectors of a kind: uncalibrated before calibrated.
    pub rank: i8,
}

const AXES: [char; 3] = ['x', 'y', 'z'];

/// Understands a header.
pub fn meaning(header: &str) -> Meaning {
    let lower = header.trim().trim_start_matches(['%', '#', '/']).trim();
    let (base, index) = index_off(lower);
    let (base, bracket) = bracket_off(base);
    // `Mag (uT)[0]` as well as `Mag[0] (uT)`.
    let (base, index) = if index.is_some() { (base, index) } else { index_off(base) };
    let (words, suffix) = words_and_suffix(base, bracket.is_some());
    let mut words: Vec<String> = words;
    let axis = axis_of(&mut words, index);
    let kind = kind_of(&words, axis, base);
    let counts = words.iter().any(|w| matches!(w.as_str(), "counts" | "adc" | "lsb" | "magadc" | "digit"))
        || bracket
            .is_some_and(|text| matches!(text.to_lowercase().as_str(), "counts" | "lsb" | "raw" | "adc"));
    let quantity = quantity(kind);
    let stated = bracket.or(suffix.as_deref());
    let mut unit = match (quantity, stated) {
        (Some(quantity), Some(text)) => Unit::of(text, quantity),
        _ => None,
    };
    let mut kind = kind;
    if unit.is_none()
        && let (Kind::Other, Some(text)) = (kind, bracket)
        && let Some(any) = Unit::any(text)
    {
        // The unit tells what a name in any language is: `Magnetfeld x (µT)`, `X (µT)`. A G by itself is not a gauss.
        kind = match any.quantity {
            // (G) behind an acceleration is not a gauss.
            Some(Quantity::Field)
                if !matches!(text.trim(), "g" | "mg" | "t")
                    && !words
                        .iter()
                        .any(|word| [ACCEL, GYRO].iter().any(|names| names.contains(&word.as_str())))
                    && !is_motion(&words) =>
            {
                if axis.is_some() {
                    Kind::Field
                } else {
                    Kind::Derived
                }
            }
            Some(Quantity::Time) => Kind::Time,
            Some(Quantity::Acceleration) if axis.is_some() && !is_motion(&words) => Kind::Accel,
            Some(Quantity::Rate) if axis.is_some() && text.contains('/') => Kind::Gyro,
            Some(Quantity::Temperature) => Kind::Temperature,
            Some(Quantity::Current | Quantity::Voltage) => Kind::Electric,
            _ => kind,
        };
        if kind != Kind::Other {
            unit = Some(any);
        }
    }
    if let (Kind::Other, Some(text)) = (kind, suffix.as_deref())
        && let Some(any) = Unit::any(text)
        && matches!(any.quantity, Some(Quantity::Current | Quantity::Voltage | Quantity::Temperature))
        && base.contains(['_', ' '])
    {
        (kind, unit) = match any.quantity {
            Some(Quantity::Temperature) => (Kind::Temperature, Some(any)),
            _ => (Kind::Electric, Some(any)),
        };
    }
    if kind == Kind::Field && axis.is_none() {
        kind = Kind::Derived;
    }
    if unit.is_none()
        && let Some(quantity) = quantity
    {
        // A unit between the words: `mag_uT_x`. One letter is not a unit there.
        if let Some(at) = words.iter().position(|word| word.len() > 1 && Unit::of(word, quantity).is_some()) {
            unit = words.get(at).and_then(|word| Unit::of(word, quantity));
            if kind != Kind::Time {
                words.remove(at);
            }
        }
    }
    let has = |names: &[&str]| words.iter().any(|word| names.contains(&word.as_str()));
    let rank = i8::from(has(&["raw", "uncal", "uncalibrated"]))
        - i8::from(has(&["cal", "calibrated", "corrected", "filtered"]));
    if unit.is_none() && kind == Kind::Accel && words.iter().any(|word| word == "gf") {
        unit = Unit::of("g", Quantity::Acceleration);
    }
    Meaning { kind, axis, unit, counts, stem: words.join("_"), rank }
}

/// What a unit of this kind is of.
pub fn quantity(kind: Kind) -> Option<Quantity> {
    match kind {
        Kind::Field | Kind::Derived => Some(Quantity::Field),
        Kind::Accel => Some(Quantity::Acceleration),
        Kind::Gyro => Some(Quantity::Rate),
        Kind::Time => Some(Quantity::Time),
        Kind::Temperature => Some(Quantity::Temperature),
        _ => None,
    }
}

/// Whether a word, a tag or a sensor's name speaks of a magnetometer.
pub fn speaks_of_field(text: &str) -> bool {
    let (words, _) = words_and_suffix(text, true);
    words.iter().any(|word| word.len() > 1 && FIELD.contains(&word.as_str()))
        || text.to_lowercase().starts_with("magn")
}

/// `name[2]`, `name.2`, `name(2)`: the name and the index.
fn index_off(text: &str) -> (&str, Option<usize>) {
    let text = text.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((head, inside)) = text.strip_suffix(close).and_then(|inner| inner.rsplit_once(open)) {
            let axis = match inside.trim().to_lowercase().as_str() {
                "x" => Some(0),
                "y" => Some(1),
                "z" => Some(2),
                digit => digit.parse::<usize>().ok().filter(|index| *index <= 3),
            };
            if axis.is_some() && !head.trim().is_empty() {
                return (head.trim(), axis);
            }
        }
    }
    (text, None)
}

/// A unit in brackets at the end.
fn bracket_off(text: &str) -> (&str, Option<&str>) {
    for (open, close) in [('(', ')'), ('[', ']')] {
        if let Some((head, inside)) = text.strip_suffix(close).and_then(|inner| inner.split_once(open)) {
            return (head.trim(), Some(inside.trim()));
        }
    }
    // `Magnetic field, x/µT`.
    if let Some((head, unit)) = text.rsplit_once('/')
        && !head.is_empty()
        && !head.contains('/')
        && (Unit::any(unit).is_some())
        && !matches!(
            Unit::any(head.rsplit([' ', '_']).next().unwrap_or_default()),
            Some(Unit { quantity: Some(_), .. })
        )
    {
        return (head.trim(), Some(unit));
    }
    (text, None)
}

/// The words of a name in lower case, cut at marks, at a capital after a small letter and between letters and digits;
/// and the unit that it ends with.
fn words_and_suffix(base: &str, has_unit: bool) -> (Vec<String>, Option<String>) {
    if !has_unit {
        let places = base.char_indices().filter(|(at, c)| *at > 0 && matches!(c, '_' | ' ' | '.' | '-'));
        for (at, _) in places {
            let (head, tail) = base.split_at(at);
            let unit = &tail[1..];
            let axis = unit.len() == 1 && unit.to_lowercase().starts_with(AXES);
            if !axis && !unit.is_empty() && (Unit::any(unit).is_some() || unit.eq_ignore_ascii_case("counts"))
            {
                let (mut words, _) = words_and_suffix(head, true);
                if unit.eq_ignore_ascii_case("counts") {
                    words.push("counts".into());
                }
                return (words, Some(unit.to_string()));
            }
        }
    }
    let mut words: Vec<String> = Vec::new();
    for part in base.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty()) {
        // uT and mG are one word, and so is the g-force gFx.
        let whole = part.len() > 1 && Unit::any(part).is_some() || part.len() == 3 && part.starts_with("gF");
        if whole {
            words.push(part.to_lowercase());
        } else {
            split_capitals(part, &mut words);
        }
    }
    // TimeUS, timeMs: the unit is a word of its own, and stays one of the name.
    let suffix = match words.as_slice() {
        [.., _, last] if last.len() == 2 && Unit::of(last, Quantity::Time).is_some() => Some(last.clone()),
        _ => None,
    };
    (words, if has_unit { None } else { suffix })
}

/// Cuts at a capital after a small letter, and between letters and digits.
fn split_capitals(part: &str, words: &mut Vec<String>) {
    let mut word = String::new();
    let mut last = None;
    for c in part.chars() {
        let cut = last.is_some_and(|last: char| {
            (c.is_uppercase() && last.is_lowercase()) || c.is_ascii_digit() != last.is_ascii_digit()
        });
        if cut && !word.is_empty() {
            words.push(std::mem::take(&mut word));
        }
        word.extend(c.to_lowercase());
        last = Some(c);
    }
    words.push(word);
}

/// Takes the axis out of the words.
fn axis_of(words: &mut Vec<String>, index: Option<usize>) -> Option<usize> {
    let letter = |word: &str| -> Option<usize> {
        let mut letters = word.chars();
        let first = letters.next()?;
        if letters.next().is_some() { None } else { AXES.iter().position(|axis| *axis == first) }
    };
    if index.is_some() {
        return index;
    }
    if let Some(at) = words.iter().rposition(|word| letter(word).is_some()) {
        let axis = words.get(at).and_then(|word| letter(word));
        words.remove(at);
        return axis;
    }
    // magx, xmag, mx, gfx: a known stem with the letter at its end or its beginning.
    for word in words.iter_mut() {
        let known =
            |stem: &str| [FIELD, ACCEL, GYRO].iter().any(|names| names.contains(&stem)) || stem == "gf";
        let ends = word.char_indices().next_back().and_then(|(at, c)| {
            let axis = AXES.iter().position(|axis| *axis == c)?;
            word.get(..at).filter(|stem| known(stem)).map(|stem| (axis, stem.to_string()))
        });
        let begins = word.chars().next().and_then(|c| {
            let axis = AXES.iter().position(|axis| *axis == c)?;
            word.get(1..).filter(|stem| stem.len() > 1 && known(stem)).map(|stem| (axis, stem.to_string()))
        });
        if let Some((axis, stem)) = ends.or(begins) {
            *word = stem;
            return Some(axis);
        }
    }
    match words.last().map(|word| word.parse::<usize>()) {
        Some(Ok(index)) if index <= 3 && words.len() > 1 => {
            words.pop();
            Some(index)
        }
        _ => None,
    }
}

/// Acceleration without gravity, or gravity alone: no specific force.
fn is_motion(words: &[String]) -> bool {
    words
        .iter()
        .any(|word| matches!(word.as_str(), "linear" | "lin" | "user" | "gravity" | "useracceleration"))
}

fn kind_of(words: &[String], axis: Option<usize>, base: &str) -> Kind {
    let has = |names: &[&str]| words.iter().any(|word| names.contains(&word.as_str()));
    // One letter names a vector only with an axis, and only first.
    let vector = |names: &[&str]| {
        words.iter().enumerate().any(|(at, word)| {
            names.contains(&word.as_str())
                && (word.len() > 1 || (axis.is_some() && at == 0 && words.len() <= 2))
        })
    };
    let whole = words.concat();
    if vector(FIELD) || FIELD.contains(&whole.as_str()) && whole.len() > 1 {
        return if has(ASIDE) {
            Kind::Other
        } else if axis.is_none() && has(TEMPERATURE) {
            Kind::Temperature
        } else if has(MAGNITUDE) || (has(ATTITUDE) && axis.is_none()) {
            Kind::Derived
        } else {
            Kind::Field
        };
    }
    // `Total`, `norm`, `|B|` by themselves; a `total_current` is something else.
    let only = words.iter().all(|word| MAGNITUDE.contains(&word.as_str()) || word == "b");
    if axis.is_none() && only && (has(MAGNITUDE) || base.contains('|')) {
        return Kind::Derived;
    }
    if has(TEMPERATURE) && !has(ASIDE) {
        return Kind::Temperature;
    }
    // The ROS messages call the specific force `linear_acceleration`; telephones mean acceleration without gravity.
    let ros = base.contains("linear_acceleration.") || base.contains("linear_acceleration/");
    if axis.is_some() && (vector(ACCEL) || ACCEL.contains(&whole.as_str()) || has(&["gf"])) && !has(ASIDE) {
        return if is_motion(words) && !ros { Kind::Other } else { Kind::Accel };
    }
    let rate = has(&["angular"]) && has(&["velocity", "rate"]) || has(&["rotation"]) && has(&["rate"]);
    if axis.is_some() && (vector(GYRO) || GYRO.contains(&whole.as_str()) || rate) && !has(ASIDE) {
        return Kind::Gyro;
    }
    if has(ATTITUDE) {
        return Kind::Attitude;
    }
    if INSTANCE.contains(&whole.as_str()) {
        return Kind::Instance;
    }
    if has(COUNTER) || COUNTER.contains(&whole.as_str()) {
        return Kind::Counter;
    }
    // `sec`, `nanosec`: a unit of time and no more.
    let unit_alone = words.len() == 1 && whole.len() > 2 && Unit::of(&whole, Quantity::Time).is_some();
    if axis.is_none()
        && (unit_alone
            || vector(TIME)
            || TIME.contains(&whole.as_str())
            || (words.len() == 1 && whole == "t"))
    {
        return Kind::Time;
    }
    Kind::Other
}
