//! What can go wrong around the emulated board, and what to do about it.

use std::path::PathBuf;
use std::time::Duration;

/// Why the emulated board could not be built, run or spoken to.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// QEMU is not there.
    #[error(
        "qemu-system-arm was not found: install it (Debian, Ubuntu: apt-get install qemu-system-arm; Fedora: dnf install qemu-system-arm; macOS: brew install qemu)"
    )]
    NotInstalled,
    /// The project's source is not where it was built.
    #[error(
        "the firmware is built from the project's source, which is not at {0}: run from a checkout, or name a built ELF in IRONOUT_FIRMWARE"
    )]
    NoSource(PathBuf),
    /// The compiler cannot build for the microcontroller.
    #[error(
        "the target {target} is not installed and could not be added: run `rustup target add {target}` ({reason})"
    )]
    NoTarget {
        /// The missing target.
        target: &'static str,
        /// What the attempt said.
        reason: String,
    },
    /// The firmware did not build.
    #[error("the firmware did not build: {0}")]
    Build(String),
    /// The firmware's ELF file is not as expected.
    #[error("{path}: {reason}")]
    Elf {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// QEMU ended on its own.
    #[error("QEMU ended ({status}) while {during}; it said: {said}")]
    Exited {
        /// Its exit status.
        status: String,
        /// What was being waited for.
        during: &'static str,
        /// Its standard error.
        said: String,
    },
    /// Nothing came in time.
    #[error("expected {expected} within {} ms; received {received:?}", waited.as_millis())]
    Timeout {
        /// What was expected.
        expected: String,
        /// How long it was waited for.
        waited: Duration,
        /// What came instead.
        received: String,
    },
    /// The machine protocol refused a command.
    #[error("QEMU refused `{command}`: {reason}")]
    Qmp {
        /// The command.
        command: String,
        /// QEMU's description.
        reason: String,
    },
    /// A line came that the console's contract does not know.
    #[error("the console sent {line:?} where {expected} was expected")]
    Protocol {
        /// The line.
        line: String,
        /// What would have been right.
        expected: &'static str,
    },
    /// A field that the emulated sensor cannot be given.
    #[error("the emulated sensor takes fields from 0 to {max} µT per axis, not {given:?}: bias the axes", max = super::limits::MAX_FIELD_UT)]
    Field {
        /// The field asked for.
        given: [f64; 3],
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
