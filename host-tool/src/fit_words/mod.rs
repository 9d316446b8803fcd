//! What a fit says to people: the answer first, the details after it.

mod brief;
mod details;
mod next;
mod text;

pub use brief::{one_line, report};
pub use text::{brief, text};
