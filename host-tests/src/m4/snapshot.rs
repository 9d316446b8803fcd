//! The stored figures of the last accepted run, and whether a new run is worse.

use super::Measured;
use std::path::PathBuf;

/// A figure may grow by this much before it counts as worse.
pub const TOLERANCE: f64 = 0.03;

/// Where the snapshot lies.
pub fn path() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/m4.txt"))
}

/// The figures of a table in the form of [`Measured::table`].
pub fn parse(text: &str) -> Vec<(String, u64)> {
    text.lines()
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            Some((words.next()?.to_owned(), words.next()?.parse().ok()?))
        })
        .collect()
}

/// What became worse than `stored`, one sentence each. Only our own figures are held.
pub fn worse(measured: &Measured, stored: &[(String, u64)]) -> Vec<String> {
    measured
        .figures
        .iter()
        .filter(|f| f.ours)
        .filter_map(|f| {
            let Some((_, old)) = stored.iter().find(|(key, _)| key == f.key) else {
                return Some(format!("{} is {} and not in the snapshot", f.key, f.value));
            };
            let most = *old as f64 * (1.0 + TOLERANCE);
            (f.value as f64 > most).then(|| {
                format!(
                    "{} grew from {old} to {} ({:+.1} %)",
                    f.key,
                    f.value,
                    (f.value as f64 / *old as f64 - 1.0) * 100.0
                )
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::m4::Figure;

    fn measured(value: u64) -> Measured {
        Measured { figures: vec![Figure { key: "push", value, limit: None, ours: true }] }
    }

    #[test]
    fn more_than_three_percent_is_worse() {
        let stored = parse(&measured(1000).table());
        assert_eq!(stored, [("push".to_owned(), 1000)]);
        assert!(worse(&measured(1030), &stored).is_empty());
        assert_eq!(worse(&measured(1031), &stored), ["push grew from 1000 to 1031 (+3.1 %)"]);
        assert_eq!(worse(&measured(7), &[]).len(), 1);
    }
}
