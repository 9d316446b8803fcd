//! Every driver against a chip at the level of its registers: what the datasheets say, from both sides.

mod bench;
mod faults;
mod measuring;
mod noise;
mod probing;
mod self_tests;
mod twins;
mod wide;
