//! What the device needs of the study, or of what stands in its place where the feature `study` is left out.

#[cfg(not(feature = "study"))]
pub(super) use super::unstudied::{Fed, Learner, MAX_TESTED, Motion, Question};
#[cfg(feature = "study")]
pub(super) use crate::learn::{Fed, Learner, MAX_TESTED, Motion};
