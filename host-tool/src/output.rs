//! Words and tables on standard output.

use std::io::Write;

/// One line on standard output. A closed pipe (`ironout … | head`) is no error.
pub fn line(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// `value` with `decimals` places, or a dash where it is unknown.
pub fn number(value: Option<f64>, decimals: usize) -> String {
    match value.filter(|value| value.is_finite()) {
        Some(value) => format!("{value:.decimals$}"),
        None => "-".to_string(),
    }
}

/// A JSON number, or null where it is unknown or not finite.
pub fn json_number(value: Option<f64>) -> serde_json::Value {
    value.filter(|value| value.is_finite()).map_or(serde_json::Value::Null, serde_json::Value::from)
}

/// Several lines on standard output, each with its end.
pub fn text(text: &str) {
    let _ = write!(std::io::stdout(), "{text}");
}
