//! Cells of a column that are missing: between far cells nobody knows what the column did, so those samples say nothing of it.

use crate::bounds::{LEAST_LEFT, USUAL_DISTANCES};
use crate::samples::samples::Samples;
use crate::table::Table;

/// The samples without those in gaps of columns; `None` where there are none to leave out.
pub fn without_gaps(samples: &Samples, table: &Table) -> Option<Samples> {
    let mut in_gap = vec![false; table.rows()];
    for column in samples.columns.iter().filter(|column| column.problem.is_none()) {
        let Some(named) = table.covariates.iter().find(|named| named.name == column.name) else { continue };
        let known: Vec<usize> =
            named.values.iter().enumerate().filter(|(_, v)| v.is_finite()).map(|(row, _)| row).collect();
        if known.len() == table.rows() || known.len() < 2 {
            continue;
        }
        let mut distances: Vec<usize> = known.windows(2).map(|pair| pair[1] - pair[0]).collect();
        distances.sort_unstable();
        let usual = distances[distances.len() / 2];
        let mut ends = vec![(0, known[0])];
        ends.extend(known.windows(2).map(|pair| (pair[0] + 1, pair[1])));
        ends.push((known[known.len() - 1] + 1, table.rows()));
        for (from, to) in ends {
            if to - from >= USUAL_DISTANCES * usual {
                in_gap[from..to].fill(true);
            }
        }
    }
    let rows: Vec<usize> = samples.row.iter().copied().filter(|&row| !in_gap[row]).collect();
    let enough = rows.len() as f64 >= LEAST_LEFT * samples.len() as f64;
    (rows.len() < samples.len() && enough).then(|| samples.of_these(table, rows))
}
