//! What a diagnosis says to people: `ironout diagnose` prints it, a page shows it.

mod advice;
mod answer;
mod conclusion;
mod curve;
mod diagnosed_log;
mod found;
mod moment;
mod next;
mod numbers;
mod place;
pub(crate) mod unlogged;
mod words;

pub use answer::report;
pub use conclusion::sentence;
pub use diagnosed_log::DiagnosedLog;
pub use found::amount;
pub use words::{brief, text};
