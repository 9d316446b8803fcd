//! A column through a low-pass, in fixed memory.

use crate::effect::Past;
use crate::math::Real;

/// A low-pass of first order over one column: `τ dy/dt = x − y`.
///
/// It begins at the column's first value, as if that had lasted, and takes the column as linear in between: exact then, however
/// unevenly the values come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass<T> {
    time_constant_s: f64,
    /// Time (s), the column's value and the filter's; `None` before the first.
    last: Option<(f64, T, f64)>,
}

impl<T: Real> LowPass<T> {
    /// At the beginning.
    pub fn new(time_constant_s: T) -> Self {
        Self { time_constant_s: time_constant_s.as_f64().max(0.0), last: None }
    }

    /// Takes the column's value at a time and gives the filter's. A value that is not finite gives `None`, and the filter goes on
    /// from where it was with the next one; so it does where time runs backward, from the new time on.
    pub fn push(&mut self, now_s: f64, value: T) -> Option<T> {
        if !value.is_finite() || !now_s.is_finite() {
            return None;
        }
        let y = match self.last {
            None => value.as_f64(),
            Some((then_s, before, y)) => Past::<f64>::low_pass(
                self.time_constant_s,
                now_s - then_s,
                [y, before.as_f64(), value.as_f64()],
            ),
        };
        self.last = Some((now_s, value, y));
        Some(T::of(y))
    }
}

#[cfg(test)]
mod tests {
    use super::LowPass;
    use crate::math;

    #[test]
    fn a_step_creeps_and_a_ramp_trails() {
        for rate_hz in [3.0, 50.0] {
            let mut filter = LowPass::<f64>::new(4.0);
            let at = |i: u32| f64::from(i) / rate_hz;
            for i in 0..200 {
                let y = filter.push(at(i), 2.0 + 0.5 * at(i)).unwrap();
                // The exact answer: behind by τ times the slope once the beginning has died away.
                let exact = 2.0 + 0.5 * (at(i) - 4.0 + 4.0 * math::exp(-at(i) / 4.0));
                assert!(math::abs(y - exact) < 1e-12, "{y} {exact}");
            }
        }
        let mut filter = LowPass::<f32>::new(10.0);
        assert_eq!(filter.push(0.0, 1.0), Some(1.0));
        assert_eq!(filter.push(1e-6, 3.0).map(|y| y < 1.01), Some(true));
        let y = filter.push(10.0, 3.0).unwrap();
        assert!((f64::from(y) - (3.0 - 2.0 * math::exp(-1.0))).abs() < 1e-5, "{y}");
    }

    #[test]
    fn what_is_not_known_is_not_filtered() {
        let mut filter = LowPass::<f32>::new(1.0);
        assert_eq!(filter.push(0.0, f32::NAN), None);
        assert_eq!(filter.push(0.1, 5.0), Some(5.0));
        assert_eq!(filter.push(0.2, f32::NAN), None);
        assert_eq!(filter.push(0.3, 5.0), Some(5.0));
        assert_eq!(filter.push(0.2, 7.0), Some(5.0), "time ran backward");
        assert_eq!(LowPass::<f64>::new(0.0).push(0.0, 2.0), Some(2.0));
    }
}
