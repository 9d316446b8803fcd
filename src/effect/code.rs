//! What effects have in common where they are written as code of another program.

use crate::number::Num;
use core::fmt;

/// A constant of C to the last bit, in whatever precision the header is compiled for.
#[derive(Clone, Copy, Debug)]
pub struct CNumber(pub f64);

impl fmt::Display for CNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "(ironout_real){:?}", Num(self.0))
    }
}

/// How numbers and columns are written in the Rust file.
#[derive(Clone, Copy, Debug)]
pub struct RustCode<'a> {
    /// Whether the scalar is `f32` rather than `f64`.
    pub single: bool,
    /// The constant that holds the column's name, a `ColumnName`.
    pub column: &'a str,
}

impl RustCode<'_> {
    /// A number of the file's scalar, the shortest decimals that read back to the same bits.
    pub fn number(&self, value: f64) -> impl fmt::Display + use<> {
        RustNumber { single: self.single, value }
    }
}

struct RustNumber {
    single: bool,
    value: f64,
}

impl fmt::Display for RustNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.value.is_nan(), self.single) {
            (true, true) => f.write_str("f32::NAN"),
            (true, false) => f.write_str("f64::NAN"),
            (false, true) => write!(f, "{:?}", Num(self.value as f32)),
            (false, false) => write!(f, "{:?}", Num(self.value)),
        }
    }
}

/// The statements of `sum += theta · factor · value`, axis by axis.
pub(super) fn c_along(out: &mut dyn fmt::Write, value: fmt::Arguments<'_>, factor: &str) -> fmt::Result {
    write!(
        out,
        "            const ironout_real value = {value};\n            for (i = 0; i < 3; i++) {{\n                \
         sum[i] += theta[i] * {factor}value;\n            }}\n"
    )
}
