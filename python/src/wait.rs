//! Work without the interpreter's lock, with Ctrl-C and a progress callback while it lasts.

use ironout_cli::failure::{Failure, Outcome};
use pyo3::prelude::*;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

pyo3::create_exception!(
    _ironout,
    IronoutError,
    pyo3::exceptions::PyException,
    "Bad input, or a request that cannot be met."
);

/// Time between two looks at signals, and between two calls of a progress callback.
const BEAT: Duration = Duration::from_millis(50);

/// The exception of a failure: its words, and its place as attributes.
pub fn raised(failure: &Failure) -> PyErr {
    let error = IronoutError::new_err(failure.to_string());
    Python::attach(|py| {
        let value = error.value(py);
        // An attribute that cannot be set leaves the words, which name the place too.
        let _ = value.setattr("file", failure.file.as_deref());
        let _ = value.setattr("column", failure.column.as_deref());
        let _ = value.setattr("message", failure.message.as_str());
        let _ = value.setattr("line", failure.line);
        let _ = value.setattr("exit_status", failure.exit);
    });
    error
}

/// Does the work on a thread of its own. After Ctrl-C the call ends at once with `KeyboardInterrupt`; the thread ends when its work
/// is done, and nobody waits for it.
pub fn on_thread<T: Send + 'static>(
    py: Python<'_>,
    stage: &str,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce() -> Outcome<T> + Send + 'static,
) -> PyResult<T> {
    let (sender, receiver) = channel();
    let began = Instant::now();
    std::thread::spawn(move || {
        // Nobody listens after Ctrl-C.
        let _ = sender.send(work());
    });
    let receiver = std::sync::Mutex::new(receiver);
    loop {
        let answer = py.detach(|| match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(BEAT),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        });
        match answer {
            Ok(answer) => return answer.map_err(|failure| raised(&failure)),
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals()?;
                if let Some(progress) = progress {
                    progress.call1((stage, began.elapsed().as_secs_f64()))?;
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                let words = "this program failed on this log. Fix: report it, with the log";
                return Err(raised(&Failure::usage(words)));
            }
        }
    }
}
