//! The fixed point of a map of three numbers, sooner than by repeating it.
//!
//! Each repetition of `d ← g(d)` leaves a share of the error; of a strong effect that is half and more. What the steps did to
//! the residual `g(d) − d` tells the map's slope, and with it the next step (Broyden, Math. Comp. 19 (1965) 577, the first of
//! his two updates).

use crate::math::Real;
use crate::vector::{dot, minus, scaled, times, transposed_times};

/// A step is at most so many times as long as the plain one.
const FARTHEST: f64 = 8.0;

/// The slope as the steps so far told it, and the last of them.
#[derive(Clone, Copy, Debug)]
pub struct Secant<T> {
    /// `(I − ∂g/∂d)⁻¹`.
    slope: [[T; 3]; 3],
    last: Option<([T; 3], [T; 3])>,
}

impl<T: Real> Default for Secant<T> {
    fn default() -> Self {
        let (zero, one) = (T::zero(), T::one());
        Secant { slope: [[one, zero, zero], [zero, one, zero], [zero, zero, one]], last: None }
    }
}

impl<T: Real> Secant<T> {
    /// Where to look next, after a look at `at` that gave `found`. The first is the plain step.
    pub fn next(&mut self, at: [T; 3], found: [T; 3]) -> [T; 3] {
        let residual = minus(found, at);
        if let Some((before, residual_before)) = self.last.replace((at, residual)) {
            self.learn(minus(at, before), minus(residual, residual_before));
        }
        let step = times(&self.slope, residual);
        // A slope that runs away is forgotten.
        if !(dot(step, step) <= T::of(FARTHEST * FARTHEST) * dot(residual, residual)) {
            *self = Secant { last: self.last, ..Secant::default() };
            return found;
        }
        minus(at, scaled(step, -T::one()))
    }

    /// That a step moved the residual by so much.
    fn learn(&mut self, step: [T; 3], moved: [T; 3]) {
        let seen = times(&self.slope, moved);
        let across = transposed_times(&self.slope, step);
        let share = dot(step, seen);
        let lacks = minus(scaled(step, -T::one()), seen);
        // Nothing moved, or nothing was told.
        if !(share * share > T::of(1e-6) * dot(step, step) * dot(seen, seen)) {
            return;
        }
        for (row, lack) in self.slope.iter_mut().zip(lacks) {
            for (entry, value) in row.iter_mut().zip(across) {
                *entry += lack * value / share;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::norm;

    /// Looks until the map stands, at most a hundred.
    fn iterations(g: impl Fn([f64; 3]) -> [f64; 3], hasten: bool) -> (usize, [f64; 3]) {
        let (mut secant, mut at) = (Secant::default(), [0.0; 3]);
        for look in 1..100 {
            let found = g(at);
            if norm(minus(found, at)) < 1e-9 {
                return (look, at);
            }
            at = if hasten { secant.next(at, found) } else { found };
        }
        (100, at)
    }

    #[test]
    fn a_gain_of_half_stands_after_a_third_of_the_looks() {
        // A gain on each axis, and squares and products across.
        let g = |[x, y, z]: [f64; 3]| {
            let [a, b, c] = [30.0 - x, -20.0 - y, 35.0 - z];
            [0.5 * a + 1e-3 * b * c, -0.45 * b + 1e-3 * a * a, 0.1 * c]
        };
        let ((plain, there), (soon, same)) = (iterations(g, false), iterations(g, true));
        assert!(norm(minus(there, same)) < 1e-7, "{there:?} {same:?}");
        assert!(3 * soon <= plain, "{soon} of {plain}");
    }

    #[test]
    fn a_map_that_repeating_takes_away_from_its_fixed_point_stands_too() {
        let g = |[x, y, z]: [f64; 3]| [1.3 * (30.0 - x), -0.7 * (20.0 - y), 0.2 * (10.0 - z)];
        let (count, [x, ..]) = iterations(g, true);
        assert!(count < 12 && (x - 1.3 * 30.0 / 2.3).abs() < 1e-7, "{count} {x}");
    }

    #[test]
    fn what_tells_nothing_changes_nothing() {
        let mut secant = Secant::<f32>::default();
        assert_eq!(secant.next([1.0; 3], [2.0; 3]), [2.0; 3]);
        assert_eq!(secant.next([1.0; 3], [2.0; 3]), [2.0; 3]);
        let away = secant.next([1.0; 3], [f32::NAN; 3]);
        assert!(away.iter().all(|value| value.is_nan()), "it is told to whoever looks");
    }
}
