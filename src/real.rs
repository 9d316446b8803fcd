//! The scalars of the core: `f32` on the board's live path, `f64` for solves and on the host.

use core::fmt::{Debug, Display};
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A scalar the core computes with: `f32` or `f64`, and no other.
///
/// The trait is our own, so that the linear algebra inside is no part of anybody's bounds.
pub trait Real:
    Copy
    + Debug
    + Display
    + PartialEq
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + Send
    + Sync
    + decompose::Decompose
    + 'static
{
    /// Whether each operation is a call here, since the processor has none of it: then one text of many is smaller as a call, too.
    #[doc(hidden)]
    const IS_EMULATED: bool;
    /// The nearest value to `value`.
    fn of(value: f64) -> Self;
    /// The same value in double precision.
    fn as_f64(self) -> f64;
    /// Square root, correctly rounded; NaN for a negative argument.
    fn root(self) -> Self;
    /// 0.
    fn zero() -> Self;
    /// 1.
    fn one() -> Self;
    /// The distance from 1 to the next larger number.
    fn epsilon() -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The larger of two; the other one where one is NaN.
    fn max(self, other: Self) -> Self;
    /// The smaller of two; the other one where one is NaN.
    fn min(self, other: Self) -> Self;
}

/// What a kept library works out, for each scalar.
pub(crate) mod decompose {
    #[cfg(feature = "study")]
    use nalgebra::{SMatrix, SVector, SymmetricEigen};

    /// Eigenvalues, and the eigenvector of each.
    #[cfg(feature = "study")]
    pub type Eigen<T> = ([T; 9], [[T; 9]; 9]);

    /// Decompositions in each precision; sealed, so that [`super::Real`] is.
    pub trait Decompose: Sized {
        #[cfg(feature = "study")]
        /// Eigenvalues and eigenvectors of a symmetric 9×9 matrix; `None` where the iteration does not converge.
        #[doc(hidden)]
        fn symmetric_eigen(matrix: &[[Self; 9]; 9]) -> Option<Eigen<Self>>;
        #[cfg(feature = "study")]
        /// `aᵀb`.
        #[doc(hidden)]
        fn inner_product(a: &[Self; 9], b: &[Self; 9]) -> Self;
        /// The matrix that turns by a rotation vector, rad.
        #[doc(hidden)]
        fn rotation(vector: [Self; 3]) -> [[Self; 3]; 3];
    }

    macro_rules! decompose {
        ($scalar:ty) => {
            impl Decompose for $scalar {
                #[cfg(feature = "study")]
                fn symmetric_eigen(matrix: &[[Self; 9]; 9]) -> Option<Eigen<Self>> {
                    // Rows first here, columns first there: what rounding left unsymmetric stays where it was.
                    let matrix = SMatrix::<Self, 9, 9>::from(*matrix).transpose();
                    let eigen = SymmetricEigen::try_new(matrix, Self::EPSILON, 200)?;
                    // Stored by columns: the vectors one after another.
                    Some((eigen.eigenvalues.into(), eigen.eigenvectors.into()))
                }
                #[cfg(feature = "study")]
                fn inner_product(a: &[Self; 9], b: &[Self; 9]) -> Self {
                    SVector::from(*a).dot(&SVector::from(*b))
                }
                #[inline(never)]
                fn rotation(vector: [Self; 3]) -> [[Self; 3]; 3] {
                    let [x, y, z] = vector;
                    let angle = super::Real::root(x * x + y * y + z * z);
                    if angle == 0.0 {
                        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                    }
                    let axis = [x / angle, y / angle, z / angle];
                    let (sine, cosine) = crate::trig::sin_cos(angle.into());
                    let (sine, cosine) = (sine as Self, cosine as Self);
                    // Rodrigues: cos I + (1 − cos) u uᵀ + sin [u]×.
                    let along = |a: Self| a * a + (1.0 - a * a) * cosine;
                    let across = |a: Self, b: Self, turned: Self| a * b * (1.0 - cosine) + turned;
                    let [x, y, z] = axis;
                    let [tx, ty, tz] = [x * sine, y * sine, z * sine];
                    [
                        [along(x), across(x, y, -tz), across(x, z, ty)],
                        [across(x, y, tz), along(y), across(y, z, -tx)],
                        [across(x, z, -ty), across(y, z, tx), along(z)],
                    ]
                }
            }
        };
    }

    decompose!(f32);
    decompose!(f64);
}

macro_rules! real {
    ($scalar:ty, $root:path, $to:expr, $from:expr, $emulated:expr) => {
        impl Real for $scalar {
            const IS_EMULATED: bool = $emulated;
            #[inline]
            fn of(value: f64) -> Self {
                $to(value)
            }
            #[inline]
            fn as_f64(self) -> f64 {
                $from(self)
            }
            #[inline]
            fn root(self) -> Self {
                $root(self)
            }
            #[inline]
            fn zero() -> Self {
                0.0
            }
            #[inline]
            fn one() -> Self {
                1.0
            }
            #[inline]
            fn epsilon() -> Self {
                Self::EPSILON
            }
            #[inline]
            fn is_finite(self) -> bool {
                <$scalar>::is_finite(self)
            }
            #[inline]
            fn abs(self) -> Self {
                <$scalar>::abs(self)
            }
            #[inline]
            fn max(self, other: Self) -> Self {
                <$scalar>::max(self, other)
            }
            #[inline]
            fn min(self, other: Self) -> Self {
                <$scalar>::min(self, other)
            }
        }
    };
}

real!(f32, libm::sqrtf, |value| value as f32, f64::from, cfg!(armv6m));
real!(f64, libm::sqrt, |value| value, |value| value, cfg!(all(target_arch = "arm", target_os = "none")));
