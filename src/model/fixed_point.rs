//! The fixed point of a disturbance that depends on the field it disturbs.

use crate::math::Real;
use crate::vector::minus;

/// Iterations at most: a weak disturbance converges after two or three, one whose slope is two thirds after 28.
const MOST_ITERATIONS: usize = 28;

/// Whether two iterations differ by less than a hundred-thousandth of the vector.
#[inline]
fn converged<T: Real>(now: [T; 3], before: [T; 3]) -> bool {
    let [x, y, z] = minus(now, before);
    let [a, b, c] = now;
    !(x * x + y * y + z * z > T::of(1e-10) * (a * a + b * b + c * c))
}

/// The vector that `step` makes of a centred one, as if there were no disturbance; with `again` the step is repeated on its own result
/// until that converges.
///
/// # Errors
/// The first of `step`.
#[inline]
pub(crate) fn settle<T: Real, E>(
    centred: [T; 3],
    again: bool,
    mut step: impl FnMut([T; 3]) -> Result<[T; 3], E>,
) -> Result<[T; 3], E> {
    let mut left = step(centred)?;
    if again {
        let mut before = centred;
        for _ in 1..MOST_ITERATIONS {
            if converged(left, before) {
                break;
            }
            before = left;
            left = step(before)?;
        }
    }
    Ok(left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_converges_where_it_moves_by_less_than_a_hundred_thousandth_along_any_axis() {
        let now = [30.0, 40.0, 0.0];
        assert!(converged(now, now));
        for axis in 0..3 {
            let moved = |by: f64| {
                let mut before = now;
                before[axis] += by;
                before
            };
            assert!(converged(now, moved(4e-4)) && converged(now, moved(-4e-4)), "axis {axis}");
            assert!(!converged(now, moved(6e-4)) && !converged(now, moved(-6e-4)), "axis {axis}");
        }
    }
}
