//! Functions that look beyond their own row. A missing cell is NaN, and what needs it is missing too.

/// The value of the row before; missing in the first.
pub fn prev(values: &[f64]) -> Vec<f64> {
    std::iter::once(f64::NAN).chain(values.iter().copied()).take(values.len()).collect()
}

/// The value of the row after; missing in the last.
pub fn next(values: &[f64]) -> Vec<f64> {
    values.iter().copied().skip(1).chain([f64::NAN]).take(values.len()).collect()
}

/// What changed since the row before; missing in the first.
pub fn diff(values: &[f64]) -> Vec<f64> {
    values.iter().zip(prev(values)).map(|(now, before)| now - before).collect()
}

/// The largest magnitude so far: what magnetises a part once, and stays.
pub fn peak(values: &[f64]) -> Vec<f64> {
    let mut most = f64::NAN;
    let mut row = |value: &f64| {
        // `max` of the library passes over what is missing.
        most = most.max(value.abs());
        if value.is_finite() { most } else { f64::NAN }
    };
    values.iter().map(&mut row).collect()
}

/// A first-order low pass: what a part with this time constant makes of the column (a supply with a capacitor, a body that
/// warms). It begins at the first value; over missing cells it waits.
pub fn lowpass(values: &[f64], time_s: &[f64], constant_s: f64) -> Vec<f64> {
    let mut state: Option<(f64, f64)> = None;
    let row = |(value, now): (&f64, &f64)| {
        if !value.is_finite() {
            return f64::NAN;
        }
        let next = match state {
            None => *value,
            // Steps of any length: the column is taken as constant since the row before.
            Some((before, then)) => value + (before - value) * (-(now - then).max(0.0) / constant_s).exp(),
        };
        state = Some((next, *now));
        next
    };
    values.iter().zip(time_s).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_before_and_changes() {
        let values = [1.0, 4.0, f64::NAN, 2.0];
        assert_eq!(format!("{:?}", prev(&values)), "[NaN, 1.0, 4.0, NaN]");
        assert_eq!(format!("{:?}", diff(&values)), "[NaN, 3.0, NaN, NaN]");
        assert_eq!(format!("{:?}", next(&values)), "[4.0, NaN, 2.0, NaN]");
        assert!(prev(&[]).is_empty() && next(&[]).is_empty());
    }

    #[test]
    fn a_peak_stays() {
        let values = [1.0, -4.0, f64::NAN, 2.0, 5.0, 0.0];
        assert_eq!(format!("{:?}", peak(&values)), "[1.0, 4.0, NaN, 4.0, 5.0, 5.0]");
    }

    #[test]
    fn the_low_pass_answers_a_step_as_a_capacitor_does() {
        let time: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.01).collect();
        let step: Vec<f64> = time.iter().map(|t| if *t > 0.995 { 1.0 } else { 0.0 }).collect();
        let out = lowpass(&step, &time, 0.5);
        // One time constant after the step: 1 − 1/e.
        assert!((out[149] - (1.0 - (-1.0_f64).exp())).abs() < 1e-3, "{}", out[149]);
        assert_eq!(out[50], 0.0);
        // A gap in the column is not a gap in the time.
        let mut holes = step.clone();
        holes[120..140].fill(f64::NAN);
        let with = lowpass(&holes, &time, 0.5);
        assert!(with[130].is_nan() && (with[149] - out[149]).abs() < 1e-9);
    }
}
