//! The samples at which every column is known. A short gap between two cells is filled; over a long one nobody knows the
//! column, and a column without gaps would explain those samples where the cause cannot: all candidates are compared on the
//! samples that all of them have.

use crate::samples::faults::{DataFault, FaultKind};
use crate::samples::samples::Samples;
use crate::table::Table;

/// A gap is long that is so many times as long as the usual distance between two known cells ...
const LONG: usize = 3;
/// ... and longer than this, rows.
const SHORT: usize = 4;
/// Where more than this share of the samples would go, the column with the longest gaps goes instead.
const MOST_LEFT_OUT: f64 = 0.4;

/// The long runs of missing cells, each as its first row and the one after its last.
fn long_gaps(values: &[f64]) -> Vec<(usize, usize)> {
    let known: Vec<usize> = (0..values.len()).filter(|row| values[*row].is_finite()).collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else { return Vec::new() };
    let mut steps: Vec<usize> = known.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    let usual = if steps.is_empty() { 1 } else { *steps.select_nth_unstable(middle).1 };
    let longest = SHORT.max(LONG * usual);
    let ends = [(0, first), (last + 1, values.len())];
    let inner = known.windows(2).map(|pair| (pair[0] + 1, pair[1]));
    let mut gaps: Vec<(usize, usize)> = inner.chain(ends).filter(|(from, to)| to - from > longest).collect();
    gaps.sort_unstable();
    gaps
}

impl Samples {
    /// The samples without those at which a column that is `wanted` is unknown, and what was left out; `None` where nothing
    /// is.
    pub fn with_all_known(
        &self,
        table: &Table,
        wanted: impl Fn(&str) -> bool,
    ) -> Option<(Samples, Vec<DataFault>)> {
        let usable = |name: &str| self.columns.iter().any(|own| own.name == name && own.problem.is_none());
        let named = table.covariates.iter().filter(|named| wanted(named.name) && usable(named.name));
        let mut gaps: Vec<(&str, Vec<bool>)> = Vec::new();
        for column in named {
            let found = long_gaps(column.values);
            if found.is_empty() {
                continue;
            }
            let mut missing = vec![false; table.rows()];
            found.iter().for_each(|(from, to)| missing[*from..*to].fill(true));
            gaps.push((column.name, missing));
        }
        let lost = |missing: &[bool]| self.row.iter().filter(|row| missing[**row]).count();
        gaps.retain(|(_, missing)| lost(missing) > 0);
        if gaps.is_empty() {
            return None;
        }
        let any = |gaps: &[(&str, Vec<bool>)]| -> Vec<bool> {
            (0..table.rows()).map(|row| gaps.iter().any(|(_, missing)| missing[row])).collect()
        };
        let mut refused = Vec::new();
        let mut left_out = any(&gaps);
        while lost(&left_out) as f64 > MOST_LEFT_OUT * self.len() as f64 {
            let worst = gaps.iter().enumerate().max_by_key(|(_, (_, missing))| lost(missing))?.0;
            let (name, missing) = gaps.remove(worst);
            refused.push((name, lost(&missing)));
            left_out = any(&gaps);
        }
        let row: Vec<usize> = self.row.iter().copied().filter(|row| !left_out[*row]).collect();
        let mut common = Samples::of_rows(table, row, self.stride, self.axes);
        for (name, missing) in refused {
            let problem =
                format!("{name} is missing for long periods, in {missing} of {} samples", self.len());
            if let Some(column) = common.columns.iter_mut().find(|own| own.name == name) {
                column.problem = Some(problem);
            }
        }
        let fault = |(name, missing): &(&str, Vec<bool>)| {
            let rows: Vec<usize> = self.row.iter().copied().filter(|row| missing[*row]).collect();
            let at = |row: Option<&usize>| Some(table.time_s?[*row?]);
            DataFault {
                kind: FaultKind::Gap,
                from_s: at(rows.first()),
                to_s: at(rows.last()),
                samples: rows.len(),
                columns: vec![(*name).to_string()],
            }
        };
        let faults = gaps.iter().map(fault).collect();
        Some((common, faults))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nan(values: &mut [f64], from: usize, to: usize) {
        values[from..to].fill(f64::NAN);
    }

    #[test]
    fn a_gap_is_long_against_the_usual_distance_of_the_cells() {
        let mut values: Vec<f64> = (0..100).map(f64::from).collect();
        nan(&mut values, 10, 13);
        assert!(long_gaps(&values).is_empty(), "three cells");
        nan(&mut values, 40, 60);
        nan(&mut values, 90, 100);
        assert_eq!(long_gaps(&values), [(40, 60), (90, 100)]);
        // A slow sensor in a fast log: every tenth cell.
        let slow: Vec<f64> =
            (0..200).map(|row| if row % 10 == 0 { f64::from(row) } else { f64::NAN }).collect();
        assert!(long_gaps(&slow).is_empty());
        assert!(long_gaps(&[f64::NAN; 9]).is_empty());
    }

    #[test]
    fn candidates_have_their_samples_in_common() {
        let n = 400;
        let axis =
            |phase: f64| -> Vec<f64> { (0..n).map(|i| 40.0 * (0.37 * f64::from(i) + phase).sin()).collect() };
        let (x, y, z) = (axis(0.0), axis(1.0), axis(2.0));
        let time: Vec<f64> = (0..n).map(|i| 0.02 * f64::from(i)).collect();
        let whole: Vec<f64> = (0..n).map(f64::from).collect();
        let (mut some, mut few) = (whole.clone(), whole.clone());
        nan(&mut some, 100, 150);
        nan(&mut few, 100, 290);
        let columns = [
            ("t_s", &time),
            ("mx_ut", &x),
            ("my_ut", &y),
            ("mz_ut", &z),
            ("a", &whole),
            ("b", &some),
            ("c", &few),
        ];
        let table = Table::from_columns(columns.map(|(name, values)| (name, values.as_slice()))).unwrap();
        let samples = Samples::take(&table, &[false; 400], [true; 3]);
        let (common, faults) = samples.with_all_known(&table, |_| true).unwrap();
        assert_eq!(common.len(), 350, "without the gap of b; c has too little");
        assert!(common.row.iter().all(|row| !(100..150).contains(row)));
        let problem =
            |name: &str| common.columns.iter().find(|own| own.name == name).unwrap().problem.clone();
        assert_eq!((problem("a"), problem("b")), (None, None));
        assert_eq!(problem("c").unwrap(), "c is missing for long periods, in 190 of 400 samples");
        assert_eq!(
            (faults.len(), faults[0].samples, faults[0].columns.as_slice()),
            (1, 50, ["b".to_string()].as_slice())
        );
        assert!(samples.with_all_known(&table, |name| name == "a").is_none());
    }
}
