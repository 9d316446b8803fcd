//! Stamps of arrival: a row that is stamped when it arrives was measured on the even grid behind it.

/// Shorter logs are left as they are.
const FEWEST: usize = 100;
/// The grid is even over so many rows on either side; over more the sensor's own rate may wander.
const AROUND: usize = 40;
/// Stamps that scatter by less than this share of a row are good enough.
const SCATTER: f64 = 0.1;
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
    let even: Vec<f64> = (0..n)
        .map(|row| {
            // As far on either side, so that a slope stays one.
            let side = AROUND.min(row).min(n - 1 - row);
            let mean = (sums[row + side + 1] - sums[row - side]) / (2 * side + 1) as f64;
            time_s[0] + row as f64 * row_s + mean
        })
        .collect();
    let square = even.iter().zip(time_s).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / n as f64;
    (square.sqrt() > SCATTER * row_s).then_some(even)
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
            assert!(off.abs() < 0.001, "row {row}: {off}");
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
