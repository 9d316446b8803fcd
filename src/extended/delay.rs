//! A column as it was a while ago, in fixed memory.

use crate::math::Real;

/// Values that a delay line keeps.
pub const DELAY_PLACES: usize = 32;

/// The recent past of one column.
///
/// However long the delay and however fast the samples, [`DELAY_PLACES`] values span it: they are taken at most 30 times
/// within the delay, and in between the column is taken as linear. A column that changes within a thirtieth of its delay
/// is smoothed by that much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayLine<T> {
    delay_s: f64,
    spacing_s: f64,
    times_s: [f64; DELAY_PLACES],
    values: [T; DELAY_PLACES],
    /// Place of the newest value.
    newest: usize,
    filled: usize,
}

impl<T: Real> DelayLine<T> {
    /// An empty line.
    pub fn new(delay_s: T) -> Self {
        let delay_s = delay_s.as_f64().max(0.0);
        Self {
            delay_s,
            spacing_s: delay_s / (DELAY_PLACES - 2) as f64,
            times_s: [0.0; DELAY_PLACES],
            values: [T::zero(); DELAY_PLACES],
            newest: 0,
            filled: 0,
        }
    }

    fn place(&self, ago: usize) -> Option<(f64, T)> {
        let index = (self.newest + DELAY_PLACES - ago) % DELAY_PLACES;
        Some((*self.times_s.get(index)?, *self.values.get(index)?))
    }

    /// Takes the column's value at a time and gives what it was `delay_s` earlier; `None` while that is not known. A value
    /// that is not finite, or time running backward, empties the line.
    pub fn push(&mut self, now_s: f64, value: T) -> Option<T> {
        let last = self.place(0).filter(|_| self.filled > 0);
        if !value.is_finite() || !now_s.is_finite() || last.is_some_and(|(time, _)| now_s < time) {
            self.filled = 0;
            return None;
        }
        if last.is_none_or(|(time, _)| now_s - time >= self.spacing_s) {
            self.newest = (self.newest + 1) % DELAY_PLACES;
            if let (Some(time), Some(slot)) =
                (self.times_s.get_mut(self.newest), self.values.get_mut(self.newest))
            {
                (*time, *slot) = (now_s, value);
            }
            self.filled = (self.filled + 1).min(DELAY_PLACES);
        }
        let wanted = now_s - self.delay_s;
        let mut later = (now_s, value);
        for ago in 0..self.filled {
            let earlier = self.place(ago)?;
            if earlier.0 <= wanted {
                let span = later.0 - earlier.0;
                if span <= 0.0 {
                    return Some(earlier.1);
                }
                let share = T::of((wanted - earlier.0) / span);
                return Some(earlier.1 + (later.1 - earlier.1) * share);
            }
            later = earlier;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::DelayLine;
    use crate::math;

    #[test]
    fn a_slow_column_comes_back_late() {
        for (delay, rate_hz) in [(0.25, 50.0), (2.0, 100.0), (0.013, 50.0), (0.0, 50.0)] {
            let mut line = DelayLine::<f64>::new(delay);
            let column = |t: f64| math::sin(t) + 0.2 * t;
            for i in 0..2000 {
                let now = f64::from(i) / rate_hz;
                let late = line.push(now, column(now));
                assert_eq!(late.is_some(), now >= delay, "{delay} at {now}");
                if let Some(late) = late {
                    assert!((late - column(now - delay)).abs() < 2e-3, "{delay} at {now}: {late}");
                }
            }
        }
    }

    #[test]
    fn what_is_not_known_empties_the_line() {
        let mut line = DelayLine::<f32>::new(0.1);
        assert_eq!(line.push(0.0, 1.0), None);
        assert_eq!(line.push(0.2, 1.0), Some(1.0));
        assert_eq!(line.push(0.3, f32::NAN), None);
        assert_eq!(line.push(0.4, 1.0), None);
        assert_eq!(line.push(0.6, 3.0), Some(2.0));
        assert_eq!(line.push(0.5, 3.0), None, "time ran backward");
    }
}
