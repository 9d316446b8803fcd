//! The report of a fit or a diagnosis as lines of text.

use crate::wrap::{hang, shortened, wrap};
use ironout_analysis::report::{Next, Report};

/// How wide lines and the labels of figures are.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Lines have at most so many characters.
    pub width: usize,
    /// Labels of figures have so many.
    pub label: usize,
}

/// The report, line by line; commands are never broken.
pub fn lines(report: &Report, layout: Layout) -> Vec<String> {
    let Layout { width, label } = layout;
    let mut out: Vec<String> = report.verdict.iter().flat_map(|text| wrap(text, "", width)).collect();
    out.extend(report.reasons.iter().flat_map(|reason| hang(reason, "  ", "    ", width)));
    out.push(String::new());
    for (index, figure) in report.figures.iter().enumerate() {
        let line = format!("  {:<label$} {}", figure.label, figure.text);
        // The first names the log: a long path must not cut the counts.
        out.push(if index == 0 { line } else { shortened(&line, width) });
    }
    if !report.remarks.is_empty() {
        out.push(String::new());
        out.extend(report.remarks.iter().flat_map(|text| wrap(text, "", width)));
    }
    if !report.next.is_empty() {
        out.push(String::new());
        out.push("Next steps".into());
    }
    for next in &report.next {
        match next {
            Next::Say(text) => out.extend(wrap(text, "  ", width)),
            Next::Command(text) => out.push(format!("    {text}")),
        }
    }
    out
}
