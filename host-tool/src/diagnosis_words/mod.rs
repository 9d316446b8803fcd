//! What a diagnosis says to people: `ironout diagnose` prints it, a page shows it.

mod advice;
mod answer;
mod conclusion;
mod curve;
mod found;
mod moment;
mod next;
mod numbers;
mod place;
mod told;
pub(crate) mod unlogged;
mod words;

pub use answer::report;
pub use conclusion::sentence;
pub use found::amount;
pub use told::Told;
pub use words::{brief, text};
