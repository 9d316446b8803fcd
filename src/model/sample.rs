//! What a model is asked about: a sample, the effects in it, and which residual.

use crate::effect::{Bends, Effect, MAX_COEFFICIENTS, MAX_INPUTS, Quantities};
use crate::math::Real;
use crate::vector::plus;
use core::fmt;

/// Which residual a row belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

/// One sample as the study sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Observation<T> {
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
    /// What it bends.
    pub bends: Bends,
}

impl<T: Real> Term<'_, T> {
    /// Whether it disturbs anything: a candidate does not.
    pub(super) fn is_active(&self) -> bool {
        self.coefficients.iter().any(|value| *value != T::zero())
    }

    /// Whether its shape moves with the field that it disturbs.
    pub(super) fn reads_centre(&self) -> bool {
        self.bends == Bends::Field || self.effect.reads_centre()
    }

    /// What it sees of a sample, about a centre at this offset.
    pub(super) fn sees(&self, at: &Quantities<T>, offset_ut: [T; 3]) -> Quantities<T> {
        let measured_ut = match self.bends {
            Bends::Reading => at.measured_ut,
            Bends::Field => plus(at.centred_ut, offset_ut),
        };
        Quantities { inputs: self.inputs, measured_ut, ..*at }
    }
}

/// How late these terms together say that the reading is, s; `None` where none of them is a delay.
pub(super) fn delay_s<T: Real>(terms: &[Term<'_, T>]) -> Option<T> {
    let mut delays = terms.iter().filter_map(|term| term.effect.delay_s(&term.coefficients));
    let first = delays.next()?;
    Some(delays.fold(first, |sum, delay| sum + delay))
}

/// Something in a row was not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

/// Why a sample gave no row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NoRow {
    /// Something in it is not finite.
    NotFinite(NotFinite),
    /// More terms than there is room for: the columns of the last would be missing from the row.
    TooManyTerms {
        /// Terms there are.
        terms: usize,
        /// The most there may be.
        most: usize,
    },
    /// Base model and terms have more columns than the row has places.
    TooWide {
        /// Columns there are.
        columns: usize,
        /// Places in a row.
        width: usize,
    },
}

impl From<NotFinite> for NoRow {
    fn from(cause: NotFinite) -> Self {
        NoRow::NotFinite(cause)
    }
}

impl fmt::Display for NoRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoRow::NotFinite(cause) => cause.fmt(f),
            NoRow::TooManyTerms { terms, most } => write!(f, "{terms} terms, and there is room for {most}"),
            NoRow::TooWide { columns, width } => {
                write!(f, "{columns} columns of base model and coefficients, and there is room for {width}")
            }
        }
    }
}

impl core::error::Error for NoRow {}
