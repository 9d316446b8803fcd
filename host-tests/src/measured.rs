//! The document of everything measured, `host-tests/measured.md`: each table stands between two markers and is written by the
//! command that measures it. A new table needs the markers in the document and one call of [`write()`].

use std::io;
use std::path::PathBuf;

/// Where the document lies.
pub fn path() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../host-tests/measured.md"))
}

/// Writes tables, each as plain text between the markers of its name.
///
/// # Errors
/// The document cannot be read or written, or lacks markers.
pub fn write(tables: &[(&str, String)]) -> io::Result<()> {
    let mut document = std::fs::read_to_string(path())?;
    for (name, table) in tables {
        document = between_markers(&document, name, table).ok_or_else(|| {
            io::Error::other(format!(
                "host-tests/measured.md has no <!-- {name}:begin --> and <!-- {name}:end -->"
            ))
        })?;
    }
    std::fs::write(path(), document)
}

/// `document` with the text between the markers of `name` replaced; `None` where it has none.
pub fn between_markers(document: &str, name: &str, table: &str) -> Option<String> {
    let (begin, end) = (format!("<!-- {name}:begin -->"), format!("<!-- {name}:end -->"));
    let from = document.find(&begin)? + begin.len();
    let to = from + document[from..].find(&end)?;
    Some(format!("{}\n```text\n{}\n```\n{}", &document[..from], table.trim_end(), &document[to..]))
}
