//! The Raspberry Pi Pico's firmware as it is flashed, in an emulated RP2040: `cargo test -p ironout-host-tests --features emulated --test suite -- pico::`.
//!
//! Everything is paced by the board's own clock. Without Node and rp2040js every test says that it was skipped; with
//! `IRONOUT_REQUIRE_PICO=1` it fails instead.
mod bus_faults;
mod button;
mod calibration;
mod console;
mod cost;
mod faults;
mod hours;
mod learning;
mod power;
mod sensors;
mod support;
