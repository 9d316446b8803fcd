//! Vectors of three numbers and 3×3 matrices, rows first: one of each.
//!
//! Where the processor has no operations of a scalar each of them is a call: written out at each place, as a handful of calls to
//! the emulation, they are four kilobytes more.

use crate::real::Real;

/// Row and column of each of the six entries of an upper triangular 3×3 matrix.
pub const TRIANGLE: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// The matrix of these six entries.
pub(crate) const fn upper_triangular<T: Copy>([xx, xy, xz, yy, yz, zz]: [T; 6], zero: T) -> [[T; 3]; 3] {
    [[xx, xy, xz], [zero, yy, yz], [zero, zero, zz]]
}

/// A function that is compiled into each of its places where the processor has the operations of its scalar, and once where not.
macro_rules! by_call {
    ($(#[$doc:meta])* pub fn $name:ident($($argument:ident: $type:ty),*) -> $out:ty $body:block) => {
        $(#[$doc])*
        #[inline]
        pub fn $name<T: Real>($($argument: $type),*) -> $out {
            #[inline(never)]
            fn apart<T: Real>($($argument: $type),*) -> $out {
                $body
            }
            if T::IS_EMULATED { apart($($argument),*) } else { $body }
        }
    };
}

by_call! {
    /// `a · b`.
    pub fn dot(a: [T; 3], b: [T; 3]) -> T {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }
}

by_call! {
    /// `a × b`.
    pub fn cross(a: [T; 3], b: [T; 3]) -> [T; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }
}

by_call! {
    /// `a − b`.
    pub fn minus(a: [T; 3], b: [T; 3]) -> [T; 3] {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
    }
}

by_call! {
    /// `a + b`.
    pub fn plus(a: [T; 3], b: [T; 3]) -> [T; 3] {
        [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
    }
}

by_call! {
    /// `s a`.
    pub fn scaled(a: [T; 3], s: T) -> [T; 3] {
        [a[0] * s, a[1] * s, a[2] * s]
    }
}

by_call! {
    /// Euclidean norm.
    pub fn norm(v: [T; 3]) -> T {
        let [x, y, z] = v;
        (x * x + y * y + z * z).root()
    }
}

by_call! {
    /// `M v`.
    pub fn times(m: &[[T; 3]; 3], v: [T; 3]) -> [T; 3] {
        [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
    }
}

/// `v` turned by the rotation vector `turn`, rad. A quaternion that is made one again keeps the length to rounding; its
/// series are those of half the angle, exact to 1e-11 up to half a turn.
pub fn turned<T: Real>(v: [T; 3], turn: [T; 3]) -> [T; 3] {
    let square = T::of(0.25) * dot(turn, turn);
    // cos x and sin x / x, Horner's scheme in x².
    let series = |first: u32| {
        let mut sum = T::one();
        for term in (1..=8_u32).rev() {
            let place = f64::from(2 * term + first);
            sum = T::one() - sum * square * T::of(1.0 / (place * (place - 1.0)));
        }
        sum
    };
    let (whole, part) = (series(0), series(1) * T::of(0.5));
    let axis = scaled(turn, part);
    let once = cross(axis, v);
    let twice = cross(axis, once);
    let share = T::of(2.0) / (whole * whole + dot(axis, axis));
    let [x, y, z] = v;
    let [a, b, c] = once;
    let [p, q, r] = twice;
    [x + share * (whole * a + p), y + share * (whole * b + q), z + share * (whole * c + r)]
}

by_call! {
    /// `Mᵀ v`.
    pub fn transposed_times(m: &[[T; 3]; 3], v: [T; 3]) -> [T; 3] {
        let [a, b, c] = m;
        let [x, y, z] = v;
        [a[0] * x + b[0] * y + c[0] * z, a[1] * x + b[1] * y + c[1] * z, a[2] * x + b[2] * y + c[2] * z]
    }
}

by_call! {
    /// `A B`.
    pub fn product(a: &[[T; 3]; 3], b: &[[T; 3]; 3]) -> [[T; 3]; 3] {
        let [x, y, z] = *a;
        [transposed_times(b, x), transposed_times(b, y), transposed_times(b, z)]
    }
}

/// The determinant.
pub fn determinant<T: Real>(&[x, y, z]: &[[T; 3]; 3]) -> T {
    dot(x, cross(y, z))
}

/// The inverse by cofactors; `None` if the determinant is zero or not finite.
pub fn inverse_3x3<T: Real>(m: &[[T; 3]; 3]) -> Option<[[T; 3]; 3]> {
    let &[x, y, z] = m;
    let det = determinant(m);
    if det == T::zero() || !det.is_finite() {
        return None;
    }
    let mut inverse = [[T::zero(); 3]; 3];
    for (c, cofactors) in [cross(y, z), cross(z, x), cross(x, y)].into_iter().enumerate() {
        for (row, cofactor) in inverse.iter_mut().zip(cofactors) {
            row[c] = cofactor / det;
        }
    }
    inverse.iter().flatten().all(|v: &T| v.is_finite()).then_some(inverse)
}
