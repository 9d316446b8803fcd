//! A progress bar on standard error, shown only where that is a terminal and the work is long.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_millis(400);
/// Between two redraws.
const REDRAW: Duration = Duration::from_millis(100);
const WIDTH: usize = 30;

/// A bar from 0 to `total`; it removes itself when dropped.
pub struct Progress {
    label: &'static str,
    total: u64,
    started: Instant,
    drawn: Option<Instant>,
    enabled: bool,
}

impl Progress {
    /// A bar for `total` units of work; nothing is drawn unless `wanted` and standard error is a terminal.
    pub fn new(label: &'static str, total: u64, wanted: bool) -> Self {
        let enabled = wanted && total > 0 && std::io::stderr().is_terminal();
        Progress { label, total, started: Instant::now(), drawn: None, enabled }
    }

    /// `done` of the total are done.
    pub fn at(&mut self, done: u64) {
        if !self.enabled || self.started.elapsed() < PATIENCE {
            return;
        }
        if self.drawn.is_some_and(|drawn| drawn.elapsed() < REDRAW) {
            return;
        }
        self.drawn = Some(Instant::now());
        let fraction = (done as f64 / self.total as f64).clamp(0.0, 1.0);
        let filled = (fraction * WIDTH as f64) as usize;
        let _ = write!(
            std::io::stderr(),
            "\r{} [{}{}] {:3.0} %",
            self.label,
            "#".repeat(filled),
            "-".repeat(WIDTH - filled),
            fraction * 100.0
        );
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.drawn.is_some() {
            // A bar that cannot be cleared is no reason to fail.
            let _ = write!(std::io::stderr(), "\r{}\r", " ".repeat(WIDTH + self.label.len() + 10));
        }
    }
}
