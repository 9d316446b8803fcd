//! What each header of a log stands for.

use crate::failure::{Failure, Outcome};

/// More columns than any logger writes; beyond it the file is something else.
pub const MAX_COLUMNS: usize = 1024;

/// What a column holds. `axis` is 0, 1, 2 for x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// `t_s`.
    Seconds,
    /// `t_us`.
    Microseconds,
    /// `mx_ut`, `my_ut`, `mz_ut`.
    FieldUt(usize),
    /// `mx_counts`, `my_counts`, `mz_counts`.
    FieldCounts(usize),
    /// `ax_mps2`, `ay_mps2`, `az_mps2`.
    Accel(usize),
    /// `gx_radps`, `gy_radps`, `gz_radps`.
    Gyro(usize),
    /// `heading_deg`.
    Heading,
    /// Any other numeric column.
    Covariate,
    /// A header without a name.
    Unnamed,
}

impl Role {
    fn of(name: &str) -> Role {
        const AXES: [&str; 3] = ["x", "y", "z"];
        for (axis, letter) in AXES.iter().enumerate() {
            let Some(unit) = name.get(1..).and_then(|rest| rest.strip_prefix(letter)) else { continue };
            match (&name[..1], unit) {
                ("m", "_ut") => return Role::FieldUt(axis),
                ("m", "_counts") => return Role::FieldCounts(axis),
                ("a", "_mps2") => return Role::Accel(axis),
                ("g", "_radps") => return Role::Gyro(axis),
                _ => {}
            }
        }
        match name {
            "t_s" => Role::Seconds,
            "t_us" => Role::Microseconds,
            "heading_deg" => Role::Heading,
            "" => Role::Unnamed,
            _ => Role::Covariate,
        }
    }
}

/// One column of the log.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The name after `--map`.
    pub name: String,
    /// What it holds.
    pub role: Role,
}

/// Splits `--map name=Header,name=Header` (repeatable) into pairs.
pub fn parse_map(arguments: &[String]) -> Outcome<Vec<(String, String)>> {
    let mut pairs: Vec<(String, String)> = Vec::new();
    for part in arguments.iter().flat_map(|argument| argument.split(',')) {
        let (name, header) = part
            .split_once('=')
            .map(|(name, header)| (name.trim(), header.trim()))
            .filter(|(name, header)| !name.is_empty() && !header.is_empty())
            .ok_or_else(|| {
                Failure::usage(format!(
                    "--map {part}: expected NAME=HEADER, as in --map mx_ut=MagX,my_ut=MagY,mz_ut=MagZ"
                ))
            })?;
        if pairs.iter().any(|(known, old)| known == name || old == header) {
            return Err(Failure::usage(format!("--map {part}: \"{name}\" or \"{header}\" is mapped twice")));
        }
        pairs.push((name.to_string(), header.to_string()));
    }
    Ok(pairs)
}

/// Names and roles for a header line. `line` is its line number, for errors.
pub fn interpret(header: &[String], map: &[(String, String)], line: u64) -> Outcome<Vec<Column>> {
    let fail = |message: String| Failure::usage(message).at_line(line);
    if header.len() > MAX_COLUMNS {
        return Err(fail(format!(
            "{} columns, at most {MAX_COLUMNS} are read: is this the header of a log?",
            header.len()
        )));
    }
    if header.len() == 1 {
        let separator = [(';', "semicolons"), ('\t', "tabs"), ('|', "bars"), (' ', "blanks")]
            .into_iter()
            .find(|(mark, _)| header[0].trim().contains(*mark));
        if let Some((_, name)) = separator {
            return Err(fail(format!(
                "the columns seem to be separated by {name}: a log is separated by commas (and 1.5 is written \
                 with a point); save it as comma-separated CSV"
            )));
        }
    }
    if header.iter().any(|cell| super::number::parse(cell.as_bytes()).is_some()) {
        return Err(fail(format!(
            "the first line holds numbers ({}): it must name the columns, as in t_s,mx_ut,my_ut,mz_ut",
            shorten(&header.join(","))
        )));
    }
    for (name, from) in map {
        if !header.iter().any(|cell| cell == from) {
            return Err(fail(format!(
                "--map {}={}: there is no column \"{}\"; {}",
                shorten(name),
                shorten(from),
                shorten(from),
                listing(header)
            )));
        }
    }
    let mut columns: Vec<Column> = Vec::with_capacity(header.len());
    for cell in header {
        let name = map.iter().find(|(_, from)| from == cell).map_or(cell, |(name, _)| name);
        if !name.is_empty() && columns.iter().any(|column| column.name == *name) {
            let name = shorten(name);
            return Err(fail(format!("column \"{name}\" stands twice in the header: rename or remove one"))
                .at_column(name));
        }
        columns.push(Column { name: name.clone(), role: Role::of(name) });
    }
    Ok(columns)
}

/// The indices of a complete triple; an incomplete one is an error only for the magnetometer, so that is left
/// to the caller.
pub fn triple(columns: &[Column], make: fn(usize) -> Role) -> [Option<usize>; 3] {
    [0, 1, 2].map(|axis| columns.iter().position(|column| column.role == make(axis)))
}

/// The error for a log without a magnetometer: what is missing, what is there, and the `--map` to write.
pub fn no_field(header: &[String], columns: &[Column], line: u64) -> Failure {
    let ut = triple(columns, Role::FieldUt);
    let counts = triple(columns, Role::FieldCounts);
    let (found, unit) = if counts.iter().flatten().count() > ut.iter().flatten().count() {
        (counts, "counts")
    } else {
        (ut, "ut")
    };
    let missing: Vec<String> = ["x", "y", "z"]
        .iter()
        .zip(found)
        .filter(|(_, index)| index.is_none())
        .map(|(axis, _)| format!("m{axis}_{unit}"))
        .collect();
    let guess = guess_map(header);
    let (plural, there) = if missing.len() == 1 { ("", "is") } else { ("s", "are") };
    let mut message = format!("column{plural} {} {there} missing: {}", missing.join(", "), listing(header));
    message.push_str(". A log names its magnetometer mx_ut,my_ut,mz_ut (microtesla) or mx_counts,my_counts,mz_counts (raw). ");
    match guess {
        Some([x, y, z]) => message.push_str(&format!(
            "If these are microtesla: --map mx_ut={x},my_ut={y},mz_ut={z}; any other unit: --map \
             mx_counts={x},my_counts={y},mz_counts={z} --ut-per-count SCALE (0.1 for milligauss, 100 for gauss)"
        )),
        None => message.push_str("Other headers are named with --map mx_ut=HEADER,my_ut=HEADER,mz_ut=HEADER"),
    }
    Failure::usage(message).at_line(line).at_column(missing.first().cloned().unwrap_or_default())
}

/// Three headers that differ in one letter x, y, z and speak of a magnetometer: offered, never taken.
fn guess_map(header: &[String]) -> Option<[String; 3]> {
    let is_field = |name: &str| {
        let lower = name.to_lowercase();
        lower.contains("mag") || lower.starts_with('m') || lower.starts_with('b') || lower.starts_with('h')
    };
    header.iter().filter(|cell| is_field(cell)).find_map(|cell| {
        cell.char_indices().filter(|(_, c)| matches!(c, 'x' | 'X')).find_map(|(at, c)| {
            let with = |letter: char| {
                let letter = if c == 'X' { letter.to_ascii_uppercase() } else { letter };
                let name = format!("{}{letter}{}", &cell[..at], &cell[at + 1..]);
                header.contains(&name).then_some(name)
            };
            Some([cell.clone(), with('y')?, with('z')?])
        })
    })
}

fn listing(header: &[String]) -> String {
    format!("the header has {}", shorten(&header.join(", ")))
}

/// At most some 200 characters of `text`.
pub fn shorten(text: &str) -> String {
    match text.char_indices().nth(200) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(text: &str) -> Vec<String> {
        text.split(',').map(str::to_string).collect()
    }

    #[test]
    fn roles_follow_the_names() {
        let columns =
            interpret(&header("t_s,my_ut,gz_radps,ax_mps2,heading_deg,temp_c,mx"), &[], 1).expect("valid");
        let roles: Vec<Role> = columns.iter().map(|column| column.role).collect();
        assert_eq!(
            roles,
            [
                Role::Seconds,
                Role::FieldUt(1),
                Role::Gyro(2),
                Role::Accel(0),
                Role::Heading,
                Role::Covariate,
                Role::Covariate
            ]
        );
    }

    #[test]
    fn names_of_any_letters_are_covariates() {
        for name in ["é", "µx_ut", "m", "mé_ut", "字x"] {
            assert_eq!(Role::of(name), Role::Covariate, "{name}");
        }
    }

    #[test]
    fn a_missing_magnetometer_is_answered_with_the_map_to_write() {
        let header = header("time,MagX,MagY,MagZ,accX");
        let columns = interpret(&header, &[], 3).expect("valid");
        let failure = no_field(&header, &columns, 3);
        assert_eq!(failure.line, Some(3));
        assert!(failure.message.contains("--map mx_ut=MagX,my_ut=MagY,mz_ut=MagZ"), "{failure}");
    }
}
