//! The 35 monomials `xⁱyʲzᵏ` of degree 0 … 4, and where each stands in the arrays of sums.
//!
//! Within a degree the order is lexicographic (`x` first): `xx xy xz yy yz zz`. Every entry of the fits' normal
//! matrices is a linear combination of the sums of these monomials (theory: Dong, Chou, Fang 2014, eqs. (13)–(15);
//! all entries of `DᵀD` and `DᵀĤ²` are products of two monomials of degree at most two).

/// Number of monomials of degree 0 … 4 in three variables.
pub const COUNT: usize = 35;

/// Index of the first monomial of each degree.
const FIRST: [usize; 5] = [0, 1, 4, 10, 20];

/// Position of `xⁱyʲzᵏ` in an array ordered by degree, then lexicographically; `None` above degree four.
#[inline]
pub const fn index(i: usize, j: usize, k: usize) -> Option<usize> {
    // One by one first: the sum of three large exponents does not fit.
    if i > 4 || j > 4 || k > 4 {
        return None;
    }
    let tail = j + k;
    let degree = i + tail;
    if degree > 4 { None } else { Some(FIRST[degree] + tail * (tail + 1) / 2 + k) }
}

/// Position of `xⁱyʲzᵏ`; the caller keeps `i + j + k ≤ 4` (higher degrees wrap to the constant).
#[inline]
pub(crate) const fn at(i: usize, j: usize, k: usize) -> usize {
    match index(i, j, k) {
        Some(position) => position,
        None => 0,
    }
}

/// The exponents `(i, j, k)` of every position.
pub const EXPONENTS: [[u8; 3]; COUNT] = exponents();

const fn exponents() -> [[u8; 3]; COUNT] {
    let mut table = [[0u8; 3]; COUNT];
    let mut i = 0;
    while i <= 4 {
        let mut j = 0;
        while i + j <= 4 {
            let mut k = 0;
            while i + j + k <= 4 {
                table[at(i, j, k)] = [i as u8, j as u8, k as u8];
                k += 1;
            }
            j += 1;
        }
        i += 1;
    }
    table
}

/// Moves sums of monomials to another origin: from `Σ xⁱyʲzᵏ` to `Σ (x−a)ⁱ(y−b)ʲ(z−c)ᵏ`, axis by axis, in place.
///
/// Repeated synthetic division (Taylor shift): exact in integers, 105 multiplications by a small number.
#[inline(never)]
pub(crate) fn shift<T>(sums: &mut [T; COUNT], centre: [T; 3])
where
    T: Copy + core::ops::Mul<Output = T> + core::ops::Sub<Output = T>,
{
    for (steps, c) in SHIFT.iter().zip(centre) {
        for [to, from] in steps {
            let (to, from) = (usize::from(*to), usize::from(*from));
            let Some(lower) = sums.get(from).copied() else { continue };
            if let Some(sum) = sums.get_mut(to) {
                *sum = *sum - c * lower;
            }
        }
    }
}

/// Steps of [`shift`] on each axis: the place that changes, and the place of the next lower power.
const SHIFT: [[[u8; 2]; 35]; 3] = shift_steps();

const fn shift_steps() -> [[[u8; 2]; 35]; 3] {
    let mut table = [[[0; 2]; 35]; 3];
    let mut axis = 0;
    while axis < 3 {
        let mut step = 0;
        let mut p = 0;
        while p <= 4 {
            let mut q = 0;
            while p + q <= 4 {
                let degree = 4 - p - q;
                let mut pass = 1;
                while pass <= degree {
                    let mut i = degree;
                    while i >= pass {
                        table[axis][step] = [place(axis, i, p, q), place(axis, i - 1, p, q)];
                        step += 1;
                        i -= 1;
                    }
                    pass += 1;
                }
                q += 1;
            }
            p += 1;
        }
        axis += 1;
    }
    table
}

const fn place(axis: usize, i: usize, p: usize, q: usize) -> u8 {
    (match axis {
        0 => at(i, p, q),
        1 => at(p, i, q),
        _ => at(p, q, i),
    }) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_monomial_has_its_own_place() {
        for (position, [i, j, k]) in EXPONENTS.iter().enumerate() {
            assert_eq!(index((*i).into(), (*j).into(), (*k).into()), Some(position));
        }
        assert_eq!(index(5, 0, 0), None);
        for large in [5, usize::MAX / 2 + 1, usize::MAX] {
            for exponents in [[large, 1, 0], [0, large, 1], [1, 0, large], [large; 3]] {
                assert_eq!(index(exponents[0], exponents[1], exponents[2]), None, "{exponents:?}");
            }
        }
        assert_eq!(EXPONENTS[4..10], [[2, 0, 0], [1, 1, 0], [1, 0, 1], [0, 2, 0], [0, 1, 1], [0, 0, 2]]);
    }

    #[test]
    fn shift_is_exact() {
        let points = [[3i128, -7, 11], [-32768, 32767, 5], [100, 200, -300]];
        let sums = |centre: [i128; 3]| {
            let mut out = [0i128; COUNT];
            for (slot, e) in out.iter_mut().zip(EXPONENTS) {
                *slot = points
                    .iter()
                    .map(|p| (0..3).map(|a| (p[a] - centre[a]).pow(e[a].into())).product::<i128>())
                    .sum();
            }
            out
        };
        let mut moved = sums([0; 3]);
        shift(&mut moved, [17, -250, 999]);
        assert_eq!(moved, sums([17, -250, 999]));
    }
}
