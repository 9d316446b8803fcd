//! What a model is asked about: a sample, the effects in it, and which residual.

use crate::effect::{Effect, MAX_COEFFICIENTS, MAX_INPUTS};
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

/// One sample as the study sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
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
