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

/// A sign of life for work whose length is not known: elapsed seconds, from a thread of its own, removed when dropped.
pub struct Working {
    thread: Option<(std::sync::mpsc::Sender<()>, std::thread::JoinHandle<()>)>,
}

impl Working {
    /// Starts; nothing is drawn unless standard error is a terminal and the work takes a while.
    pub fn new(label: &'static str) -> Self {
        if !std::io::stderr().is_terminal() {
            return Working { thread: None };
        }
        let (stop, stopped) = std::sync::mpsc::channel();
        let thread = std::thread::spawn(move || draw(label, &stopped));
        Working { thread: Some((stop, thread)) }
    }
}

fn draw(label: &str, stopped: &std::sync::mpsc::Receiver<()>) {
    use std::sync::mpsc::RecvTimeoutError::Timeout;
    const BLOCK: usize = 8;
    let started = Instant::now();
    let mut wait = PATIENCE;
    let mut drawn = false;
    for step in 0_usize.. {
        if stopped.recv_timeout(wait) != Err(Timeout) {
            break;
        }
        wait = REDRAW;
        drawn = true;
        let turn = 2 * (WIDTH - BLOCK);
        let at = (turn / 2).abs_diff(step % turn);
        let bar = format!("{}{}{}", "-".repeat(at), "#".repeat(BLOCK), "-".repeat(WIDTH - BLOCK - at));
        let _ = write!(std::io::stderr(), "\r{label} [{bar}] {:4.0} s", started.elapsed().as_secs_f64());
    }
    if drawn {
        let _ = write!(std::io::stderr(), "\r{}\r", " ".repeat(WIDTH + label.len() + 12));
    }
}

impl Drop for Working {
    fn drop(&mut self) {
        if let Some((stop, thread)) = self.thread.take() {
            drop(stop);
            // A thread that only draws has nothing to say.
            let _ = thread.join();
        }
    }
}
