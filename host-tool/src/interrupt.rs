//! Ctrl-C as a wish to end, rather than an end.

use crate::failure::{Failure, Outcome};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the user has asked to end; a clone sees the same.
#[derive(Debug, Clone, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// From now on Ctrl-C (and a request to terminate) is only noted.
    ///
    /// # Errors
    /// The operating system does not allow it.
    pub fn noted() -> Outcome<Self> {
        let interrupt = Interrupt::default();
        let seen = interrupt.clone();
        ctrlc::set_handler(move || seen.0.store(true, Ordering::Relaxed))
            .map_err(|error| Failure::usage(format!("cannot wait for Ctrl-C: {error}")))?;
        Ok(interrupt)
    }

    /// Whether it came.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
