//! Text broken into lines.

/// Messages are at most this wide.
pub const WIDTH: usize = 110;

/// Breaks text into lines of at most `width` characters, each after `indent`.
pub fn wrap(text: &str, indent: &str, width: usize) -> Vec<String> {
    hang(text, indent, indent, width)
}

/// Units that stay on the line of their number.
const UNITS: [&str; 23] = [
    "%", "µT", "nT", "mG", "G", "T", "s", "ms", "min", "h", "Hz", "A", "V", "W", "°C", "m", "g", "rad/s",
    "m/s²", "MB", "σ", "×", "samples",
];

/// Words of a text; a number and its unit are one.
fn words(text: &str) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let bare = word.trim_end_matches([',', '.', ';', ':', ')']);
        match list.last_mut() {
            Some(before) if UNITS.contains(&bare) && before.ends_with(|c: char| c.is_ascii_digit()) => {
                *before += " ";
                *before += word;
            }
            _ => list.push(word.to_string()),
        }
    }
    list
}

/// The same with another indent from the second line on.
pub fn hang(text: &str, first: &str, rest: &str, width: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in words(text) {
        let indent = if lines.is_empty() { first } else { rest };
        let length = indent.chars().count() + line.chars().count() + 1 + word.chars().count();
        if !line.is_empty() && length > width {
            lines.push(format!("{indent}{line}"));
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(&word);
    }
    if !line.is_empty() {
        lines.push(format!("{}{line}", if lines.is_empty() { first } else { rest }));
    }
    lines
}

/// One line of at most `width` characters; what is cut off is marked.
pub fn shortened(text: &str, width: usize) -> String {
    match text.chars().count() {
        count if count > width => text.chars().take(width - 1).chain(['…']).collect(),
        _ => text.to_string(),
    }
}

/// A message of any length for a terminal: its lines broken at `width` and indented from the second on. What begins with
/// four blanks is to be pasted, and stays on one line.
pub fn message(text: &str, width: usize) -> String {
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        let first = if lines.is_empty() { "" } else { "  " };
        if line.starts_with("    ") || line.chars().count() + first.len() <= width {
            lines.push(if line.starts_with("    ") { line.to_string() } else { format!("{first}{line}") });
        } else {
            lines.extend(hang(line, first, "  ", width));
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_and_its_unit_stay_on_one_line() {
        let text = "gains within 20 %, 0.25 µT of 50 µT";
        for width in 8..40 {
            let lines = wrap(text, "", width);
            assert!(lines.iter().all(|line| !line.starts_with(['%', 'µ'])), "{lines:?}");
            assert_eq!(lines.join(" "), text);
        }
    }

    #[test]
    fn long_messages_are_broken_and_commands_are_not() {
        let command = format!("    --map {}", "mx_ut=a,".repeat(20));
        let told = message(&format!("{}\n{command}\nshort", "word ".repeat(60).trim()), 80);
        let lines: Vec<&str> = told.lines().collect();
        assert!(lines.iter().all(|line| line.starts_with("    ") || line.chars().count() <= 80), "{told}");
        assert!(lines.contains(&command.as_str()) && lines.last() == Some(&"  short"), "{told}");
        assert_eq!(told.split_whitespace().filter(|word| *word == "word").count(), 60);
        assert_eq!(message("as it is", 80), "as it is");
    }
}
