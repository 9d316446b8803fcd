//! All logs of the frozen set, diagnosed on two threads.

use crate::frozen::entry::Entry;
use crate::frozen::row::Row;
use crate::frozen::{files, generated};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Every log, in the order of the snapshot.
pub fn entries() -> Vec<Entry> {
    [generated::effects(), generated::truths(), generated::second(), generated::injected(), files::files()]
        .into_iter()
        .flatten()
        .collect()
}

/// Diagnoses the logs; `done` hears how many are done.
pub fn rows(entries: &[Entry], done: impl Fn(usize) + Sync) -> Vec<Row> {
    // The first of each set before the second: what a set draws at once is drawn on both threads.
    let mut seen = BTreeMap::new();
    let nth = |entry: &Entry| -> usize {
        let count = seen.entry(entry.set.clone()).or_insert(0);
        *count += 1;
        *count
    };
    let nths: Vec<usize> = entries.iter().map(nth).collect();
    let mut order: Vec<usize> = (0..entries.len()).collect();
    order.sort_by_key(|place| nths[*place]);
    let next = AtomicUsize::new(0);
    let rows: Mutex<Vec<(usize, Row)>> = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some(&place) = order.get(next.fetch_add(1, Ordering::Relaxed)) else { return };
                    let entry = &entries[place];
                    let row = match (entry.make)() {
                        Ok(made) => Row::of(&entry.set, &entry.log, &made),
                        Err(why) => Row::unread(&entry.set, &entry.log, &why),
                    };
                    let mut rows = rows.lock().unwrap_or_else(PoisonError::into_inner);
                    rows.push((place, row));
                    done(rows.len());
                }
            });
        }
    });
    let mut rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    rows.sort_by_key(|(place, _)| *place);
    rows.into_iter().map(|(_, row)| row).collect()
}
