//! What an effect reads of a sample, and what it gives.

use crate::math::{self, Real};

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

/// Which past of a column acts now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Past<T> {
    /// None: its value now.
    Now,
    /// Its value so many seconds ago: a command that a motor follows, a filter with a fixed delay. Negative: its value so many
    /// seconds later, since it is logged late.
    Delayed(T),
    /// A low-pass of first order with this time constant, s: `τ dy/dt = x − y`, from the first value on. A thermal mass, an RC filter.
    LowPass(T),
}

impl<T: Real> Past<T> {
    /// The same in another precision.
    pub fn cast<U: Real>(&self) -> Past<U> {
        match self {
            Past::Now => Past::Now,
            Past::Delayed(s) => Past::Delayed(U::of(s.as_f64())),
            Past::LowPass(s) => Past::LowPass(U::of(s.as_f64())),
        }
    }

    /// The delay or the time constant, s; zero for now.
    pub fn seconds(&self) -> T {
        match *self {
            Past::Now => T::zero(),
            Past::Delayed(s) | Past::LowPass(s) => s,
        }
    }

    /// What tells the name of such a value from the column's own: `current_a_late`.
    pub fn word(&self) -> &'static str {
        match self {
            Past::Now => "",
            Past::Delayed(s) if *s < T::zero() => "ahead",
            Past::Delayed(_) => "late",
            Past::LowPass(_) => "slow",
        }
    }

    /// The value of a low-pass, `y` at the column's value `before`, when it has gone on linearly to `now` within `dt_s`. Exact for
    /// a column that is linear in between.
    pub fn low_pass(time_constant_s: f64, dt_s: f64, [y, before, now]: [f64; 3]) -> f64 {
        if !(dt_s > 0.0 && time_constant_s > 0.0) {
            return if time_constant_s > 0.0 { y } else { now };
        }
        // What lies behind the column in the steady state of a ramp.
        let behind = (now - before) * (time_constant_s / dt_s);
        now - behind + (y - before + behind) * math::exp(-dt_s / time_constant_s)
    }
}

/// A column that an effect reads, perhaps a past of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column<'a, T> {
    /// Name in the log; [`TIME`] is the time in seconds.
    pub name: &'a str,
    /// Which past of it acts.
    pub past: Past<T>,
}

impl<'a, T: Real> Column<'a, T> {
    /// A column that acts at once.
    pub fn now(name: &'a str) -> Self {
        Column { name, past: Past::Now }
    }
}

/// What an effect may look at in one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantities<T> {
    /// The measured vector without its noise (the closest point on the ellipsoid), µT.
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
