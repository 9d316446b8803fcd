//! How much a study has looked at. What a search may cost is counted in work and not in seconds: the answer is the same on
//! every machine, however busy.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Work done on a set of samples and on its copies.
#[derive(Debug, Clone, Default)]
pub struct Work(Arc<AtomicU64>);

impl Work {
    /// Counts some more.
    pub fn add(&self, units: usize) {
        self.0.fetch_add(units as u64, Ordering::Relaxed);
    }

    /// What was counted so far.
    pub fn spent(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::Work;

    #[test]
    fn copies_count_together() {
        let work = Work::default();
        let copy = work.clone();
        work.add(3);
        copy.add(4);
        assert_eq!((work.spent(), copy.spent()), (7, 7));
    }
}
