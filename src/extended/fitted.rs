//! The effects that a calibration carries.

use crate::effect::{BuiltIn, Coefficients};

/// The most effects a calibration carries.
pub const MAX_EFFECTS: usize = 4;

/// An effect with its coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedEffect<T, E = BuiltIn<T>> {
    /// The shape.
    pub effect: E,
    /// The coefficients, in the effect's unit; the first k count.
    pub coefficients: Coefficients<T>,
    /// Their standard errors, from noise; NaN for a coefficient that the data did not show.
    pub std_errors: Coefficients<T>,
}

/// Up to [`MAX_EFFECTS`] effects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effects<T, E = BuiltIn<T>>(pub(super) [Option<FittedEffect<T, E>>; MAX_EFFECTS]);

impl<T, E> Effects<T, E> {
    /// No effects.
    pub const fn none() -> Self {
        Self([const { None }; MAX_EFFECTS])
    }

    /// These places; for constants.
    pub const fn of(places: [Option<FittedEffect<T, E>>; MAX_EFFECTS]) -> Self {
        Self(places)
    }

    /// Adds one; gives it back if all places are taken.
    ///
    /// # Errors
    /// The effect itself.
    pub fn push(&mut self, effect: FittedEffect<T, E>) -> Result<(), FittedEffect<T, E>> {
        match self.0.iter_mut().find(|place| place.is_none()) {
            Some(place) => {
                *place = Some(effect);
                Ok(())
            }
            None => Err(effect),
        }
    }

    /// The effects.
    pub fn iter(&self) -> impl Iterator<Item = &FittedEffect<T, E>> {
        self.0.iter().flatten()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.iter().count()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
