//! The answer alone, and the answer with all figures.

use crate::cli::{Expected, FitArgs};
use crate::fit_words::{brief as head, details};
use crate::input::Log;
use ironout_analysis::Fitted;

/// Verdict, figures and next steps: at most a screen.
pub fn brief(arguments: &FitArgs, log: &Log, fitted: &Fitted, expected: &Expected) -> String {
    let mut lines = head::answer(arguments, log, fitted, expected);
    lines.push(String::new());
    lines.push("Standard errors and all figures: repeat the command with -v.".into());
    joined(&lines)
}

/// The same, then matrix, standard errors and every figure.
pub fn text(arguments: &FitArgs, log: &Log, fitted: &Fitted, expected: &Expected) -> String {
    let mut lines = head::answer(arguments, log, fitted, expected);
    lines.push(String::new());
    lines.extend(details::details(log, fitted, expected));
    joined(&lines)
}

fn joined(lines: &[String]) -> String {
    lines.iter().map(|line| format!("{line}\n")).collect()
}
