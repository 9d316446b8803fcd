//! `--repair`: broken numbers of the magnetometer, recognised by the repair that undoes them, and mended where it is stated.

use crate::failure::{Failure, Outcome};
use crate::input::repair_asked::Asked;
use crate::input::repair_words as words;
use ironout_analysis::plausible::breakage::{Breakage, Repair, find};

/// The numbers of two bytes.
const SIXTEEN_BITS: f64 = 65_536.0;

/// What the repairs left of the magnetometer's numbers.
pub struct Mended {
    /// The numbers of the rows that are left.
    pub numbers: [Vec<f64>; 3],
    /// Places of those rows.
    pub kept: Vec<usize>,
    /// Rows set aside, and why.
    pub left_out: Vec<(usize, String)>,
    /// Repairs that were made, in words.
    pub made: Vec<String>,
    /// Recognised error codes, as `--repair` takes them: another log of this sensor has the same.
    pub codes: Vec<String>,
}

/// Reads `--repair` (repeatable): repairs separated by commas.
///
/// # Errors
/// What is not a repair, with the list of those there are.
pub fn parse(arguments: &[String]) -> Outcome<Vec<Asked>> {
    let parts =
        arguments.iter().flat_map(|text| text.split(',')).map(str::trim).filter(|part| !part.is_empty());
    parts.map(|part| one(part).ok_or_else(|| words::not_a_repair(part))).collect()
}

fn one(text: &str) -> Option<Asked> {
    let (axes, kind) = match text.split_once(':') {
        Some((axes, kind)) => {
            let only = !axes.is_empty() && axes.chars().all(|c| "xyz".contains(c));
            (only.then(|| ['x', 'y', 'z'].map(|axis| axes.contains(axis)))?, kind)
        }
        None => ([true; 3], text),
    };
    let (kind, values) = match kind.split_once('=') {
        Some((kind, values)) => {
            let numbers: Option<Vec<f64>> = values
                .split('/')
                .map(|value| {
                    value.trim().parse().ok().filter(|value: &f64| value.is_finite() && value.abs() < 1e15)
                })
                .collect();
            (kind, numbers?)
        }
        None => (kind, Vec::new()),
    };
    let positive = |default: f64| match values.as_slice() {
        [] => Some(default),
        [value] if *value > 0.0 => Some(*value),
        _ => None,
    };
    let single = || {
        let mut concerned = (0..3).filter(|axis| axes[*axis]);
        concerned.next().filter(|_| concerned.next().is_none())
    };
    Some(Asked::One(match kind {
        "none" if text == "none" => return Some(Asked::Nothing),
        "range" if text == "range" => return Some(Asked::Range),
        "unsigned" => Repair::Unsigned { axes, modulus: positive(SIXTEEN_BITS)? },
        "swapped-bytes" => Repair::SwappedBytes { axes, step: positive(1.0)? },
        "signed-low-byte" => Repair::SignedLowByte { axes, step: positive(1.0)? },
        "unwrap" => match values.as_slice() {
            [modulus] if *modulus > 0.0 => Repair::Unwrap { axis: single()?, modulus: *modulus, from: None },
            [modulus, from] if *modulus > 0.0 => {
                Repair::Unwrap { axis: single()?, modulus: *modulus, from: Some(*from) }
            }
            _ => return None,
        },
        "late" => match values.as_slice() {
            [rows] if rows.fract() == 0.0 && rows.abs() <= 1000.0 => {
                Repair::LateAxis { axis: single()?, rows: *rows as isize }
            }
            _ => return None,
        },
        "error-code" => match values.as_slice() {
            [value] => Repair::ErrorCode { axes, code: [*value; 3] },
            [x, y, z] => Repair::ErrorCode { axes, code: [*x, *y, *z] },
            _ => return None,
        },
        _ => return None,
    }))
}

/// Makes the repairs that are asked for, recognises others, and sets aside the rows that are not readings.
///
/// # Errors
/// Numbers that are broken and can be mended, with the option that does it.
pub fn mend(numbers: [Vec<f64>; 3], asked: &[Asked]) -> Outcome<Mended> {
    let rows = numbers[0].len();
    let mut mended = Mended {
        numbers,
        kept: (0..rows).collect(),
        left_out: Vec::new(),
        made: Vec::new(),
        codes: Vec::new(),
    };
    for one in asked {
        if let Asked::One(repair) = one {
            mended.make(repair, None);
        }
    }
    if asked.contains(&Asked::Nothing) {
        return Ok(mended);
    }
    let found = find(mended.axes());
    if found.is_empty() {
        return Ok(mended);
    }
    let makes = |one: &Breakage| {
        one.repair.sets_aside()
            || (matches!(one.repair, Repair::RangeChange { .. }) && asked.contains(&Asked::Range))
    };
    let lacking: Vec<&Breakage> = found.iter().filter(|one| !makes(one)).collect();
    if !lacking.is_empty() {
        return Err(broken(&lacking, asked));
    }
    for one in &found {
        mended.make(&one.repair, Some(one));
        if let Repair::ErrorCode { .. } = &one.repair {
            mended.codes.push(words::option(&one.repair));
        }
    }
    Ok(mended)
}

/// Broken numbers: each kind in a sentence, and one option for all.
fn broken(found: &[&Breakage], asked: &[Asked]) -> Failure {
    let mut wanted: Vec<String> = Vec::new();
    let mut undone = false;
    for one in asked {
        let back = matches!(one, Asked::One(Repair::SwappedBytes { .. } | Repair::SignedLowByte { .. }))
            && found.iter().any(|found| *one == Asked::One(found.repair.clone()));
        undone |= back;
        if !back {
            wanted.push(words::asked(one));
        }
    }
    // A repair of numbers that were right is undone by leaving it out.
    if !undone {
        wanted.extend(found.iter().map(|one| words::option(&one.repair)));
    }
    let told: Vec<String> = if undone {
        vec!["the numbers of the magnetometer are continuous from row to row only without the repair of their bytes".into()]
    } else {
        found.iter().map(|one| words::recognised(one)).collect()
    };
    let option = if wanted.is_empty() { "none".to_string() } else { wanted.join(",") };
    Failure::usage(format!("{}.\nFix: read the log with\n  {}", told.join(".\n"), words::typed(&option)))
}

impl Mended {
    fn axes(&self) -> [&[f64]; 3] {
        [self.numbers[0].as_slice(), self.numbers[1].as_slice(), self.numbers[2].as_slice()]
    }

    fn make(&mut self, repair: &Repair, found: Option<&Breakage>) {
        let before = self.kept.len();
        repair.make(&mut self.numbers, &mut self.kept);
        let gone = before - self.kept.len();
        if repair.sets_aside() {
            if gone > 0 {
                self.left_out.push((gone, words::set_aside(repair, found)));
            }
        } else {
            self.made.push(words::made(repair, found));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_repair_reads_back_as_it_is_typed() {
        for text in [
            "none",
            "range",
            "unsigned",
            "xz:unsigned",
            "unsigned=4096",
            "y:swapped-bytes",
            "swapped-bytes=0.15",
            "z:signed-low-byte",
            "x:unwrap=65536/-20000",
            "x:unwrap=256",
            "y:late=2",
            "y:late=-1",
            "error-code=0/0/0",
            "x:error-code=-4096",
        ] {
            let asked =
                parse(&[text.to_string()]).unwrap_or_else(|failure| panic!("{text}: {}", failure.message));
            assert_eq!(asked.iter().map(words::asked).collect::<Vec<_>>(), [text]);
        }
        for text in [
            "what",
            "q:unsigned",
            "unwrap=1",
            "xy:late=1",
            "unsigned=0",
            "unsigned=-1",
            "late=1",
            "x:none",
            ":unsigned",
        ] {
            assert!(parse(&[text.to_string()]).is_err(), "{text}");
        }
    }
}
