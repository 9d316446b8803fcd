//! The part of a long series in which its noise is looked at.
//!
//! The colour of a noise is a matter of neighbouring samples: stretches of all samples tell it as well as the whole series does, and
//! their transforms do not grow with the log. Slow changes over the whole log remain as steps from stretch to stretch.

// A list of stretches may hold one.
#![allow(clippy::single_range_in_vec_init)]

use crate::noise::power::PADDING;
use std::ops::Range;

/// At most so many samples are transformed: one short of a power of two by the padding.
pub const MOST: usize = (1 << 16) - PADDING;
/// Stretches they lie in.
const STRETCHES: usize = 16;

/// Places in a series of `n` values: all of them, or stretches at equal distances.
pub fn stretches(n: usize) -> Vec<Range<usize>> {
    if n <= MOST {
        return vec![0..n];
    }
    let long = MOST / STRETCHES;
    let begin = |stretch: usize| stretch * (n - long) / (STRETCHES - 1);
    (0..STRETCHES).map(|stretch| begin(stretch)..begin(stretch) + long).collect()
}

/// The values in these stretches, one stretch after the other.
pub fn within<T: Copy>(values: &[T], stretches: &[Range<usize>]) -> Vec<T> {
    stretches.iter().flat_map(|stretch| values[stretch.clone()].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_series_is_looked_at_whole_and_a_long_one_from_end_to_end() {
        assert_eq!(stretches(0), [0..0]);
        assert_eq!(stretches(MOST), [0..MOST]);
        for n in [MOST + 1, MOST + 17, 1_000_000] {
            let list = stretches(n);
            assert_eq!((list[0].start, list[STRETCHES - 1].end), (0, n));
            assert!(list.windows(2).all(|pair| pair[0].end <= pair[1].start), "{n}: {list:?}");
            let places: Vec<usize> = (0..n).collect();
            let looked_at = within(&places, &list);
            assert!(
                looked_at.len() <= MOST && looked_at.len() > MOST - STRETCHES,
                "{n}: {}",
                looked_at.len()
            );
        }
    }
}
