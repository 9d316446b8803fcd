//! The C interface of `ironout`: `libironout.a` and `ironout.h`, documented in `docs/c.md`.
//!
//! Each function checks its pointers, calls the Rust library and returns an error code. No heap, no global state, no
//! panic. The only unsafe code is in the module `pointer`. On bare metal the crate is `no_std`; on a host it links std, because a
//! static library needs a panic handler from somewhere.
#![cfg_attr(target_os = "none", no_std)]

mod calibration;
mod error;
mod heading;
mod layout;
mod live;
mod monitor;
#[cfg(target_os = "none")]
mod panic;
mod pointer;
mod record;
mod sensor;
mod session;
mod side;
mod state;
mod status;

pub use calibration::{IronoutCalibration, ironout_apply_counts, ironout_apply_ut};
pub use error::{IronoutError, ironout_error_text};
pub use heading::ironout_heading;
pub use live::{
    IRONOUT_COLUMN_BYTES, IronoutLive, IronoutOutside, ironout_live_apply, ironout_live_init,
    ironout_live_missing, ironout_live_outside, ironout_live_set,
};
pub use monitor::{IronoutCondition, IronoutMonitor, ironout_monitor_init, ironout_monitor_push};
pub use record::{ironout_record_decode, ironout_record_encode};
pub use sensor::IronoutSensor;
pub use session::{
    IronoutSession, ironout_session_accept, ironout_session_init, ironout_session_push,
    ironout_session_push_ut, ironout_session_status, ironout_session_stop,
};
pub use side::IronoutSide;
pub use status::{
    IronoutHint, IronoutOutcome, IronoutReason, IronoutState, IronoutStatus, ironout_hint_text,
};
