//! Which samples of a stream stand in the order of time.

/// The largest set of samples whose times do not decrease: a clock that jumps once costs the samples of the jump, and not
/// all that come after it.
pub fn ordered(time_s: &[f64]) -> Vec<bool> {
    if time_s.is_sorted() {
        return vec![true; time_s.len()];
    }
    // Longest non-decreasing subsequence: ends[k] is the sample that ends the best run of k + 1 samples.
    let mut ends: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = Vec::with_capacity(time_s.len());
    for (index, time) in time_s.iter().enumerate() {
        let length = ends.partition_point(|&end| time_s.get(end).is_some_and(|last| last <= time));
        before.push(length.checked_sub(1).and_then(|last| ends.get(last).copied()));
        match ends.get_mut(length) {
            Some(end) => *end = index,
            None => ends.push(index),
        }
    }
    let mut stays = vec![false; time_s.len()];
    let mut at = ends.last().copied();
    while let Some(index) = at {
        if let Some(flag) = stays.get_mut(index) {
            *flag = true;
        }
        at = before.get(index).copied().flatten();
    }
    stays
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_costs_only_itself() {
        assert_eq!(ordered(&[0.0, 1.0, 1.0, 2.0]), [true; 4]);
        assert_eq!(ordered(&[0.0, 900.0, 1.0, 2.0, 0.5, 3.0]), [true, false, true, true, false, true]);
        assert_eq!(ordered(&[]), [false; 0]);
    }
}
