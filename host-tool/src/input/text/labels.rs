//! Numbers with labels: `X: 1 Y: 2 Z: 3`, `mx=1 my=2 mz=3`, `Mag (uT) [ 1, 2, 3 ]`, JSON objects.

use crate::input::number;
use crate::input::unit::Unit;

/// A value and what it is called.
#[derive(Debug, Clone, PartialEq)]
pub struct Labelled {
    /// Its name, with the section it stands in: `Mag x`, `Mag (uT)[1]`.
    pub name: String,
    /// The number.
    pub value: f64,
    /// A text instead of a number.
    pub text: Option<String>,
}

/// The labelled numbers of a line; none where it is something else. With `decimal_comma`, 1,5 is one and a half.
pub fn scan(line: &str, decimal_comma: bool) -> Vec<Labelled> {
    let line = line.trim();
    if line.starts_with('{') {
        return json(line);
    }
    if line.contains('\'')
        && let Some(one) = state(line)
    {
        return vec![one];
    }
    if line.contains('/')
        && let Some(all) = between_slashes(line)
    {
        return all;
    }
    let mut out: Vec<Labelled> = Vec::new();
    let (mut section, mut label, mut index) = (String::new(), String::new(), 0_usize);
    let mut rest = line;
    while let Some((before, token, after)) = next_number(rest, decimal_comma) {
        rest = after;
        let Some(value) = number::parse(token.replace(',', ".").as_bytes()).filter(|value| value.is_finite())
        else {
            return Vec::new();
        };
        let mut chunk = before.trim_matches(|c: char| c.is_whitespace() || ",;|])}".contains(c));
        // The unit of the number before.
        if !out.is_empty()
            && let Some((unit, tail)) =
                chunk.split_once(char::is_whitespace).or((!chunk.is_empty()).then_some((chunk, "")))
            && let unit = unit.trim_end_matches([',', ';', '|'])
            && Unit::any(unit).is_some()
            && (!tail.trim().is_empty() || !chunk.contains([':', '=']))
        {
            name_unit(&mut out, unit);
            chunk = tail.trim_start_matches(|c: char| c.is_whitespace() || ",;|])}".contains(c));
        }
        if chunk.is_empty() {
            if label.is_empty() {
                return Vec::new();
            }
            index += 1;
            if index == 1
                && let Some(first) = out.last_mut()
            {
                first.name = format!("{label}[0]");
            }
            out.push(Labelled { name: format!("{label}[{index}]"), value, text: None });
            continue;
        }
        // A label is one that a mark, a bracket or nothing but letters leads to its number.
        let marked = chunk.ends_with([':', '=', '[', '(', '{']);
        let clean = chunk.trim_end_matches(|c: char| c.is_whitespace() || ":=[({".contains(c)).trim();
        if !marked || !clean.starts_with(|c: char| c.is_alphabetic() || c == '_' || c == '|') {
            return Vec::new();
        }
        // `Mag: X`, `Scaled. Acc (mg)`.
        let (head, own) = match clean.rsplit_once(':') {
            Some((head, own)) if !own.trim().is_empty() => (head.trim(), own.trim()),
            _ => ("", clean),
        };
        let own = own.rsplit_once(". ").map_or(own, |(_, own)| own);
        if !head.is_empty() {
            section = head.to_string();
        }
        let bare = own.len() == 1;
        label = if bare && !section.is_empty() { format!("{section} {own}") } else { own.to_string() };
        if !bare && head.is_empty() {
            // `Mag X: 1 Y: 2`: what follows belongs to it.
            section = own.strip_suffix([' ', '_', '.']).unwrap_or(own).to_string();
            if let Some((stem, axis)) = own.rsplit_once([' ', '_', '.'])
                && axis.len() == 1
            {
                section = stem.to_string();
            } else {
                section.clear();
            }
        }
        index = 0;
        out.push(Labelled { name: label.clone(), value, text: None });
    }
    if let Some((unit, _)) = rest.trim().split_once(char::is_whitespace).or(Some((rest.trim(), "")))
        && !out.is_empty()
        && Unit::any(unit).is_some()
    {
        name_unit(&mut out, unit);
    }
    out
}

/// A sensor's state as ESPHome logs it, one line each: `'Field Strength X': Sending state 62.9 µT with 1 decimals of accuracy`, and since
/// 2025 `'Field Strength X' >> 62.9 µT`.
fn state(line: &str) -> Option<Labelled> {
    let (head, said) = line.split_once("': Sending state ").or_else(|| line.split_once("' >> "))?;
    let (_, name) = head.rsplit_once('\'')?;
    let mut words = said.split_whitespace();
    let value = number::parse(words.next()?.as_bytes()).filter(|value| value.is_finite())?;
    let unit = words.next().filter(|unit| Unit::any(unit).is_some());
    let name = unit.map_or_else(|| name.to_string(), |unit| format!("{name} ({unit})"));
    Some(Labelled { name, value, text: None })
}

/// `Raw 0.63/-0.21/0.15 heading 35`: three numbers or more with slashes between them, and words before each number that name it.
fn between_slashes(line: &str) -> Option<Vec<Labelled>> {
    let is_list = |token: &str| {
        token.matches('/').count() >= 2
            && token.split('/').all(|part| number::parse(part.as_bytes()).is_some())
    };
    // A date has slashes too, and no point or sign.
    let is_list = |token: &&str| is_list(token) && token.contains(['.', '-']);
    if !line.split_whitespace().any(|token| is_list(&token)) {
        return None;
    }
    let (mut out, mut label) = (Vec::new(), String::new());
    for token in line.split_whitespace() {
        let token = token.trim_matches([',', ';', '|', '(', ')']);
        if is_list(&token) {
            let values = token.split('/').filter_map(|part| number::parse(part.as_bytes()));
            let name = std::mem::take(&mut label);
            let name = if name.is_empty() { "raw".to_string() } else { name };
            out.extend(values.enumerate().map(|(at, value)| Labelled {
                name: format!("{name}[{at}]"),
                value,
                text: None,
            }));
        } else if let Some(value) = number::parse(token.as_bytes()).filter(|value| value.is_finite()) {
            if !label.is_empty() {
                out.push(Labelled { name: std::mem::take(&mut label), value, text: None });
            }
        } else {
            let word = token.trim_end_matches([':', '=']);
            if Unit::any(word).is_some() && label.is_empty() && !out.is_empty() {
                name_unit(&mut out, word);
                continue;
            }
            if !label.is_empty() {
                label.push(' ');
            }
            label.push_str(word);
        }
    }
    Some(out)
}

fn name_unit(out: &mut [Labelled], unit: &str) {
    if let Some(last) = out.last_mut()
        && !last.name.ends_with([')', ']'])
    {
        last.name = format!("{} ({unit})", last.name);
    }
}

/// The text before the next number, the number, and the rest. A number begins where no name does.
fn next_number(text: &str, decimal_comma: bool) -> Option<(&str, &str, &str)> {
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        let before = at.checked_sub(1).and_then(|i| bytes.get(i)).copied().unwrap_or(b' ');
        let free = !(before.is_ascii_alphanumeric() || before == b'_' || before == b'.' || before >= 0x80);
        let start = bytes.get(at).copied().unwrap_or_default();
        let digit = |i: usize| bytes.get(i).is_some_and(u8::is_ascii_digit);
        let begins = match start {
            b'0'..=b'9' => true,
            b'-' | b'+' => digit(at + 1) || (bytes.get(at + 1) == Some(&b'.') && digit(at + 2)),
            b'.' => digit(at + 1),
            _ => false,
        };
        // The index of `mag[0]: 1.5` is no number, nor the unit of `x (m/s^2): 1`.
        if free
            && begins
            && before != b'^'
            && !(before == b'[' && closes_as_index(text.get(at..).unwrap_or_default()))
        {
            let end = end_of_number(bytes, at, decimal_comma);
            let follows = bytes.get(end).copied().unwrap_or(b' ');
            if !(follows.is_ascii_alphabetic() && bytes.get(end + 1).is_some_and(u8::is_ascii_alphanumeric))
                || unit_at(text, end)
            {
                return Some((text.get(..at)?, text.get(at..end)?, text.get(end..)?));
            }
            at = end;
            continue;
        }
        at += 1;
    }
    None
}

/// Whether a unit stands right behind a number: `25.5uT`.
fn unit_at(text: &str, end: usize) -> bool {
    let tail = text.get(end..).unwrap_or_default();
    let word = tail.split(|c: char| c.is_whitespace() || ",;|".contains(c)).next().unwrap_or_default();
    Unit::any(word).is_some()
}

/// `0]: ` or `0]=` is the index of a label.
fn closes_as_index(text: &str) -> bool {
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    digits > 0
        && text.get(digits..).and_then(|tail| tail.strip_prefix(']')).is_some_and(|tail| {
            let tail = tail.trim_start();
            tail.starts_with(['=', ':', '('])
        })
}

fn end_of_number(bytes: &[u8], start: usize, decimal_comma: bool) -> usize {
    let mut end = start;
    let digit = |i: usize| bytes.get(i).is_some_and(u8::is_ascii_digit);
    if matches!(bytes.get(end), Some(b'-' | b'+')) {
        end += 1;
    }
    while digit(end) {
        end += 1;
    }
    let mark = match bytes.get(end) {
        Some(b'.') => true,
        Some(b',') => decimal_comma && digit(end + 1),
        _ => false,
    };
    if mark {
        end += 1;
        while digit(end) {
            end += 1;
        }
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'-' | b'+')));
        if digit(end + 1 + sign) {
            end += 1 + sign;
            while digit(end) {
                end += 1;
            }
        }
    }
    end
}

/// A JSON object, nested ones as `mag.x`, arrays as `mag[0]`.
fn json(line: &str) -> Vec<Labelled> {
    match serde_json::from_str::<serde_json::Value>(line) {
        Ok(value) => object(&value),
        // A dictionary as Python prints it.
        Err(_) if line.contains('\'') => {
            serde_json::from_str(&line.replace('\'', "\"")).map_or(Vec::new(), |value| object(&value))
        }
        Err(_) => Vec::new(),
    }
}

/// The numbers and texts of a JSON object.
pub fn object(value: &serde_json::Value) -> Vec<Labelled> {
    let mut out = Vec::new();
    if value.is_object() {
        flatten("", value, 0, &mut out);
    }
    out
}

fn flatten(name: &str, value: &serde_json::Value, depth: usize, out: &mut Vec<Labelled>) {
    use serde_json::Value;
    if depth > 6 || out.len() > 256 {
        return;
    }
    match value {
        Value::Number(number) => {
            if let Some(value) = number.as_f64() {
                out.push(Labelled { name: name.to_string(), value, text: None });
            }
        }
        Value::String(text) => {
            let value = number::parse(text.as_bytes()).unwrap_or(f64::NAN);
            out.push(Labelled { name: name.to_string(), value, text: Some(text.clone()) });
        }
        Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                flatten(&format!("{name}[{index}]"), item, depth + 1, out);
            }
        }
        Value::Object(fields) => {
            for (key, item) in fields {
                let inner = if name.is_empty() { key.clone() } else { format!("{name}.{key}") };
                flatten(&inner, item, depth + 1, out);
            }
        }
        Value::Null | Value::Bool(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(line: &str, comma: bool) -> Vec<(String, f64)> {
        scan(line, comma).into_iter().map(|found| (found.name, found.value)).collect()
    }

    #[test]
    fn prints_of_many_boards() {
        let expect = |line: &str, names: [&str; 3]| {
            let found = pairs(line, false);
            let names: Vec<(String, f64)> =
                names.iter().zip([1.5, -2.0, 3e-2]).map(|(name, value)| (name.to_string(), value)).collect();
            assert_eq!(found, names, "{line}");
        };
        expect("X: 1.5 Y: -2 Z: 3e-2", ["X", "Y", "Z"]);
        expect("X:1.5\tY:-2\tZ:3e-2", ["X", "Y", "Z"]);
        expect("mx=1.5, my=-2, mz=3e-2", ["mx", "my", "mz"]);
        expect("Mag: X: 1.5 Y: -2 Z: 3e-2", ["Mag X", "Mag Y", "Mag Z"]);
        expect("Mag X: 1.5 Y: -2 Z: 3e-2", ["Mag X", "Mag Y", "Mag Z"]);
        expect("Mag: 1.5, -2, 3e-2", ["Mag[0]", "Mag[1]", "Mag[2]"]);
        expect("Mag (uT) [ 1.5, -2, 3e-2 ]", ["Mag (uT)[0]", "Mag (uT)[1]", "Mag (uT)[2]"]);
        expect("Scaled. Mag (uT) [ 1.5, -2, 3e-2 ]", ["Mag (uT)[0]", "Mag (uT)[1]", "Mag (uT)[2]"]);
        expect("X: 1.5  Y: -2  Z: 3e-2  uT", ["X", "Y", "Z (uT)"]);
        expect("X: 1.5 uT, Y: -2 uT, Z: 3e-2 uT", ["X (uT)", "Y (uT)", "Z (uT)"]);
        expect("mag[0]: 1.5 mag[1]: -2 mag[2]: 3e-2", ["mag[0]", "mag[1]", "mag[2]"]);
        expect("{\"mag\":{\"x\":1.5,\"y\":-2,\"z\":3e-2}}", ["mag.x", "mag.y", "mag.z"]);
        expect("{'mx': 1.5, 'my': -2, 'mz': 3e-2}", ["mx", "my", "mz"]);
        expect("mag=(1.5, -2, 3e-2)", ["mag[0]", "mag[1]", "mag[2]"]);
        expect("{\"mag\":[1.5,-2,3e-2]}", ["mag[0]", "mag[1]", "mag[2]"]);
        assert_eq!(pairs("X: 1,5 Y: -2,5", true), [("X".to_string(), 1.5), ("Y".to_string(), -2.5)]);
    }

    #[test]
    fn what_has_no_labels_has_none() {
        for line in [
            "",
            "1,2,3",
            "Sensor found at 0x1E",
            "hello",
            "12:34:56",
            "{",
            "{]",
            "é: 1é",
            ":::1",
            "x 1 y 2",
            "t_s,mx_ut",
            "=",
        ] {
            let found = scan(line, false);
            assert!(found.is_empty() || line == "é: 1é", "{line}: {found:?}");
        }
        assert!(scan("Baud: 115200", false).len() == 1);
    }
}
