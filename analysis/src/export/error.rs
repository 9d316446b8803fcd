//! Why a calibration cannot be written as code.

use std::fmt;

/// Why a calibration cannot be written as code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CannotExport {
    /// These two columns have the same name there.
    SameName(String, String),
    /// The matrix has no inverse.
    Singular,
}

impl fmt::Display for CannotExport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CannotExport::SameName(one, other) => write!(
                f,
                "the columns {one} and {other} have the same name in C: rename one with --map and fit again"
            ),
            CannotExport::Singular => f.write_str("the matrix is singular"),
        }
    }
}

impl std::error::Error for CannotExport {}
