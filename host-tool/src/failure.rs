//! The one error type of the tool: what went wrong, where, and what to do about it.

use ironout_analysis::similar;
use serde::Serialize;
use std::fmt;
use std::path::Path;

/// Exit status of a command that did its work.
pub const EXIT_OK: u8 = 0;
/// Exit status when the data do not support the answer asked for.
pub const EXIT_REFUSED: u8 = 1;
/// Exit status of bad input or usage.
pub const EXIT_USAGE: u8 = 2;

/// One answer to a [`Question`]: the options of the command line that state it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// The answer in words.
    pub label: String,
    /// Each option with its value, as in `--map` and `mx_ut=MagX[mG]`.
    pub options: Vec<(String, String)>,
}

/// What a reader has to ask, in a form that a page shows as fields.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Question {
    /// The question in one sentence.
    pub text: String,
    /// Answers to choose from.
    pub choices: Vec<Choice>,
    /// Headers of the log's columns, if the question is which of them are the magnetometer.
    pub columns: Vec<String>,
    /// Whether the scale of counts (`--ut-per-count`) is needed.
    pub needs_scale: bool,
}

/// A failure with its place. `message` says what was found, what was expected and what to do.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// Exit status: [`EXIT_REFUSED`] or [`EXIT_USAGE`].
    pub exit: u8,
    /// The file at fault.
    pub file: Option<String>,
    /// The line in that file, from 1.
    pub line: Option<u64>,
    /// The column's name, or its number from 1 where it has no name.
    pub column: Option<String>,
    /// What was found, what was expected, and the remedy.
    pub message: String,
    /// The question behind it, if an answer is all that is needed.
    pub question: Option<Box<Question>>,
}

impl Failure {
    /// Bad input or usage (exit status 2).
    pub fn usage(message: impl Into<String>) -> Self {
        Failure {
            exit: EXIT_USAGE,
            file: None,
            line: None,
            column: None,
            message: message.into(),
            question: None,
        }
    }

    /// The data do not support it (exit status 1).
    pub fn refused(message: impl Into<String>) -> Self {
        Failure { exit: EXIT_REFUSED, ..Failure::usage(message) }
    }

    /// A file that should hold a calibration.
    pub fn not_a_calibration(why: &str) -> Self {
        let end = if why.ends_with('?') { "" } else { "." };
        Failure::usage(format!(
            "this is not a valid ironout calibration: {why}{end} Create one with: ironout fit LOG -o CAL.json"
        ))
    }

    /// Names the file.
    pub fn in_file(mut self, path: &Path) -> Self {
        self.file = Some(path.display().to_string());
        self
    }

    /// Names the line (from 1).
    pub fn at_line(mut self, line: u64) -> Self {
        self.line = Some(line);
        self
    }

    /// Names the column.
    pub fn at_column(mut self, column: impl Into<String>) -> Self {
        self.column = Some(column.into());
        self
    }

    /// Adds the question that an answer would settle.
    pub fn asking(mut self, question: Question) -> Self {
        self.question = Some(Box::new(question));
        self
    }

    /// A file that could not be opened, read or written.
    pub fn io(action: &str, path: &Path, error: &std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::NotFound {
            let meant = near(path).map_or(String::new(), |meant| format!(". {meant}"));
            return Failure::usage(format!("no such file or folder{meant}")).in_file(path);
        }
        let remedy = match error.kind() {
            std::io::ErrorKind::PermissionDenied => "permission denied. Check the file's permissions",
            std::io::ErrorKind::IsADirectory => "this is a folder. Name a file",
            _ => "",
        };
        let why = if remedy.is_empty() { error.to_string() } else { remedy.to_string() };
        Failure::usage(format!("cannot {action}: {why}")).in_file(path)
    }

    /// The error object of `--json`.
    pub fn to_json(&self) -> serde_json::Value {
        let mut error = serde_json::json!({
            "file": self.file, "line": self.line, "column": self.column, "message": self.message,
        });
        if let (Some(question), Some(object)) = (&self.question, error.as_object_mut()) {
            object.insert("question".into(), serde_json::json!(question));
        }
        serde_json::json!({ "error": error })
    }
}

/// `Did you mean …?` with names of the same folder.
fn near(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let names: Vec<String> = std::fs::read_dir(folder)
        .ok()?
        .filter_map(|entry| Some(entry.ok()?.file_name().to_str()?.to_string()))
        .take(10_000)
        .collect();
    similar::did_you_mean(path.file_name()?.to_str()?, names.iter().map(String::as_str))
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{file}")?;
            if let Some(line) = self.line {
                write!(f, ":{line}")?;
            }
            write!(f, ": ")?;
        }
        if let Some(column) = &self.column {
            write!(f, "column {column}: ")?;
        }
        write!(f, "{}", self.message)
    }
}

impl std::error::Error for Failure {}

/// The result of everything in this tool.
pub type Outcome<T> = Result<T, Failure>;
