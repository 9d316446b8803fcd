//! Progress on standard error, drawn by `indicatif`: only where that is a terminal and the work is long.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::{Duration, Instant};

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_millis(400);
/// Redraws a second.
const REDRAWS_HZ: u8 = 10;

/// A bar from 0 to `total`; it removes itself when dropped.
pub struct Progress {
    bar: ProgressBar,
    started: Instant,
}

impl Progress {
    /// A bar for `total` units of work; nothing is drawn unless `wanted` and standard error is a terminal.
    pub fn new(label: &'static str, total: u64, wanted: bool) -> Self {
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
        bar.set_style(style("{msg} [{bar:30}] {percent:>3} %  {eta} left"));
        bar.set_message(label);
        if !wanted || total == 0 {
            bar.finish();
        }
        Progress { bar, started: Instant::now() }
    }

    /// `done` of the total are done.
    pub fn at(&mut self, done: u64) {
        if self.bar.is_hidden() {
            if self.bar.is_finished() || self.started.elapsed() < PATIENCE {
                return;
            }
            self.bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(REDRAWS_HZ));
        }
        self.bar.set_position(done);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A sign of life for work whose length is not known: elapsed seconds, removed when dropped.
pub struct Working {
    bar: ProgressBar,
}

impl Working {
    /// Starts; nothing is drawn unless standard error is a terminal.
    pub fn new(label: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(REDRAWS_HZ));
        bar.set_style(style("{msg} {spinner} {elapsed}"));
        bar.set_message(label);
        bar.enable_steady_tick(PATIENCE);
        Working { bar }
    }
}

impl Drop for Working {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A sign of life for work without an end: a line that is said again, removed when dropped.
pub struct Counting {
    bar: ProgressBar,
}

impl Counting {
    /// Starts; nothing is drawn unless standard error is a terminal.
    pub fn new(label: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(REDRAWS_HZ));
        bar.set_style(style("{spinner} {msg}"));
        bar.set_message(label);
        bar.enable_steady_tick(PATIENCE);
        Counting { bar }
    }

    /// What stands there from now on.
    pub fn say(&self, text: &str) {
        if !self.bar.is_hidden() {
            self.bar.set_message(text.to_string());
        }
    }
}

impl Counting {
    /// A line on standard error that stays, whether it is a terminal or not.
    pub fn note(&self, text: &str) {
        self.bar.suspend(|| eprintln!("note: {text}"));
    }
}

impl Drop for Counting {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A template of the program's own, implausible wrong; the usual bar if it were.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("#>-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_templates_are_sound() {
        for template in
            ["{msg} [{bar:30}] {percent:>3} %  {eta} left", "{msg} {spinner} {elapsed}", "{spinner} {msg}"]
        {
            assert!(ProgressStyle::with_template(template).is_ok(), "{template}");
        }
    }

    #[test]
    fn short_work_and_work_that_nobody_watches_draw_nothing() {
        let mut short = Progress::new("reading", 10, true);
        short.at(5);
        assert!(short.bar.is_hidden());
        let mut unwanted = Progress::new("reading", 10, false);
        unwanted.started = Instant::now() - 2 * PATIENCE;
        unwanted.at(5);
        assert!(unwanted.bar.is_hidden());
    }
}
