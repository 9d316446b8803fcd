//! A reason of a verdict: words for people, and a code that does not change with them.

use serde::{Serialize, Serializer};
use std::borrow::Borrow;
use std::fmt;
use std::ops::Deref;

/// Reason with its stable code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reason {
    /// A short word for programs, as `too-few-orientations`.
    pub code: &'static str,
    /// The sentence for people.
    pub words: String,
}

impl Reason {
    /// A reason.
    pub fn new(code: &'static str, words: impl Into<String>) -> Self {
        Reason { code, words: words.into() }
    }
}

impl Deref for Reason {
    type Target = str;
    fn deref(&self) -> &str {
        &self.words
    }
}

impl Borrow<str> for Reason {
    fn borrow(&self) -> &str {
        &self.words
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

impl Serialize for Reason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.words)
    }
}

/// The codes of reasons, each once, in their order.
pub fn codes(reasons: &[Reason]) -> Vec<&'static str> {
    let mut list: Vec<&'static str> = Vec::new();
    for reason in reasons {
        if !list.contains(&reason.code) {
            list.push(reason.code);
        }
    }
    list
}
