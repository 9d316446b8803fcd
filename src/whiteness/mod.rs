//! How many of the samples are independent, learned without keeping any.
//!
//! The fit's noise σ̂² holds everything that is not on the ellipsoid: white noise, but also noise with a memory and effects
//! that nobody modelled, which averaging does not remove. How much of it has a memory shows in the difference of the
//! *residual* between samples near each other: of white noise the mean square of that difference is twice the residual's
//! variance, of slow noise it is less. The measured vector itself cannot be asked: jerks and the jitter of the sampling
//! look like white noise in it.
//!
//! | file | what |
//! |---|---|
//! | `lagged.rs` | sums over pairs of samples a fixed lag apart, in fixed memory, from which the difference of any quadric follows |
//! | `stream.rs` | feeds two of them, for neighbours and for samples further apart, with the samples of a moving board |
//! | `share.rs` | from differences and variance to the number of independent samples |

mod lagged;
mod share;
mod stream;

pub use share::independent_share;
pub(crate) use share::{Pairs, share_of_pairs};
#[cfg(feature = "device")]
pub(crate) use stream::Residual;
pub use stream::Whiteness;
