//! The id of an effect, as the console prints it.

use core::fmt;

use crate::effect::{BuiltIn, Effect};

/// The id of an effect.
pub(super) struct Id<'a>(pub(super) &'a BuiltIn<f64>);

impl fmt::Display for Id<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Effect::<f64>::id(self.0, f)
    }
}
