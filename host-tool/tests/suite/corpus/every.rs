//! All formats of the corpus.

use super::sample::{Row, Sample};
use super::{apps, boards, programs, tables};

/// Every format.
pub fn all(rows: &[Row]) -> Vec<Sample> {
    [tables::samples(rows), boards::samples(rows), apps::samples(rows), programs::samples(rows)]
        .into_iter()
        .flatten()
        .collect()
}
