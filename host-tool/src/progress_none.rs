//! Progress where there is no terminal: none.

/// A bar that nobody sees.
pub struct Progress;

impl Progress {
    /// Nothing is drawn.
    pub fn new(_label: &'static str, _total: u64, _wanted: bool) -> Self {
        Progress
    }

    /// Nothing is drawn.
    pub fn at(&mut self, _done: u64) {}
}
