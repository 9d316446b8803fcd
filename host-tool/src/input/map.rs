//! `--map NAME=HEADER[UNIT],…`: which column of the file is what, and in which unit.

use crate::failure::{Failure, Outcome};
use crate::input::words::{listing, shorten};
use ironout::effect::{BadName, ColumnName};

/// Splits `--map` (repeatable) into pairs of a name and a header with its unit. A header with a comma stands in double quotes:
/// `mx_ut="Field, x"[uT]`.
pub fn parse_map(arguments: &[String]) -> Outcome<Vec<(String, String)>> {
    let mut pairs: Vec<(String, String)> = Vec::new();
    for part in arguments.iter().flat_map(|argument| split(argument)) {
        let (name, header) = part
            .split_once('=')
            .map(|(name, header)| (name.trim(), unquoted(header.trim())))
            .filter(|(name, header)| !name.is_empty() && !header.is_empty())
            .ok_or_else(|| {
                Failure::usage(format!(
                    "--map {part}: expected NAME=HEADER, as in --map mx_ut=MagX,my_ut=MagY,mz_ut=MagZ"
                ))
            })?;
        if ColumnName::new(name).is_err() {
            return Err(Failure::usage(format!(
                "--map {part}: \"{name}\" is not a valid column name: {BadName}"
            )));
        }
        if pairs.iter().any(|(known, old)| known == name || *old == header) {
            return Err(Failure::usage(format!("--map {part}: \"{name}\" or \"{header}\" is mapped twice")));
        }
        pairs.push((name.to_string(), header));
    }
    Ok(pairs)
}

/// Cuts at commas outside of quotes.
fn split(argument: &str) -> Vec<&str> {
    let (mut parts, mut start, mut inside) = (Vec::new(), 0, false);
    for (at, c) in argument.char_indices() {
        match c {
            '"' => inside = !inside,
            ',' if !inside => {
                parts.push(argument.get(start..at).unwrap_or_default());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(argument.get(start..).unwrap_or_default());
    parts
}

fn unquoted(header: &str) -> String {
    let Some(rest) = header.strip_prefix('"') else { return header.to_string() };
    match rest.rfind('"') {
        Some(end) => {
            let (inner, tail) = rest.split_at(end);
            format!("{}{}", inner.replace("\"\"", "\""), tail.strip_prefix('"').unwrap_or(tail))
        }
        None => header.to_string(),
    }
}

/// `name=header[unit]`, quoted where the header has a comma or a quote.
pub fn entry(name: &str, header: &str, unit: Option<&str>) -> String {
    let quoted = if header.contains([',', '"']) {
        format!("\"{}\"", header.replace('"', "\"\""))
    } else {
        header.to_string()
    };
    match unit {
        Some(unit) => format!("{name}={quoted}[{unit}]"),
        None => format!("{name}={quoted}"),
    }
}

/// The column that the header side of an entry means, and the unit stated behind it. A header that ends with brackets itself is
/// taken by its whole name first.
pub fn resolve<'a>(from: &'a str, headers: &[String]) -> Option<(usize, Option<&'a str>)> {
    if let Some(index) = headers.iter().position(|header| header == from) {
        return Some((index, None));
    }
    let (head, unit) = from.strip_suffix(']')?.rsplit_once('[')?;
    let index = headers.iter().position(|header| header == head)?;
    Some((index, Some(unit.trim())))
}

/// The error for an entry whose column is not there.
pub fn missing(name: &str, from: &str, headers: &[String]) -> Failure {
    Failure::usage(format!(
        "--map {}={}: there is no column \"{}\"; {}",
        shorten(name),
        shorten(from),
        shorten(from),
        listing(headers)
    ))
}

/// The error for a unit that is none.
pub fn no_unit(name: &str, unit: &str) -> Failure {
    Failure::usage(format!(
        "--map {name}=…[{unit}]: unknown unit for that column. Known units: T, mT, uT, nT, G, mG; s, ms, us, ns, ISO; m/s2, \
         g, mg; rad/s, deg/s; C, K, \
         F; A, mA; V, mV; or a number that scales it to the unit in its name"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_with_units_brackets_and_commas() {
        let pairs =
            parse_map(&["mx_ut=mag[0][G],my_ut=\"a, \"\"b\"\"\"[mG]".into(), "t_s=t".into()]).expect("a map");
        let expected = [("mx_ut", "mag[0][G]"), ("my_ut", "a, \"b\"[mG]"), ("t_s", "t")];
        assert_eq!(pairs, expected.map(|(name, header)| (name.to_string(), header.to_string())));
        assert_eq!(entry("my_ut", "a, \"b\"", Some("mG")), "my_ut=\"a, \"\"b\"\"\"[mG]");
        let headers: Vec<String> = ["mag[0]", "time [ms]", "x"].map(String::from).to_vec();
        assert_eq!(resolve("mag[0][G]", &headers), Some((0, Some("G"))));
        assert_eq!(resolve("mag[0]", &headers), Some((0, None)));
        assert_eq!(resolve("time [ms]", &headers), Some((1, None)));
        assert_eq!(resolve("x[mG]", &headers), Some((2, Some("mG"))));
        assert_eq!(resolve("y", &headers), None);
        for bad in ["mx_ut", "=x", "mx_ut=", "a=b,a=c", "a=b,c=b"] {
            assert!(parse_map(&[bad.to_string()]).is_err(), "{bad}");
        }
    }
}
