//! What can go wrong around the emulated Pico.

use std::path::PathBuf;

/// Why the emulated board could not be run or spoken to.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Node or rp2040js is not there.
    #[error("{0}")]
    NotInstalled(String),
    /// The emulator ended.
    #[error("the emulator of the Pico ended; what it said is above")]
    Ended,
    /// The emulator refused a request.
    #[error("the emulated Pico refused `{request}`: {reason}")]
    Refused {
        /// The request.
        request: String,
        /// Why.
        reason: String,
    },
    /// Nothing came in time, by the board's clock.
    #[error("expected {expected} within {limit_ms} ms of the board; received {received:?}")]
    Timeout {
        /// What was expected.
        expected: String,
        /// How long it was waited for.
        limit_ms: u64,
        /// What came instead.
        received: String,
    },
    /// The board stands still for good.
    #[error("the board stopped: {0}")]
    Stopped(&'static str),
    /// A line came that the console's contract does not know.
    #[error("the console sent {0:?}, which is neither a reply nor a line of a stream")]
    Protocol(String),
    /// The image is not what is flashed.
    #[error("{path}: {reason}")]
    Image {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The operating system refused.
    #[error("{doing}: {source}")]
    Io {
        /// What was being done.
        doing: String,
        /// The system's reason.
        source: std::io::Error,
    },
}

impl Error {
    /// An [`Error::Io`] with what was being done.
    pub(super) fn io(doing: impl Into<String>) -> impl FnOnce(std::io::Error) -> Error {
        let doing = doing.into();
        move |source| Error::Io { doing, source }
    }
}
