//! How a board without a gyro turns, from its corrected field alone.

use crate::vector::{cross, dot, minus, scaled};

/// Directions that are kept, ...
const KEPT: usize = 8;
/// ... and at least so many of them say something.
const LEAST: u8 = 3;
/// Directions older than this say nothing of now, ms, unless the latest [`LEAST`] reach back further, ...
const SPAN_MS: u32 = 100;
/// ... which is at most this.
const LONGEST_MS: u32 = 400;

/// The rate at which the field turns, by a straight line through the directions of the last tenth of a second.
///
/// A direction `n` of a field that stands still goes `ṅ = −ω × n`: of `ω` the field shows what is across it, which is all that an
/// effect of the turning (a [`Lag`](crate::effect::Lag)) needs: it asks for `ω × n`. The rate is that in the middle of the span, some
/// 40 ms ago; noise in the direction of `σ` rad makes `σ √(12/N³)/Δt` of it, of `N` directions `Δt` apart.
#[derive(Debug, Clone)]
pub struct TurningField {
    directions: [[f32; 3]; KEPT],
    t_ms: [u32; KEPT],
    /// Where the next goes, and how many there are.
    next: u8,
    known: u8,
}

impl TurningField {
    /// One that has seen nothing.
    pub const fn new() -> Self {
        Self { directions: [[0.0; 3]; KEPT], t_ms: [0; KEPT], next: 0, known: 0 }
    }

    /// Takes a corrected field, µT (without the effects that need the rate itself), and gives the rate of turn in the field's axes,
    /// rad/s. `None` as long as too few are known, or after a gap.
    pub fn push(&mut self, corrected_ut: [f32; 3], t_ms: u64) -> Option<[f32; 3]> {
        let length2 = dot(corrected_ut, corrected_ut);
        if !(length2 > 0.0 && length2.is_finite()) {
            return None;
        }
        let t_ms = t_ms as u32;
        let place = usize::from(self.next) % KEPT;
        *self.directions.get_mut(place)? = scaled(corrected_ut, 1.0 / crate::math::sqrtf(length2));
        *self.t_ms.get_mut(place)? = t_ms;
        self.next = ((place + 1) % KEPT) as u8;
        self.known = (self.known + 1).min(KEPT as u8);
        // Newest first, as far back as they count.
        let recent = (0..self.known).filter_map(|back| {
            let place = (place + KEPT - usize::from(back)) % KEPT;
            let ago_ms = t_ms.wrapping_sub(*self.t_ms.get(place)?);
            let most_ms = if back < LEAST { LONGEST_MS } else { SPAN_MS };
            (ago_ms <= most_ms).then_some((ago_ms as f32 * -1e-3, self.directions.get(place)?))
        });
        let (mut count, mut time, mut mean) = (0.0f32, 0.0, [0.0f32; 3]);
        for (at_s, direction) in recent.clone() {
            (count, time) = (count + 1.0, time + at_s);
            mean.iter_mut().zip(direction).for_each(|(sum, value)| *sum += value);
        }
        if count < f32::from(LEAST) {
            return None;
        }
        let (middle_s, mean) = (time / count, scaled(mean, 1.0 / count));
        let (mut spread, mut slope) = (0.0f32, [0.0f32; 3]);
        for (at_s, direction) in recent {
            let from_middle = at_s - middle_s;
            spread += from_middle * from_middle;
            let way = minus(*direction, mean);
            slope.iter_mut().zip(way).for_each(|(sum, value)| *sum += from_middle * value);
        }
        let turn = scaled(cross(slope, mean), 1.0 / (spread * dot(mean, mean)));
        turn.iter().all(|value| value.is_finite()).then_some(turn)
    }
}

impl Default for TurningField {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    #[test]
    fn a_field_that_turns_tells_the_rate_across_it_and_a_gap_begins_anew() {
        for rate_hz in [10.0f64, 25.0, 50.0, 100.0] {
            let (mut field, mut said) = (TurningField::new(), 0);
            for i in 0..200 {
                let t_s = f64::from(i) / rate_hz;
                // Turned about z at 2 rad/s: the field goes the other way round.
                let (sin, cos) = (math::sin(-2.0 * t_s), math::cos(-2.0 * t_s));
                let here = [30.0 * cos, 30.0 * sin, 40.0].map(|value| value as f32);
                let turn = field.push(here, (1000.0 * t_s) as u64);
                assert_eq!(turn.is_some(), i >= 2, "{rate_hz} {i}");
                let Some(turn) = turn else { continue };
                said += 1;
                // What is wanted of it: the way of the field.
                let [x, y, z] = cross(turn, here);
                let (right_x, right_y) = (-2.0 * f64::from(here[1]), 2.0 * f64::from(here[0]));
                let wrong = [f64::from(x) - right_x, f64::from(y) - right_y, f64::from(z)];
                let wrong = math::sqrt(wrong.iter().map(|value| value * value).sum());
                // Of 60 µT/s, that of a moment ago.
                let delay_s = (1.0 / rate_hz).max(0.055);
                assert!(wrong < 60.0 * (2.2 * delay_s), "{rate_hz} {i}: {wrong}");
            }
            assert_eq!(said, 198);
            assert_eq!(field.push([1.0, 0.0, 0.0], 1_000_000), None, "after a gap");
        }
        assert_eq!(TurningField::new().push([f32::NAN, 0.0, 0.0], 5), None);
        assert_eq!(TurningField::new().push([0.0; 3], 5), None);
    }
}
