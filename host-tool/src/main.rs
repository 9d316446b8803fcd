//! The command line tool `ironout`.
fn main() {}
