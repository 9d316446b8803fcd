//! The C interface, called from Rust, and its header.

mod header;
