//! The C interface, called from Rust, and its header.

mod errors;
mod expected;
mod header;
mod same_bits;
mod trace;
