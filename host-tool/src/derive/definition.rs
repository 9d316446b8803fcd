//! What `--derive` takes, as words.

use crate::derive::tokens::{Token, tokens};
use crate::failure::{Failure, Outcome};

/// Longer ones are a slip of the pen.
const MOST_CHARACTERS: usize = 2000;

/// One `--derive`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Definition {
    /// The new column.
    pub name: String,
    /// How it is computed.
    pub expression: String,
}

impl Definition {
    /// Splits `NAME=EXPRESSION`.
    ///
    /// # Errors
    /// No name, a name that no column can have, no expression.
    pub fn parse(text: &str) -> Outcome<Self> {
        let fail = |what: &str| {
            Failure::usage(format!(
                "--derive {}: {what}; expected NAME=EXPRESSION, as in --derive 'drive=throttle^1.5*vbat'",
                text.chars().take(200).collect::<String>()
            ))
        };
        if text.chars().count() > MOST_CHARACTERS {
            return Err(fail("this is too long"));
        }
        let (name, expression) = text.split_once('=').ok_or_else(|| fail("there is no ="))?;
        let (name, expression) = (name.trim(), expression.trim());
        if name.is_empty() || expression.is_empty() {
            return Err(fail("name or expression is empty"));
        }
        let plain = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        if !name.chars().all(plain) || name.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return Err(fail("a name has letters, digits and _, and begins with a letter"));
        }
        Ok(Definition { name: name.to_string(), expression: expression.to_string() })
    }

    /// As it is typed.
    pub fn typed(&self) -> String {
        format!("{}={}", self.name, self.expression)
    }

    /// The names that the expression reads.
    fn names(&self) -> Vec<String> {
        let list = tokens(&self.expression).unwrap_or_default();
        let named = list.into_iter().filter_map(|token| match token {
            Token::Name(name) => Some(name),
            _ => None,
        });
        named.collect()
    }
}

/// Those of `definitions` (in turn) that `columns` are computed by, directly or through each other.
pub fn needed<'a>(definitions: &'a [Definition], columns: &[String]) -> Vec<&'a Definition> {
    let mut wanted: Vec<String> = columns.to_vec();
    let mut kept: Vec<&Definition> = Vec::new();
    for definition in definitions.iter().rev() {
        if wanted.contains(&definition.name) {
            wanted.extend(definition.names());
            kept.push(definition);
        }
    }
    kept.reverse();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_expressions_are_told_apart() {
        let one = Definition::parse(" drive = throttle^1.5*vbat ").expect("valid");
        assert_eq!((one.name.as_str(), one.expression.as_str()), ("drive", "throttle^1.5*vbat"));
        for (text, word) in [
            ("drive", "no ="),
            ("=x", "empty"),
            ("a=", "empty"),
            ("1a=x", "begins"),
            ("a b=x", "letters"),
            ("", "no ="),
        ] {
            let failure = Definition::parse(text).expect_err(text);
            assert!(failure.message.contains(word) && failure.exit == 2, "{text}: {failure}");
        }
    }

    #[test]
    fn what_is_needed_goes_through_other_definitions() {
        let all: Vec<Definition> = ["a=x*2", "b=a+y", "c=z"]
            .into_iter()
            .map(|text| Definition::parse(text).expect("valid"))
            .collect();
        let names = |columns: &[&str]| -> Vec<&str> {
            let columns: Vec<String> = columns.iter().map(ToString::to_string).collect();
            needed(&all, &columns).into_iter().map(|one| one.name.as_str()).collect()
        };
        assert_eq!(names(&["b"]), ["a", "b"]);
        assert_eq!(names(&["c", "temp_c"]), ["c"]);
        assert!(names(&["x"]).is_empty());
    }
}
