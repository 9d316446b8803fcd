//! The firmware on the emulated board: `cargo test -p ironout-host-tests --features emulated --test suite -- qemu::`.
//!
//! Without QEMU every test says that it was skipped; with `IRONOUT_REQUIRE_QEMU=1` it fails instead.
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
mod vehicles;
