//! The name of a column, kept in fixed memory.

use core::fmt;

/// The most bytes the name of a column may have where it is kept without the log: in a calibration.
pub const MAX_COLUMN_NAME: usize = 32;

/// The name of a column: printable ASCII without blanks, at most [`MAX_COLUMN_NAME`] bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct ColumnName {
    bytes: [u8; MAX_COLUMN_NAME],
    length: u8,
}

/// A name that is empty, longer than [`MAX_COLUMN_NAME`] bytes, or not printable ASCII without blanks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadName;

impl fmt::Display for BadName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the name of a column is 1 to {MAX_COLUMN_NAME} printable ASCII characters without blanks")
    }
}

impl core::error::Error for BadName {}

impl ColumnName {
    /// Keeps a name; usable in constants.
    ///
    /// # Errors
    /// [`BadName`].
    pub const fn new(name: &str) -> Result<Self, BadName> {
        let (mut from, length) = (name.as_bytes(), name.len());
        if length == 0 || length > MAX_COLUMN_NAME {
            return Err(BadName);
        }
        let mut bytes = [0; MAX_COLUMN_NAME];
        let mut to: &mut [u8] = &mut bytes;
        while let ([byte, rest @ ..], [slot, later @ ..]) = (from, to) {
            if !byte.is_ascii_graphic() {
                return Err(BadName);
            }
            *slot = *byte;
            (from, to) = (rest, later);
        }
        Ok(Self { bytes, length: length as u8 })
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        // Only ASCII is ever kept, so neither of the two can fail.
        self.bytes.get(..usize::from(self.length)).and_then(|b| core::str::from_utf8(b).ok()).unwrap_or("")
    }
}

/// No name: that of an effect that follows no column.
impl Default for ColumnName {
    fn default() -> Self {
        Self { bytes: [0; MAX_COLUMN_NAME], length: 0 }
    }
}

impl AsRef<str> for ColumnName {
    fn as_ref(&self) -> &str {
        self.as_str()
    }
}

impl fmt::Debug for ColumnName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_str().fmt(f)
    }
}

impl fmt::Display for ColumnName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::{BadName, ColumnName};

    #[test]
    fn names_are_kept_and_others_refused() {
        const NAME: Result<ColumnName, BadName> = ColumnName::new("temp_c");
        assert_eq!(NAME.unwrap().as_str(), "temp_c");
        let longest = "a234567890123456789012345678901b";
        assert_eq!(ColumnName::new(longest).unwrap().as_str(), longest);
        for bad in ["", "a2345678901234567890123456789012b", "a b", "a\n", "µ"] {
            assert_eq!(ColumnName::new(bad), Err(BadName), "{bad}");
        }
    }
}
