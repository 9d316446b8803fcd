//! A calibration as code, and as the parameters of other programs: what `ironout export` writes, and a page.

mod target;
mod text;

pub use target::Exported;
pub use text::{asked, text};
