//! The tests that need more than one crate: one binary, one module a subject.

mod accuracy;
mod board_and_host;
mod brown_outs;
mod common;
mod console;
mod correlated;
mod coverage;
mod device_machine;
mod diagnose_dip;
mod ecc_store;
mod effect_table;
mod effects_on_board;
mod endurance;
mod flash_store;
mod gyro_offset;
mod irrelevant_effects;
mod late_store;
mod learning_board;
mod level_turns;
mod loading;
mod measured;
mod moments;
mod monitor;
mod mountings;
pub mod names;
mod optical;
mod oracle;
mod pair;
mod paper;
#[cfg(all(unix, feature = "emulated"))]
mod pico;
mod predicted;
mod properties;
#[cfg(all(unix, feature = "emulated"))]
mod qemu;
mod record;
mod refusals;
mod replacement;
mod session_on_bus;
mod simulated_chips;
mod snapshot;
mod store;
mod store_on_bus;
mod truths;
mod world;
mod wrapping_clock;

/// Stands in the summary for what this build leaves out.
#[cfg(not(feature = "emulated"))]
#[test]
#[ignore = "emulated boards: cargo test --workspace --features emulated"]
fn emulated_boards() {}
