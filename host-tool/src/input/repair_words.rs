//! What is said of broken numbers, and how their repairs are typed.

use crate::failure::Failure;
use crate::input::repair_asked::Asked;
use crate::shell::typed_option;
use ironout_analysis::plausible::breakage::{Breakage, Repair};

/// `--repair WHAT`, as a POSIX shell takes it.
pub fn typed(option: &str) -> String {
    typed_option("--repair", option).trim_start().to_string()
}

/// A part of `--repair` that is not a repair.
pub fn not_a_repair(part: &str) -> Failure {
    Failure::usage(format!(
        "--repair {part}: expected unsigned, swapped-bytes, signed-low-byte, x:unwrap=MODULUS/FROM, x:late=ROWS, range, \
         error-code=VALUE or none; prefix it with the affected axes, as in xy:unsigned"
    ))
}

/// As `--repair` takes it.
pub fn asked(asked: &Asked) -> String {
    match asked {
        Asked::Nothing => "none".into(),
        Asked::Range => "range".into(),
        Asked::One(repair) => option(repair),
    }
}

/// As `--repair` takes it; empty for rows that each log has at other places.
pub fn option(repair: &Repair) -> String {
    let axes = repair.axes();
    let of = if axes == [true; 3] { String::new() } else { format!("{}:", letters(axes)) };
    match repair {
        Repair::Unsigned { modulus, .. } if *modulus == 65_536.0 => format!("{of}unsigned"),
        Repair::Unsigned { modulus, .. } => format!("{of}unsigned={modulus}"),
        Repair::SwappedBytes { step, .. } if *step == 1.0 => format!("{of}swapped-bytes"),
        Repair::SwappedBytes { step, .. } => format!("{of}swapped-bytes={step}"),
        Repair::SignedLowByte { step, .. } if *step == 1.0 => format!("{of}signed-low-byte"),
        Repair::SignedLowByte { step, .. } => format!("{of}signed-low-byte={step}"),
        Repair::Unwrap { modulus, from: Some(from), .. } => format!("{of}unwrap={modulus}/{from}"),
        Repair::Unwrap { modulus, from: None, .. } => format!("{of}unwrap={modulus}"),
        Repair::LateAxis { rows, .. } => format!("{of}late={rows}"),
        Repair::RangeChange { .. } => "range".into(),
        Repair::ErrorCode { axes, code } => {
            let mut values: Vec<f64> =
                code.iter().zip(axes).filter(|(_, is)| **is).map(|(v, _)| *v).collect();
            if values.len() < 3 {
                values.dedup();
            }
            format!("{of}error-code={}", values.iter().map(f64::to_string).collect::<Vec<_>>().join("/"))
        }
        Repair::EveryRow { .. } | Repair::FrozenAxis { .. } => String::new(),
    }
}

fn letters(axes: [bool; 3]) -> String {
    ['x', 'y', 'z'].iter().zip(axes).filter(|(_, is)| *is).map(|(axis, _)| *axis).collect()
}

/// `axis x`, `axes x and z`, `the three axes`.
fn of_axes(axes: [bool; 3]) -> String {
    let list: Vec<String> = letters(axes).chars().map(String::from).collect();
    match list.as_slice() {
        [one] => format!("axis {one}"),
        [one, other] => format!("axes {one} and {other}"),
        _ => "the three axes".into(),
    }
}

/// What is wrong with the numbers.
pub fn recognised(found: &Breakage) -> String {
    let axes = of_axes(found.repair.axes());
    let (rows, first) = (found.rows, found.first_row + 1);
    let share = (100.0 * found.explained).clamp(0.0, 100.0);
    let what = match &found.repair {
        Repair::Unsigned { modulus, .. } => format!(
            "the magnetometer's numbers in {axes} are negative numbers read as unsigned: values above {} are negative \
             (subtract \
             {modulus})",
            if modulus.fract() == 0.0 { modulus / 2.0 - 1.0 } else { modulus / 2.0 }
        ),
        Repair::SwappedBytes { .. } => {
            format!("the two bytes of the magnetometer's numbers in {axes} are swapped")
        }
        Repair::SignedLowByte { .. } => format!(
            "the low byte of the magnetometer's numbers in {axes} was added as a signed number: 256 is missing if it is 128 \
             or more"
        ),
        Repair::Unwrap { modulus, from: Some(_), .. } => {
            format!("the magnetometer's numbers in {axes} overflow and wrap: they jump by {modulus}")
        }
        Repair::Unwrap { modulus, from: None, .. } => format!(
            "the magnetometer's numbers in {axes} wrap: they jump by {modulus}, and their range is larger than that. A wider sensor range or number type is better"
        ),
        Repair::LateAxis { rows, .. } => {
            let (count, when) = (rows.abs(), if *rows > 0 { "late" } else { "early" });
            return format!(
                "{axes} of the magnetometer is {count} row{} {when} against the other two: moved, {share:.0} % of the \
                 distance from an \
                 ellipsoid disappears",
                if count == 1 { "" } else { "s" }
            );
        }
        Repair::RangeChange { changes } => {
            let list: Vec<String> = changes
                .iter()
                .map(|(row, factor)| format!("{} from row {}", short(*factor), row + 1))
                .collect();
            return format!(
                "the scale of the magnetometer changes while the log runs (its range was set): the numbers are larger by \
                 the factor {}. \
                 With one scale, {share:.0} % of the distance from an ellipsoid disappears",
                list.join(", ")
            );
        }
        other => return set_aside(other, Some(found)),
    };
    format!("{what} ({rows} rows, first row {first}; {share:.0} % of the jumps between those rows disappear)")
}

/// Why rows are set aside.
pub fn set_aside(repair: &Repair, found: Option<&Breakage>) -> String {
    let first = found.map_or(String::new(), |found| format!(" (first in row {})", found.first_row + 1));
    let axes = of_axes(repair.axes());
    match repair {
        Repair::ErrorCode { axes: concerned, code } => {
            let values: Vec<String> =
                code.iter().zip(concerned).filter(|(_, is)| **is).map(|(v, _)| v.to_string()).collect();
            format!("{} in {axes} is an error code of a failed reading{first}", values.join(", "))
        }
        Repair::EveryRow { every, .. } => {
            format!("every {every}{} row does not match the rows next to it{first}", ordinal(*every))
        }
        Repair::FrozenAxis { .. } => {
            format!("{axes} freezes while the others continue, and then jumps{first}")
        }
        other => recognised(&Breakage { repair: other.clone(), rows: 0, first_row: 0, explained: 1.0 }),
    }
}

/// What was mended.
pub fn made(repair: &Repair, found: Option<&Breakage>) -> String {
    match (repair, found) {
        (Repair::RangeChange { .. }, Some(found)) => format!("--repair range: {}", recognised(found)),
        _ => format!("--repair {}", option(repair)),
    }
}

fn ordinal(number: usize) -> &'static str {
    match (number % 10, number % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    }
}

fn short(value: f64) -> String {
    if value >= 1.0 || value <= 0.0 {
        format!("{}", (value * 1000.0).round() / 1000.0)
    } else {
        format!("1/{}", (1000.0 / value).round() / 1000.0)
    }
}
