//! Panics of the libraries, which some damaged files provoke, as errors.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether a panic of this thread is not to be printed.
    static SILENT: Cell<bool> = const { Cell::new(false) };
}

/// The result of `work`, or words if it panics, which is not printed.
pub(super) fn caught<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let print = panic::take_hook();
        panic::set_hook(Box::new(move |what| {
            if !SILENT.get() {
                print(what);
            }
        }));
    });
    SILENT.set(true);
    // What `work` had begun is dropped.
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    SILENT.set(false);
    result.unwrap_or_else(|_| Err("its parts contradict each other".into()))
}
