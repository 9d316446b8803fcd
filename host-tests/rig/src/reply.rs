//! What a board says on its console, line by line.

use std::fmt;

/// What a command was answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reply {
    /// The `+ ` lines, without that mark.
    pub info: Vec<String>,
    /// The text after `ok`, or the refusal.
    pub outcome: Result<String, Refusal>,
}

/// An `err` line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The code: `unknown`, `usage`, `long`, `busy`, `state`, `refused`, `sensor` or `store`.
    pub code: String,
    /// The words after it.
    pub text: String,
}

impl Reply {
    /// Whether the answer was `ok`.
    pub fn is_ok(&self) -> bool {
        self.outcome.is_ok()
    }

    /// The code of the refusal, if it was one.
    pub fn code(&self) -> Option<&str> {
        self.outcome.as_ref().err().map(|refusal| refusal.code.as_str())
    }

    /// The first value named `key` of the reply, in the closing line or in the lines before it.
    pub fn value(&self, key: &str) -> Option<&str> {
        let closing = match &self.outcome {
            Ok(text) => text,
            Err(refusal) => &refusal.text,
        };
        std::iter::once(closing)
            .chain(&self.info)
            .flat_map(|line| line.split(' '))
            .find_map(|word| word.strip_prefix(key)?.strip_prefix('='))
    }

    /// All values named `key`, in their order: the rows of a matrix.
    pub fn values<'a>(&'a self, key: &'a str) -> impl Iterator<Item = &'a str> {
        self.info
            .iter()
            .flat_map(|line| line.split(' '))
            .filter_map(move |word| word.strip_prefix(key)?.strip_prefix('='))
    }
}

impl fmt::Display for Reply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for line in &self.info {
            writeln!(f, "+ {line}")?;
        }
        match &self.outcome {
            Ok(text) if text.is_empty() => f.write_str("ok"),
            Ok(text) => write!(f, "ok {text}"),
            Err(refusal) => write!(f, "err {} {}", refusal.code, refusal.text),
        }
    }
}

/// What a line is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line<'a> {
    /// Of a stream: nobody asked for it.
    Streamed,
    /// A `+ ` line, without that mark.
    Info(&'a str),
    /// The end of a reply: the text after `ok`, or the refusal.
    Closing(Result<String, Refusal>),
    /// Nothing that the contract knows.
    Unknown,
}

impl<'a> Line<'a> {
    /// What `line`, without its end, is.
    pub fn of(line: &'a str) -> Self {
        if ["R,", "C,", "H,", "L,", "Raw:", "Cal1:", "Cal2:"].iter().any(|mark| line.starts_with(mark)) {
            Line::Streamed
        } else if let Some(text) = line.strip_prefix("+ ") {
            Line::Info(text)
        } else if let Some(text) = after(line, "ok") {
            Line::Closing(Ok(text.to_owned()))
        } else if let Some(text) = after(line, "err") {
            let (code, text) = text.split_once(' ').unwrap_or((text, ""));
            Line::Closing(Err(Refusal { code: code.to_owned(), text: text.to_owned() }))
        } else {
            Line::Unknown
        }
    }
}

/// The text after the word `word` at the beginning of `line`.
fn after<'a>(line: &'a str, word: &str) -> Option<&'a str> {
    let rest = line.strip_prefix(word)?;
    if rest.is_empty() { Some(rest) } else { rest.strip_prefix(' ') }
}
