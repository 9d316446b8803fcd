//! Whether a log shows the effects that were put into its model.

use crate::search::screen::{ACCUSED, RELEVANCE};
use serde::Serialize;

/// What the test of an effect in the model says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shown {
    /// Its id.
    pub id: String,
    /// Probability that chance does as well, its search counted.
    pub p_value: f64,
    /// Error on held-out time without it, all others in the model: µT, or degrees where only the dip sees it. `None` where
    /// some block of time cannot be predicted.
    pub without: Option<f64>,
    /// The same with it.
    pub with: Option<f64>,
    /// Unit of the two.
    pub unit: &'static str,
}

impl Shown {
    /// Whether chance hardly does as well.
    pub fn is_significant(&self) -> bool {
        self.p_value < ACCUSED
    }

    /// Whether the held-out error falls by what is relevant.
    pub fn falls(&self) -> bool {
        match (self.without, self.with) {
            (Some(without), Some(with)) => with * with < without * without * (1.0 - RELEVANCE),
            (None, with) => with.is_some(),
            (Some(_), None) => false,
        }
    }

    /// Whether the log shows the effect.
    pub fn is_shown(&self) -> bool {
        self.is_significant() && self.falls()
    }
}
