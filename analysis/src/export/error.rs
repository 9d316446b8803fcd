//! Why a calibration cannot be written for another program.

use std::fmt;

/// Why a calibration cannot be written for another program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CannotExport {
    /// These two columns have the same name there.
    SameName(String, String),
    /// The matrix has no inverse.
    Singular,
    /// The log was read with a mirror image, which this target cannot hold.
    Mirrored(&'static str),
    /// This target keeps its numbers in counts, and how many microtesla one is is not known.
    NoCounts(&'static str),
    /// A number is too large for the target's parameter.
    TooLarge {
        /// The parameter.
        parameter: String,
        /// The number, as it would be.
        value: String,
    },
    /// The target has no set of parameters with this number.
    NoNumber {
        /// The target.
        target: &'static str,
        /// What was asked for.
        number: usize,
        /// Those that it has.
        least: usize,
        /// Those that it has.
        most: usize,
    },
}

impl fmt::Display for CannotExport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CannotExport::SameName(one, other) => write!(
                f,
                "the columns {one} and {other} have the same name in C: rename one with --map and fit again"
            ),
            CannotExport::Singular => f.write_str("the matrix is singular"),
            CannotExport::Mirrored(target) => write!(
                f,
                "this calibration is for a log read with mirrored axes (--rotate), but {target} supports rotations only. \
                 Fix: correct the driver and fit again"
            ),
            CannotExport::NoCounts(target) => write!(
                f,
                "{target} stores the offset in counts of its driver, but the log was in microtesla. Fix: give the scale in \
                 µT per count with --ut-per-count"
            ),
            CannotExport::TooLarge { parameter, value } => {
                write!(
                    f,
                    "{parameter} would be {value}, which is out of its range. Fix: check --ut-per-count"
                )
            }
            CannotExport::NoNumber { target, number, least, most } => {
                write!(f, "--number {number}: {target} counts its magnetometers from {least} to {most}")
            }
        }
    }
}

impl std::error::Error for CannotExport {}
