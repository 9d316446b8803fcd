//! A disturbance that depends on the field it disturbs, looked at until it stands.

use crate::math::Real;
use crate::vector::minus;

/// The most looks; a weak disturbance stands after two or three.
const MOST_ITERATIONS: usize = 12;

/// Whether two looks differ by less than a hundred-thousandth of the vector.
#[inline]
fn stands<T: Real>(now: [T; 3], before: [T; 3]) -> bool {
    let [x, y, z] = minus(now, before);
    let [a, b, c] = now;
    !(x * x + y * y + z * z > T::of(1e-10) * (a * a + b * b + c * c))
}

/// What `look` leaves of a centred vector: the first look is with the vector as if there were no disturbance, and `again`
/// repeats it with what was left until that stands.
///
/// # Errors
/// The first of `look`.
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
            if stands(left, before) {
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
    fn a_look_stands_where_it_moves_by_less_than_a_hundred_thousandth_along_any_axis() {
        let now = [30.0, 40.0, 0.0];
        assert!(stands(now, now));
        for axis in 0..3 {
            let moved = |by: f64| {
                let mut before = now;
                before[axis] += by;
                before
            };
            assert!(stands(now, moved(4e-4)) && stands(now, moved(-4e-4)), "axis {axis}");
            assert!(!stands(now, moved(6e-4)) && !stands(now, moved(-6e-4)), "axis {axis}");
        }
    }
}
