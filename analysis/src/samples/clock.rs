//! Stamps of arrival: a row that is stamped when it arrives was measured on the even grid behind it.

/// Shorter logs are left as they are.
const FEWEST: usize = 100;
/// The grid is even over so many rows on either side; over more the sensor's own rate may wander.
const AROUND: usize = 40;
/// Stamps that scatter by less than this share of a row are good enough.
const SCATTER: f64 = 0.1;
/// Means of so many rows that scatter by more than this many times what the rows themselves make them show that the rate
/// wanders. Stamps that wait for each other scatter alike, which alone makes one and a half of it.
const WANDERS: f64 = 2.0;
/// A stamp further off than so many rows is a gap.
const GAP_ROWS: f64 = 10.0;

/// The even times behind stamps that scatter about them; `None` where they do not scatter, or the log has gaps.
pub fn even(time_s: &[f64]) -> Option<Vec<f64>> {
    let n = time_s.len();
    if n < FEWEST {
        return None;
    }
    let row_s = (time_s[n - 1] - time_s[0]) / (n - 1) as f64;
    if !(row_s > 0.0) || time_s.windows(2).any(|pair| pair[1] - pair[0] > GAP_ROWS * row_s) {
        return None;
    }
    let off: Vec<f64> =
        time_s.iter().enumerate().map(|(row, t)| t - time_s[0] - row as f64 * row_s).collect();
    let mut sums = Vec::with_capacity(n + 1);
    sums.push(0.0);
    for value in &off {
        sums.push(sums[sums.len() - 1] + value);
    }
    let even: Vec<f64> = match steady(&off) {
        Some((first, slope)) => (0..n).map(|row| time_s[0] + first + row as f64 * (row_s + slope)).collect(),
        None => (0..n)
            .map(|row| {
                // As far on either side, so that a slope stays one.
                let side = AROUND.min(row).min(n - 1 - row);
                let mean = (sums[row + side + 1] - sums[row - side]) / (2 * side + 1) as f64;
                time_s[0] + row as f64 * row_s + mean
            })
            .collect(),
    };
    let square = even.iter().zip(time_s).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / n as f64;
    (square.sqrt() > SCATTER * row_s).then_some(even)
}

/// The line, from the first row by its slope, that stamps scatter about which are `off` an even step, where they do not wander
/// from it: the means of so many rows scatter as that of single ones makes them.
fn steady(off: &[f64]) -> Option<(f64, f64)> {
    let n = off.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = off.iter().sum::<f64>() / n;
    let sum: f64 = off.iter().enumerate().map(|(row, value)| (row as f64 - middle) * (value - mean)).sum();
    let slope = sum / (n * (n * n - 1.0) / 12.0);
    let first = mean - slope * middle;
    let rows = 2 * AROUND + 1;
    let (mut between, mut within, mut blocks) = (0.0, 0.0, 0.0);
    for (block, values) in off.chunks_exact(rows).enumerate() {
        let about: Vec<f64> = values
            .iter()
            .enumerate()
            .map(|(i, value)| value - first - slope * (block * rows + i) as f64)
            .collect();
        let own = about.iter().sum::<f64>() / rows as f64;
        between += own * own;
        within += about.iter().map(|value| (value - own).powi(2)).sum::<f64>() / (rows - 1) as f64;
        blocks += 1.0;
    }
    (blocks > 0.0 && between <= WANDERS * WANDERS * within / rows as f64).then_some((first, slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_stamps_lie_on_the_grid_again() {
        let grid = |row: u32| f64::from(row) * 0.01;
        let late = |row: u32| f64::from(row * 7919 % 101) / 101.0 * 0.015;
        let stamps: Vec<f64> = (0..3000).map(|row| grid(row) + late(row)).collect();
        let even = even(&stamps).expect("stamps that scatter");
        for row in 100..2900_u32 {
            let off = even[row as usize] - grid(row) - 0.0075;
            assert!(off.abs() < 0.0002, "row {row}: {off}");
        }
    }

    #[test]
    fn a_rate_that_wanders_is_followed() {
        let grid = |row: u32| f64::from(row) * 0.01 + 0.05 * (f64::from(row) / 400.0).sin();
        let late = |row: u32| f64::from(row * 7919 % 101) / 101.0 * 0.015;
        let stamps: Vec<f64> = (0..3000).map(|row| grid(row) + late(row)).collect();
        let even = even(&stamps).expect("stamps that scatter");
        for row in 100..2900_u32 {
            let off = even[row as usize] - grid(row) - 0.0075;
            assert!(off.abs() < 0.002, "row {row}: {off}");
        }
    }

    #[test]
    fn good_stamps_and_gaps_are_left() {
        let good: Vec<f64> = (0..1000).map(|row| f64::from(row) * 0.02).collect();
        assert_eq!(even(&good), None);
        let gap: Vec<f64> = good.iter().map(|t| if *t > 10.0 { t + 3.0 } else { *t }).collect();
        assert_eq!(even(&gap), None);
    }
}
