//! What an effect reads of a sample, and what it gives.

use crate::math::Real;

/// The most coefficients an effect may have.
pub const MAX_COEFFICIENTS: usize = 9;

/// The most columns an effect may read.
pub const MAX_INPUTS: usize = 2;

/// The column of an effect that reads the time.
pub const TIME: &str = "t_s";

/// `θ`: the coefficients of an effect. Only the first k are read.
pub type Coefficients<T> = [T; MAX_COEFFICIENTS];

/// `Φ`: one vector of µT per unit for each coefficient. Only the first k are read.
pub type Shape<T> = [[T; 3]; MAX_COEFFICIENTS];

/// A shape of zeros.
pub fn no_shape<T: Real>() -> Shape<T> {
    [[T::zero(); 3]; MAX_COEFFICIENTS]
}

/// A column that an effect reads, perhaps late.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column<'a, T> {
    /// Name in the log; [`TIME`] is the time in seconds.
    pub name: &'a str,
    /// How long ago the value was that acts now, s.
    pub delay_s: T,
}

impl<'a, T: Real> Column<'a, T> {
    /// A column that acts at once.
    pub fn now(name: &'a str) -> Self {
        Column { name, delay_s: T::zero() }
    }
}

/// What an effect may look at in one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantities<T> {
    /// The measured vector without its noise (the foot point on the ellipsoid), µT.
    pub measured_ut: [T; 3],
    /// `ĥ − b − Φθ`: the same vector about the centre, µT.
    pub centred_ut: [T; 3],
    /// `A (ω × h)`, µT/s: minus the rate at which the measured vector changes because the board turns. Zero without a gyro.
    pub turning_ut_per_s: [T; 3],
    /// The values of the effect's columns, in the order of [`Effect::columns`](super::Effect::columns).
    pub inputs: [T; MAX_INPUTS],
}

impl<T: Real> Quantities<T> {
    /// A sample of which only the measured vector is known: not turning, no columns.
    pub fn of_vector(measured_ut: [T; 3]) -> Self {
        let zero = T::zero();
        Quantities {
            measured_ut,
            centred_ut: measured_ut,
            turning_ut_per_s: [zero; 3],
            inputs: [zero; MAX_INPUTS],
        }
    }
}

/// `value · θ` with the first three coefficients: the disturbance of a shape `value · I₃`.
#[inline]
pub(super) fn along<T: Real>(value: T, [x, y, z, ..]: &Coefficients<T>) -> [T; 3] {
    [*x * value, *y * value, *z * value]
}

/// Writes `value · I₃` into the first three vectors.
pub(super) fn isotropic<T: Real>(value: T, shape: &mut Shape<T>) {
    diagonal([value; 3], 0, shape);
}

/// Writes a diagonal matrix into the three vectors from `first` on.
pub(super) fn diagonal<T: Real>(values: [T; 3], first: usize, shape: &mut Shape<T>) {
    for (axis, (vector, value)) in shape.iter_mut().skip(first).zip(values).enumerate() {
        *vector = [T::zero(); 3];
        if let Some(entry) = vector.get_mut(axis) {
            *entry = value;
        }
    }
}
