//! The model at which a study linearises, and the rows of its residuals.

use crate::calibration::{inverse_3x3, norm};
use crate::effect::{Effect, MAX_COEFFICIENTS, MAX_INPUTS, Quantities, Shape, no_shape};
use crate::extended::{MOST_LOOKS, stands};
use crate::math::{self, Real};
use core::fmt;

/// Which residual a row belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Residual {
    /// `‖h‖ − F`, µT; base columns: offset (3), then the upper triangle of `C` (6).
    Magnitude,
    /// The angle between field and gravity less the mean one, rad; base columns: rotation (3), sine of the dip (1).
    Dip,
    /// `ĥ` less its mean, µT, three rows a sample; base columns: the mean (3). For a board at rest.
    Vector,
}

impl Residual {
    /// Columns of the base model.
    pub const fn base_columns(self) -> usize {
        match self {
            Residual::Magnitude => 9,
            Residual::Dip => 4,
            Residual::Vector => 3,
        }
    }

    /// The word of the contract.
    pub const fn name(self) -> &'static str {
        match self {
            Residual::Magnitude => "magnitude",
            Residual::Dip => "dip",
            Residual::Vector => "vector",
        }
    }
}

/// The base model: `h = R C (ĥ − b − Σ Φθ)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<T> {
    /// `b`, µT.
    pub offset_ut: [T; 3],
    /// `C`, upper triangular.
    pub matrix: [[T; 3]; 3],
    /// `F`, µT.
    pub field_ut: T,
    /// `R`: from the triangular frame to the accelerometer's.
    pub rotation: [[T; 3]; 3],
    /// Sine of the dip.
    pub sin_dip: T,
    full: [[T; 3]; 3],
    inverse: [[T; 3]; 3],
}

/// One sample as the study sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading<T> {
    /// Measured vector, µT.
    pub measured_ut: [T; 3],
    /// Rate of turn, rad/s.
    pub turn_radps: Option<[T; 3]>,
    /// Unit vector down (against the specific force of a resting accelerometer).
    pub down: Option<[T; 3]>,
}

/// An effect in the model, or with coefficients of zero a candidate for it.
#[derive(Clone, Copy)]
pub struct Term<'a, T> {
    /// The shape.
    pub effect: &'a dyn Effect<T>,
    /// Its coefficients; the first k count.
    pub coefficients: [T; MAX_COEFFICIENTS],
    /// The values of its columns in this sample.
    pub inputs: [T; MAX_INPUTS],
}

/// Something in a row was not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotFinite {
    /// The sample or the model.
    Sample,
    /// The shape of the effect at this place among the terms.
    Effect(usize),
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotFinite::Sample => f.write_str("the sample or the model is not finite"),
            NotFinite::Effect(index) => write!(f, "the shape of effect {index} is not finite"),
        }
    }
}

impl core::error::Error for NotFinite {}

/// `M v`.
fn times<T: Real>(m: &[[T; 3]; 3], v: [T; 3]) -> [T; 3] {
    m.map(|row| dot(row, v))
}

/// `Mᵀ v`.
fn transposed_times<T: Real>(m: &[[T; 3]; 3], v: [T; 3]) -> [T; 3] {
    let [a, b, c] = m;
    let [x, y, z] = v;
    [a[0] * x + b[0] * y + c[0] * z, a[1] * x + b[1] * y + c[1] * z, a[2] * x + b[2] * y + c[2] * z]
}

pub(super) fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn minus<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scaled<T: Real>(a: [T; 3], s: T) -> [T; 3] {
    a.map(|value| value * s)
}

fn product<T: Real>(a: &[[T; 3]; 3], b: &[[T; 3]; 3]) -> [[T; 3]; 3] {
    a.map(|row| transposed_times(b, row))
}

pub(super) struct Linearised<T> {
    pub(super) centred: [T; 3],
    pub(super) pull: [T; 3],
    pub(super) residual: T,
}

impl<T: Real> Model<T> {
    /// A model. `None` where the matrix cannot be inverted or something is not finite.
    pub fn new(
        offset_ut: [T; 3],
        matrix: [[T; 3]; 3],
        field_ut: T,
        rotation: [[T; 3]; 3],
        sin_dip: T,
    ) -> Option<Self> {
        let full = product(&rotation, &matrix);
        let inverse = inverse_3x3(&full)?;
        let finite = offset_ut.iter().chain(full.iter().flatten()).all(|value| value.is_finite());
        let sound = finite && sin_dip.is_finite() && field_ut.is_finite() && field_ut > T::zero();
        sound.then_some(Model { offset_ut, matrix, field_ut, rotation, sin_dip, full, inverse })
    }

    /// `R C`: the full correction.
    pub fn full_matrix(&self) -> [[T; 3]; 3] {
        self.full
    }

    /// `(R C)⁻ᵀ v`.
    pub(super) fn transposed_inverse(&self, v: [T; 3]) -> [T; 3] {
        transposed_times(&self.inverse, v)
    }

    /// `Rᵀ v`.
    pub(super) fn transposed_rotation(&self, v: [T; 3]) -> [T; 3] {
        transposed_times(&self.rotation, v)
    }

    pub(super) fn quantities(
        &self,
        measured_ut: [T; 3],
        centred_ut: [T; 3],
        turn: Option<[T; 3]>,
    ) -> Quantities<T> {
        let turning = match turn {
            Some(turn) => times(&self.inverse, cross(turn, times(&self.full, centred_ut))),
            None => [T::zero(); 3],
        };
        Quantities { measured_ut, centred_ut, turning_ut_per_s: turning, inputs: [T::zero(); MAX_INPUTS] }
    }

    pub(super) fn linearise(&self, measured: [T; 3], disturbance: [T; 3]) -> Option<Linearised<T>> {
        let centred = minus(minus(measured, self.offset_ut), disturbance);
        let h = times(&self.matrix, centred);
        let length = norm(h);
        if !length.is_finite() || length <= T::zero() {
            return None;
        }
        let direction = scaled(h, T::one() / length);
        let pull = transposed_times(&self.matrix, direction);
        Some(Linearised { centred, pull, residual: length - self.field_ut })
    }

    /// The measured vector without its noise, as far as one sample tells: the nearest point of the ellipsoid.
    pub(super) fn foot(&self, at: &Linearised<T>) -> [T; 3] {
        let size = dot(at.pull, at.pull);
        scaled(at.pull, at.residual / size)
    }

    /// Shapes of all terms at the foot point, and the disturbance they make together.
    pub(super) fn shapes<'t, const N: usize>(
        &self,
        at: &Quantities<T>,
        terms: impl Iterator<Item = &'t Term<'t, T>>,
        shapes: &mut [Shape<T>; N],
    ) -> Result<[T; 3], NotFinite>
    where
        T: 't,
    {
        let mut sum = [T::zero(); 3];
        for (index, (term, shape)) in terms.zip(shapes.iter_mut()).enumerate() {
            let at = Quantities { inputs: term.inputs, ..*at };
            term.effect.shape(&at, shape);
            for (vector, coefficient) in shape.iter().zip(term.coefficients).take(term.effect.coefficients())
            {
                for (total, value) in sum.iter_mut().zip(vector) {
                    if !value.is_finite() {
                        return Err(NotFinite::Effect(index));
                    }
                    *total += *value * coefficient;
                }
            }
        }
        Ok(sum)
    }

    /// The rows of one sample: calls `push(row, residual)` once, or for the vector three times. `N` is the most terms
    /// that are read. Nothing is pushed for the dip where the sample has no direction down.
    pub fn rows<const N: usize, const P: usize>(
        &self,
        residual: Residual,
        reading: &Reading<T>,
        terms: &[Term<'_, T>],
        mut push: impl FnMut(&[T; P], T),
    ) -> Result<(), NotFinite> {
        let mut shapes = [no_shape::<T>(); N];
        let measured = reading.measured_ut;
        if residual == Residual::Vector {
            let at = self.quantities(measured, minus(measured, self.offset_ut), reading.turn_radps);
            let disturbance = self.shapes(&at, terms.iter(), &mut shapes)?;
            let left = minus(minus(measured, self.offset_ut), disturbance);
            for (axis, value) in left.into_iter().enumerate() {
                let mut unit = [T::zero(); 3];
                if let Some(entry) = unit.get_mut(axis) {
                    *entry = T::one();
                }
                let mut row = [T::zero(); P];
                fill(&mut row, &unit.map(|entry| -entry), unit, terms, &shapes);
                push(&row, value);
            }
            return if left.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(NotFinite::Sample) };
        }
        let (at, reaction) = self.at_foot(reading, terms, &mut shapes)?;
        let mut row = [T::zero(); P];
        if residual == Residual::Dip {
            let Some(down) = reading.down else { return Ok(()) };
            let h = times(&self.full, at.centred);
            let length = norm(h);
            let u = scaled(h, T::one() / length);
            let sine = dot(u, down);
            // The angle itself: a residual in sines would weigh the parameter into the scale of the residual.
            let cosine = |sine: T| (T::one() - sine * sine).max(T::of(0.01)).root();
            let (own, mean) = (cosine(sine), cosine(self.sin_dip));
            let [x, y, z] = scaled(cross(u, down), T::one() / own);
            let across = scaled(minus(down, scaled(u, sine)), T::one() / (length * own));
            let pull = reaction.answer(transposed_times(&self.full, across));
            fill(&mut row, &[x, y, z, -T::one() / mean], pull, terms, &shapes);
            let value = T::of(math::asin(sine.as_f64()) - math::asin(self.sin_dip.as_f64()));
            if !value.is_finite() {
                return Err(NotFinite::Sample);
            }
            push(&row, value);
            return Ok(());
        }
        let foot = minus(at.centred, self.foot(&at));
        let at_foot = times(&self.matrix, foot);
        let u = scaled(at_foot, T::one() / norm(at_foot));
        let pull = reaction.answer(transposed_times(&self.matrix, u));
        let grown = reaction.grown(pull);
        let [ax, ay, az, by, bz, cz] = self.through_turning(&reaction, pull, foot, reading.turn_radps);
        let pull = scaled(pull, grown);
        let [p, q, r] = pull;
        let [a, b, c] = u;
        let [x, y, z] = foot;
        let triangle = [a * x + ax, a * y + ay, a * z + az, b * y + by, b * z + bz, c * z + cz];
        let [ax, ay, az, by, bz, cz] = triangle.map(|column| column * grown);
        fill(&mut row, &[-p, -q, -r, ax, ay, az, by, bz, cz], pull, terms, &shapes);
        push(&row, at.residual);
        Ok(())
    }

    /// The corrected field of one sample in the accelerometer's frame, µT: what
    /// [`ExtendedCalibration::apply`](crate::extended::ExtendedCalibration::apply) gives. Where an effect reads the centre,
    /// the disturbance is looked at until it stands, as there.
    pub fn correct(&self, reading: &Reading<T>, terms: &[Term<'_, T>]) -> Result<[T; 3], NotFinite> {
        let measured = reading.measured_ut;
        let centred = minus(measured, self.offset_ut);
        let mut shape = [no_shape::<T>(); 1];
        let mut left = centred;
        let again = terms.iter().any(|term| term.effect.reads_centre());
        for _ in 0..if again { MOST_LOOKS } else { 1 } {
            let at = self.quantities(measured, left, reading.turn_radps);
            let before = left;
            left = centred;
            for (index, term) in terms.iter().enumerate() {
                let one = self
                    .shapes(&at, core::iter::once(term), &mut shape)
                    .map_err(|_| NotFinite::Effect(index))?;
                left = minus(left, one);
            }
            if stands(left, before) {
                break;
            }
        }
        Ok(times(&self.full, left))
    }

    /// The model after a step of a magnitude study: offset and triangle moved, the rest kept.
    pub fn stepped(&self, delta: &[T]) -> Option<Self> {
        let d = |index: usize| delta.get(index).copied().unwrap_or(T::zero());
        let [x, y, z] = self.offset_ut;
        let mut matrix = self.matrix;
        let triangle = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        for (index, (row, column)) in triangle.into_iter().enumerate() {
            if let Some(entry) = matrix.get_mut(row).and_then(|line| line.get_mut(column)) {
                *entry += d(3 + index);
            }
        }
        Self::new([x + d(0), y + d(1), z + d(2)], matrix, self.field_ut, self.rotation, self.sin_dip)
    }

    /// The model after a step of a dip study: turned by the rotation vector, sine of the dip moved.
    pub fn aligned(&self, delta: &[T]) -> Option<Self> {
        let d = |index: usize| delta.get(index).copied().unwrap_or(T::zero());
        let turn = nalgebra::Rotation3::new(nalgebra::Vector3::new(d(0), d(1), d(2)));
        let turn: [[T; 3]; 3] = core::array::from_fn(|i| core::array::from_fn(|j| turn[(i, j)]));
        let limit = T::of(0.999);
        let sine = (self.sin_dip + d(3)).max(-limit).min(limit);
        Self::new(self.offset_ut, self.matrix, self.field_ut, product(&turn, &self.rotation), sine)
    }
}

/// Base columns, then `−pull·Φ` of every term.
fn fill<T: Real, const N: usize, const P: usize>(
    row: &mut [T; P],
    base: &[T],
    pull: [T; 3],
    terms: &[Term<'_, T>],
    shapes: &[Shape<T>; N],
) {
    let columns = terms
        .iter()
        .zip(shapes)
        .flat_map(|(term, shape)| shape.iter().take(term.effect.coefficients()))
        .map(|vector| -dot(pull, *vector));
    for (slot, value) in row.iter_mut().zip(base.iter().copied().chain(columns)) {
        *slot = value;
    }
}
