//! Words as a POSIX shell takes them: what the program suggests can be pasted.

/// A word of a POSIX shell: quoted only where it must be.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "_-./:=,+@%^".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// ` --option value`; a value that begins with a minus needs the equals sign.
pub fn typed_option(option: &str, value: &str) -> String {
    format!(" {option}{}{}", if value.starts_with('-') { "=" } else { " " }, quoted(value))
}
