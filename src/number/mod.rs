//! Numbers as text and back, to the last bit, in a tenth of the room that the general way takes.
//!
//! A board prints and reads floating-point numbers now and then, and the tables by which `core` does so fast take 26 KB of its
//! flash. Here both go by exact arithmetic with long integers: slower, without tables, and with the same characters.

mod big;
mod digits;
mod print;
mod read;
#[cfg(test)]
mod tests;

pub use print::Num;
pub use read::read;
