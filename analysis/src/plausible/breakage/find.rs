//! Which repairs a log needs.

use super::evidence::{Breakage, MIN_ROWS};
use super::rows::joined;
use super::{codes, maps, range};

/// Kinds of breakage that one log is looked through for.
const MAX_KINDS: usize = 4;

/// What broke these numbers, each kind with the repair that undoes it, in the order in which they are to be made: each was found in
/// the numbers that the repairs before it leave. Nothing for numbers that are right, or that are too few or too rough to tell.
pub fn find(numbers: [&[f64]; 3]) -> Vec<Breakage> {
    let rows = numbers[0].len();
    if rows < MIN_ROWS || numbers.iter().any(|axis| axis.len() != rows || axis.iter().any(|v| !v.is_finite()))
    {
        return Vec::new();
    }
    let mut found = Vec::new();
    // Rows that are left, and their numbers: copied only once something is wrong.
    let mut left: Option<(Vec<usize>, [Vec<f64>; 3])> = None;
    for _ in 0..MAX_KINDS {
        let now = match &left {
            Some((_, own)) => [own[0].as_slice(), own[1].as_slice(), own[2].as_slice()],
            None => numbers,
        };
        let Some(next) = one(now) else { break };
        let (mut kept, mut own) =
            left.take().unwrap_or_else(|| ((0..rows).collect(), numbers.map(<[f64]>::to_vec)));
        let mut in_log = next.clone();
        in_log.first_row = kept.get(next.first_row).copied().unwrap_or(0);
        next.repair.make(&mut own, &mut kept);
        found.push(in_log);
        if kept.len() < MIN_ROWS {
            break;
        }
        left = Some((kept, own));
    }
    found
}

/// The repair that removes most of the path.
fn one(numbers: [&[f64]; 3]) -> Option<Breakage> {
    let maps: Vec<maps::OfAxis> = (0..3).filter_map(|axis| maps::best(numbers[axis], axis)).collect();
    let gain: f64 = maps.iter().map(maps::OfAxis::gain).sum();
    // A value that means a failed reading looks like a wrap on an axis whose readings lie near an end of the range, and noise about
    // the end of a range gives the same value twice: the repair that removes more is right.
    if let Some((code, _)) = codes::best(numbers).filter(|(_, of_code)| *of_code > gain) {
        return Some(code);
    }
    let mut list: Vec<Breakage> = maps.into_iter().map(maps::OfAxis::breakage).collect();
    if list.is_empty() {
        return range::find(numbers);
    }
    joined(&mut list, numbers);
    list.into_iter().max_by(|a, b| a.rows.cmp(&b.rows))
}
