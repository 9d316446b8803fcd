//! What errors show of a header.

/// The columns that are there.
pub fn listing(header: &[String]) -> String {
    format!("the header has {}", shorten(&header.join(", ")))
}

/// At most some 200 characters of `text`.
pub fn shorten(text: &str) -> String {
    match text.char_indices().nth(200) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}
