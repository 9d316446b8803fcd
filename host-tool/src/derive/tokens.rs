//! The words of an expression.

/// One of them.
#[derive(Debug, Clone, PartialEq)]
pub enum Token {
    /// A number as it is written.
    Number(String),
    /// A column, a function or a constant; a column of any name stands in braces.
    Name(String),
    /// `+ - * / ^ ( ) ,`
    Mark(char),
}

/// Splits an expression.
///
/// # Errors
/// What stands in it that has no meaning.
pub fn tokens(text: &str) -> Result<Vec<Token>, String> {
    let mut list = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '{' => {
                let end = rest.find('}').ok_or("a brace { is not closed")?;
                list.push(Token::Name(rest[1..end].trim().to_string()));
                end + 1
            }
            c if c.is_ascii_digit() || c == '.' => {
                let length = number(rest);
                list.push(Token::Number(rest[..length].to_string()));
                length
            }
            c if c.is_alphabetic() || c == '_' => {
                let inside = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
                let length = rest.find(|c: char| !inside(c)).unwrap_or(rest.len());
                list.push(Token::Name(rest[..length].to_string()));
                length
            }
            '*' if rest.starts_with("**") => {
                list.push(Token::Mark('^'));
                2
            }
            c if "+-*/^(),".contains(c) => {
                list.push(Token::Mark(c));
                1
            }
            c => {
                return Err(format!(
                    "\"{c}\" has no meaning here; put a column name with other characters in braces, as in {{motor[0]}}"
                ));
            }
        };
        rest = rest[length..].trim_start();
    }
    Ok(list)
}

/// The length of the number that `text` begins with: `1`, `.5`, `2.5e-3`.
fn number(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits =
        |from: usize| bytes.iter().skip(from).take_while(|b| b.is_ascii_digit() || **b == b'.').count();
    let mantissa = digits(0);
    let sign = usize::from(matches!(bytes.get(mantissa + 1), Some(b'+' | b'-')));
    match bytes.get(mantissa) {
        Some(b'e' | b'E') => match digits(mantissa + 1 + sign) {
            0 => mantissa,
            exponent => mantissa + 1 + sign + exponent,
        },
        _ => mantissa,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_names_and_marks() {
        let name = |text: &str| Token::Name(text.into());
        let number = |text: &str| Token::Number(text.into());
        assert_eq!(
            tokens("2.5e-3*{motor[0] A}**max_a").expect("valid"),
            [number("2.5e-3"), Token::Mark('*'), name("motor[0] A"), Token::Mark('^'), name("max_a")]
        );
        assert_eq!(tokens("1e").expect("valid"), [number("1"), name("e")]);
        assert_eq!(tokens(" ").expect("valid"), []);
        assert!(tokens("a$b").expect_err("no sign").contains('$'));
        assert!(tokens("{a").is_err());
    }
}
