//! The two threads that a study asks for: one with room for its matrices, and a second one for the passes over a long log.
//! Where there are none to be had, as on `wasm32-unknown-unknown`, the work is done on the caller's own.

use std::ops::Range;
use std::panic::resume_unwind;
use std::thread::{Builder, scope};

/// The stack of a study: normal matrices of 64 columns are 33 KB each, and pass by value.
const STACK_BYTES: usize = 64 << 20;

/// With fewer samples a second thread costs more than it does.
pub(crate) const ALONE: usize = 2000;

/// Runs `work` where a study has room for its matrices.
pub fn with_room<T: Send>(work: impl Fn() -> T + Sync) -> T {
    scope(|scope| {
        let thread = Builder::new().stack_size(STACK_BYTES);
        match thread.spawn_scoped(scope, &work) {
            Ok(running) => match running.join() {
                Ok(result) => result,
                Err(panic) => resume_unwind(panic),
            },
            // No thread to be had: the caller's own stack may do.
            Err(_) => work(),
        }
    })
}

/// What `work` makes of two halves, the second on a thread of its own.
pub fn halves<H: ?Sized + Sync, T: Send>(halves: (&H, &H), work: impl Fn(&H) -> T + Sync) -> (T, T) {
    let (first, second) = halves;
    scope(|scope| match Builder::new().spawn_scoped(scope, || work(second)) {
        Ok(running) => {
            let first = work(first);
            match running.join() {
                Ok(second) => (first, second),
                Err(panic) => resume_unwind(panic),
            }
        }
        Err(_) => (work(first), work(second)),
    })
}

/// What `work` makes of the samples `0..n`: all at once, or in two parts, one after the other, where that is worth a thread.
pub(crate) fn parts<T: Send, E: Send>(
    n: usize,
    work: impl Fn(&Range<usize>) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    if n < ALONE {
        return Ok(vec![work(&(0..n))?]);
    }
    let (first, second) = halves((&(0..n / 2), &(n / 2..n)), work);
    Ok(vec![first?, second?])
}
