//! Colour for a terminal: a view of the words, which themselves have none.

use anstyle::{AnsiColor, Style};

const GOOD: Style = AnsiColor::Green.on_default().bold();
const CARE: Style = AnsiColor::Yellow.on_default().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();
const COMMAND: Style = AnsiColor::Cyan.on_default();
const LABEL: Style = Style::new().bold();

/// The words that begin a line and say how it went.
const VERDICTS: [(&str, Style); 12] = [
    ("ACCEPTED", GOOD),
    ("COMPLETE", GOOD),
    ("FOUND", GOOD),
    ("GOOD", GOOD),
    ("CONFOUNDED", CARE),
    ("UNEXPLAINED", CARE),
    ("FIELD", CARE),
    ("UNKNOWN", CARE),
    ("REFUSED", BAD),
    ("UNDETERMINED", BAD),
    ("WORSE", BAD),
    ("error", BAD),
];

fn painted(style: Style, text: &str) -> String {
    format!("{style}{text}{style:#}")
}

/// One line in colour: its verdict, a command to paste, or a heading that stands alone.
fn line(text: &str, after_blank: bool) -> String {
    if let Some((word, style)) = VERDICTS.iter().find(|(word, _)| {
        let rest = text.strip_prefix(word);
        rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric()))
    }) {
        return format!("{}{}", painted(*style, word), &text[word.len()..]);
    }
    if text.starts_with("    ironout ") {
        return painted(COMMAND, text);
    }
    if after_blank && !text.is_empty() && !text.starts_with(' ') {
        return painted(LABEL, text);
    }
    text.to_string()
}

/// Text in colour. Who prints it takes the colour out again if the terminal shows none.
pub fn text(text: &str) -> String {
    let mut blank = false;
    let mut out = String::with_capacity(text.len());
    for (index, part) in text.split('\n').enumerate() {
        if index > 0 {
            out.push('\n');
        }
        out.push_str(&line(part, blank));
        blank = part.is_empty();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_changes_no_word() {
        let plain =
            "FOUND: offset proportional to current.\n\nNext steps\n    ironout fit a.csv\n  FOUNDRY\n";
        let painted = text(plain);
        assert!(painted.len() > plain.len() && painted.contains("\u{1b}["));
        assert_eq!(anstream::adapter::strip_str(&painted).to_string(), plain);
        assert!(painted.contains("\n  FOUNDRY\n"), "{painted:?}");
    }
}
