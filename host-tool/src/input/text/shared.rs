//! Rows that share a time: a clock of whole seconds under a faster sensor. They share out the time until the next stamp.

/// Rows per stamp, on average, from which stamps are shared: fewer are rows that met by chance.
const MIN_ROWS_PER_STAMP: usize = 2;

/// From this many usual steps on there is a gap between two stamps, and rows do not spread into it.
const GAP_STEPS: f64 = 2.0;

/// Gives each row of a stamp a time of its own: the middle row of a stamp has its time, the others lie between. Gives the usual time
/// per row, s; `None`, and nothing changed, where rows have times of their own.
pub fn share_out(times: &mut [f64]) -> Option<f64> {
    // Stamp, first row, rows.
    let mut groups: Vec<(f64, usize, usize)> = Vec::new();
    for (row, time) in times.iter().enumerate() {
        match groups.last_mut() {
            Some((stamp, _, count)) if stamp == time => *count += 1,
            _ => groups.push((*time, row, 1)),
        }
    }
    if groups.len() < 2 || times.len() < MIN_ROWS_PER_STAMP * groups.len() {
        return None;
    }
    // The first and the last stamp are cut off by the ends of the log: their middle is not that of their time.
    let inner = groups.get(1..groups.len() - 1).filter(|inner| inner.len() > 1).unwrap_or(&groups);
    let nodes: Vec<(f64, f64)> = inner
        .iter()
        .map(|(stamp, from, count)| (*from as f64 + (*count as f64 - 1.0) / 2.0, *stamp))
        .collect();
    let mut steps: Vec<f64> =
        nodes.windows(2).map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)).collect();
    steps.sort_by(f64::total_cmp);
    let usual = steps.get(steps.len() / 2).copied()?;
    // Without gaps, all rows together know the step better.
    let ((first, from_s), (last, to_s)) = (*nodes.first()?, *nodes.last()?);
    let mean = (to_s - from_s) / (last - first);
    let step_s = if steps.iter().any(|step| *step > GAP_STEPS * usual) { usual } else { mean };
    let mut node = 0;
    for (row, time) in times.iter_mut().enumerate() {
        let row = row as f64;
        while nodes.get(node).is_some_and(|next| next.0 <= row) {
            node += 1;
        }
        let before = node.checked_sub(1).and_then(|last| nodes.get(last));
        *time = match (before, nodes.get(node)) {
            (Some((a, from_s)), Some((b, to_s))) => {
                let between = (to_s - from_s) / (b - a);
                match between > GAP_STEPS * step_s {
                    false => from_s + (row - a) * between,
                    // On this side of the gap, or on the other.
                    true if row - a < b - row => from_s + (row - a) * step_s,
                    true => to_s - (b - row) * step_s,
                }
            }
            (Some((a, from_s)), None) => from_s + (row - a) * step_s,
            (None, Some((b, to_s))) => to_s - (b - row) * step_s,
            (None, None) => *time,
        };
    }
    Some(step_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_one_second_share_it_out() {
        for (rate, first) in [(8, 3), (4, 4), (50, 1), (3, 2)] {
            let stamps =
                (0..10).flat_map(|s| std::iter::repeat_n(f64::from(s), if s == 0 { first } else { rate }));
            let mut times: Vec<f64> = stamps.collect();
            let step = share_out(&mut times).expect("shared");
            assert!((step * rate as f64 - 1.0).abs() < 1e-9, "{step}");
            assert!(times.windows(2).all(|w| (w[1] - w[0] - step).abs() < 1e-9), "{times:?}");
        }
        // Rounded to the nearest even digit, and a pause.
        let mut rounded: Vec<f64> = (0..60).map(|i| (f64::from(i) * 0.25).round_ties_even()).collect();
        let step = share_out(&mut rounded).expect("shared");
        assert!((step - 0.25).abs() < 0.01 && rounded.is_sorted(), "{step}");
        let mut paused: Vec<f64> =
            (0..80).map(|i| f64::from(i / 8) + if i < 40 { 0.0 } else { 100.0 }).collect();
        assert_eq!(share_out(&mut paused), Some(0.125));
        assert!(
            paused.is_sorted() && paused.windows(2).filter(|w| w[1] - w[0] > 0.2).count() == 1,
            "{paused:?}"
        );
        let mut own: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.02).collect();
        assert_eq!(share_out(&mut own), None);
        assert_eq!(share_out(&mut [1.0; 50]), None);
        assert_eq!(share_out(&mut []), None);
    }
}
