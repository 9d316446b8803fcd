//! What a page is told of a log: read, fitted, searched, drawn and exported, as JSON. The same code answers in the program and, as
//! WebAssembly, in the page itself.

mod answer;
mod asked;
mod held;
mod look;
mod pack;

pub use answer::Answering;
pub use asked::{LookAsked, ReadAsked};
pub use held::Held;
pub use look::{look, under};
