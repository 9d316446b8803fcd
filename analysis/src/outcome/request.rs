//! What is asked of a fit or a diagnosis, and why there may be none.

use crate::base::earlier::EarlierCalibration;
use crate::base::term::{BadShape, COLUMNS, TERMS};
use crate::plain;
use ironout::effect::Registry;
use ironout::fit::Method;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The attitudes that a calibration is to be for.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Purpose {
    /// All of them where the log carries that, else those that it shows.
    #[default]
    AsShown,
    /// All of them.
    All,
    /// Tilts up to this from the mean attitude of the log, degrees.
    Tilt(f64),
}

/// What to fit or to diagnose, and how.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    /// The method of the base model. A model with effects is fitted all at once, by Levenberg–Marquardt.
    #[serde(serialize_with = "plain::method", deserialize_with = "plain::method_of")]
    pub method: Method,
    /// The magnitude of the field, µT; the log's own mean, or that of the earlier calibration, where absent.
    pub field_ut: Option<f64>,
    /// The dip of the field below the horizon, degrees, where it is known; a fit predicts the error of the heading with
    /// it, and it tells a mounting from a mirror image.
    pub dip_deg: Option<f64>,
    /// The attitudes that the calibration is to be for.
    pub purpose: Purpose,
    /// Ids of effects that stand in the model from the beginning.
    pub add: Vec<String>,
    /// Whether a fit keeps effects that the log does not show.
    pub force_effect: bool,
    /// Whether a diagnosis searches for more. A fit never does.
    pub search: bool,
    /// An earlier calibration to build on.
    pub prior: Option<EarlierCalibration>,
    /// p-value of each effect of `add`, by id, where a diagnosis of the same log has worked it out
    /// ([`crate::outcome::outcome::Diagnosis::chances`]); worked out anew where any is absent.
    #[serde(skip)]
    pub chances: Vec<(String, f64)>,
    /// The families of effects: this program's own may follow those of the library.
    #[serde(skip)]
    pub registry: Registry,
}

impl Options {
    /// The field to scale to: as expected, or else that of the earlier calibration.
    pub fn scale_ut(&self) -> Option<f64> {
        self.field_ut.or_else(|| self.prior.as_ref().map(|prior| prior.field_ut))
    }
}

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub enum Refusal {
    /// The shape of this effect is not finite.
    BadShape(String),
    /// There is no room for this effect beside the others.
    NoRoom(String),
    /// `add` names an effect that is not known, or that this log does not allow.
    CannotAdd {
        /// Its id.
        id: String,
        /// The column at fault.
        column: Option<String>,
        /// What is wrong, and what to do.
        why: String,
    },
    /// `add` names more effects than a calibration carries.
    TooMany {
        /// How many it names.
        given: usize,
        /// How many a calibration carries.
        most: usize,
    },
}

impl Refusal {
    /// An effect that cannot be added.
    pub(crate) fn cannot_add(id: &str, why: impl Into<String>) -> Self {
        Refusal::CannotAdd { id: id.to_string(), column: None, why: why.into() }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::BadShape(id) => write!(f, "the shape of effect {id} is not finite"),
            Refusal::NoRoom(id) => write!(
                f,
                "no room for effect {id} in addition to the others: at most {TERMS} effects with {COLUMNS} coefficients, \
                 including the base model's"
            ),
            Refusal::CannotAdd { id, why, .. } => write!(f, "{id} cannot be added: {why}"),
            Refusal::TooMany { given, most } => {
                write!(f, "a calibration has at most {most} effects, but {given} are given")
            }
        }
    }
}

impl std::error::Error for Refusal {}

impl From<BadShape> for Refusal {
    fn from(bad: BadShape) -> Self {
        match bad {
            BadShape::NotFinite(id) => Refusal::BadShape(id),
            BadShape::NoRoom(id) => Refusal::NoRoom(id),
        }
    }
}
