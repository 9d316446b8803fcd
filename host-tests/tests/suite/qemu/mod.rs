//! The firmware on the emulated board: `cargo test -p ironout-host-tests --test qemu`.
//!
//! Without QEMU every test says that it was skipped; with `IRONOUT_REQUIRE_QEMU=1` it fails instead.
#![cfg(unix)]

mod calibration;
mod console;
mod cost;
mod effects;
mod faults;
mod hours;
mod learning;
mod same_trace;
mod store;
mod support;
