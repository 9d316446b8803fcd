//! What a check finds, in words.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// The most lines of a code file.
pub const MOST_LINES: usize = 800;

/// One arrow in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Import {
    /// The file that imports, from the workspace's root.
    pub from: String,
    /// The line.
    pub line: usize,
    /// The path as it is written.
    pub text: String,
    /// The file that is imported.
    pub to: String,
}

impl fmt::Display for Import {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {} -> {}", self.from, self.line, self.text, self.to)
    }
}

/// One line for each pair of files, with the lines of all imports between them and what the first of them names.
fn by_pair(imports: &[Import]) -> Vec<String> {
    let mut pairs: BTreeMap<(&str, &str), Vec<&Import>> = BTreeMap::new();
    for import in imports {
        pairs.entry((&import.from, &import.to)).or_default().push(import);
    }
    let words = pairs.into_iter().map(|((from, to), imports)| {
        let lines: BTreeSet<_> = imports.iter().map(|import| import.line).collect();
        let lines: Vec<_> = lines.iter().map(usize::to_string).collect();
        let mut names: Vec<_> = imports.iter().map(|import| import.text.as_str()).collect();
        names.dedup();
        format!("{from}:{}: {} -> {to}", lines.join(","), names.join(", "))
    });
    words.collect()
}

/// Something that is not in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Finding {
    /// Files of a target import each other in a circle.
    Circle {
        /// Crate and target.
        target: String,
        /// The files.
        files: Vec<String>,
        /// The arrows among them.
        imports: Vec<Import>,
    },
    /// An arrow up the order of rooms.
    Upward {
        /// Crate and target.
        target: String,
        /// The room that imports.
        from: String,
        /// The room above it.
        to: String,
        /// The arrow.
        import: Import,
    },
    /// A file in no declared room.
    NoRoom {
        /// Crate and target.
        target: String,
        /// The file.
        file: String,
    },
    /// A declared room without a file.
    EmptyRoom {
        /// Crate and target, or what else the table is of.
        target: String,
        /// The room.
        room: String,
    },
    /// A library of several modules without an order.
    NoOrder {
        /// The crate.
        target: String,
    },
    /// A crate depends on one above it, or on one that is not declared.
    CrateUpward {
        /// The crate.
        from: String,
        /// The one it depends on.
        to: String,
    },
    /// A crate that the order of crates does not name.
    CrateUndeclared {
        /// The crate.
        name: String,
    },
    /// A file that is too long.
    TooLong {
        /// The file.
        file: String,
        /// Its lines.
        lines: usize,
    },
    /// A wrong arrow is listed and not there any more.
    NotThereAnyMore {
        /// The file.
        from: String,
        /// What it should import.
        to: String,
    },
    /// A file could not be read or parsed.
    Unreadable {
        /// Why.
        why: String,
    },
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Circle { target, files, imports } => {
                write!(
                    f,
                    "{target}: {} files import each other in a circle: {}",
                    files.len(),
                    files.join(", ")
                )?;
                by_pair(imports).iter().try_for_each(|line| write!(f, "\n    {line}"))
            }
            Self::Upward { target, from, to, import } => {
                write!(f, "{target}: the room {from} imports {to}, which stands above it\n    {import}")
            }
            Self::NoRoom { target, file } => {
                write!(f, "{target}: {file} is in no room: name its room in host-tests/layers/ROOMS.md")
            }
            Self::EmptyRoom { target, room } => {
                write!(f, "{target}: docs/architecture.md names `{room}`, and there is none")
            }
            Self::NoOrder { target } => {
                write!(f, "{target}: docs/architecture.md has no \"Order of rooms: `{target}`\"")
            }
            Self::CrateUpward { from, to } => {
                write!(
                    f,
                    "the crate {from} depends on {to}, which does not stand before it in the order of crates"
                )
            }
            Self::CrateUndeclared { name } => write!(f, "the order of crates does not name {name}"),
            Self::TooLong { file, lines } => {
                write!(f, "{file}: {lines} lines, and {} are the most", MOST_LINES)
            }
            Self::NotThereAnyMore { from, to } => write!(
                f,
                "{from} does not import {to} any more: take the row out of \"Not yet in order\" in host-tests/layers/ROOMS.md"
            ),
            Self::Unreadable { why } => f.write_str(why),
        }
    }
}

/// What was looked at, and what was found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Crates, with those of examples that stand for themselves.
    pub crates: usize,
    /// Targets: libraries, programs, tests, benches, examples.
    pub targets: usize,
    /// Files in the trees of modules of those.
    pub files: usize,
    /// Paths looked at.
    pub paths: usize,
    /// Different arrows between files.
    pub imports: usize,
    /// Rooms declared.
    pub rooms: usize,
    /// Files whose length was looked at.
    pub measured: usize,
    /// Wrong arrows that are known.
    pub not_yet: Vec<String>,
    /// What is not in order.
    pub findings: Vec<Finding>,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for finding in &self.findings {
            writeln!(f, "{finding}")?;
        }
        for known in &self.not_yet {
            writeln!(f, "not yet in order: {known}")?;
        }
        writeln!(
            f,
            "{} crates with {} targets, {} files, {} paths, {} imports between files, {} rooms; {} files measured",
            self.crates, self.targets, self.files, self.paths, self.imports, self.rooms, self.measured
        )?;
        match self.findings.len() {
            0 => writeln!(f, "no circles, all arrows run down, no file too long"),
            n => writeln!(f, "{n} findings"),
        }
    }
}
