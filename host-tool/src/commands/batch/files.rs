//! The logs that are meant: folders with all below them, patterns, files.

use crate::failure::{Failure, Outcome};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Files in folders that are not logs, by their extension. A file that is named is read whatever it is called.
const NO_LOGS: [&str; 22] = [
    "html", "htm", "md", "png", "jpg", "jpeg", "svg", "pdf", "yaml", "yml", "toml", "py", "ipynb", "rs", "c",
    "h", "params", "param", "state", "jsonl", "part", "xml",
];

/// One log that is meant.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Found {
    /// Its path as it can be opened.
    pub path: PathBuf,
    /// The parts of the path below the folder that was named, or below the common folder of all that were named; the file's name alone if
    /// only it was named.
    pub below: PathBuf,
}

/// All logs, in the order of their paths, each once, without `output` and its like.
pub(super) fn find(named: &[PathBuf], leave_out: &[PathBuf]) -> Outcome<Vec<Found>> {
    let mut found = BTreeSet::new();
    for one in named {
        let before = found.len();
        if one.is_dir() {
            walk(one, one, &mut found)?;
        } else if one.exists() {
            found.insert(Found { path: one.clone(), below: file_name(one) });
        } else if is_pattern(one) {
            expand(one, &mut found)?;
        } else {
            return Err(Failure::usage(
                "no such file or folder. Fix: check the path, and quote a pattern such as 'logs/*.csv'",
            )
            .in_file(one));
        }
        if found.len() == before && found.is_empty() {
            return Err(Failure::usage("no log here. Fix: name a folder with logs, or the logs").in_file(one));
        }
    }
    let mut found: Vec<Found> = found.into_iter().collect();
    // A shell expands `logs/*`: the folders differ as they do below `logs`.
    if named.len() > 1 {
        let common = common_folder(named);
        for one in &mut found {
            if let Ok(below) = one.path.strip_prefix(&common) {
                one.below = below.to_path_buf();
            }
        }
    }
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let leave_out: Vec<PathBuf> = leave_out.iter().map(|path| real(path)).collect();
    let mut seen = BTreeSet::new();
    Ok(found
        .into_iter()
        .filter(|one| {
            let path = real(&one.path);
            !leave_out.contains(&path) && seen.insert(path)
        })
        .collect())
}

/// The deepest folder above or equal to all that were named.
fn common_folder(named: &[PathBuf]) -> PathBuf {
    let folders = named.iter().map(|one| if one.is_dir() { one } else { one.parent().unwrap_or(one) });
    let mut common: Option<PathBuf> = None;
    for folder in folders {
        common = Some(match common {
            None => folder.to_path_buf(),
            Some(before) => {
                let alike = before.components().zip(folder.components()).take_while(|(a, b)| a == b);
                alike.map(|(part, _)| part).collect()
            }
        });
    }
    common.unwrap_or_default()
}

fn file_name(path: &Path) -> PathBuf {
    path.file_name().map(PathBuf::from).unwrap_or_default()
}

fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'))
}

fn entries(folder: &Path) -> Outcome<Vec<PathBuf>> {
    let fail = |error: std::io::Error| Failure::io("read the folder", folder, &error);
    let mut entries = std::fs::read_dir(folder)
        .map_err(fail)?
        .map(|entry| Ok(entry.map_err(fail)?.path()))
        .collect::<Outcome<Vec<PathBuf>>>()?;
    entries.retain(|path| !is_hidden(path));
    entries.sort();
    Ok(entries)
}

fn walk(root: &Path, folder: &Path, found: &mut BTreeSet<Found>) -> Outcome<()> {
    for path in entries(folder)? {
        // A link to a folder may lead back up.
        let is_link = path.symlink_metadata().is_ok_and(|data| data.is_symlink());
        if path.is_dir() {
            if !is_link {
                walk(root, &path, found)?;
            }
        } else if path.is_file() && !is_no_log(&path) {
            let below = path.strip_prefix(root).map(PathBuf::from).unwrap_or_else(|_| file_name(&path));
            found.insert(Found { path, below });
        }
    }
    Ok(())
}

fn is_no_log(path: &Path) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| NO_LOGS.contains(&extension.as_str()))
}

fn is_pattern(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?'])
}

/// The files that a pattern matches, part by part; `**` stands for any folders.
fn expand(pattern: &Path, found: &mut BTreeSet<Found>) -> Outcome<()> {
    let mut fixed = PathBuf::new();
    let mut parts: Vec<String> = Vec::new();
    for part in pattern.components() {
        let text = part.as_os_str().to_string_lossy().into_owned();
        if parts.is_empty() && !text.contains(['*', '?']) {
            fixed.push(part);
        } else {
            parts.push(text);
        }
    }
    let root = if fixed.as_os_str().is_empty() { PathBuf::from(".") } else { fixed.clone() };
    let mut here = vec![root];
    for (index, part) in parts.iter().enumerate() {
        let last = index + 1 == parts.len();
        let mut next = BTreeSet::new();
        for folder in here.iter().filter(|folder| folder.is_dir()) {
            if part == "**" {
                folders(folder, &mut next)?;
                continue;
            }
            next.extend(entries(folder)?.into_iter().filter(|path| {
                let name = file_name(path);
                matches(part, &name.to_string_lossy()) && (last || path.is_dir())
            }));
        }
        here = next.into_iter().collect();
    }
    for path in here.into_iter().filter(|path| path.is_file()) {
        let path = if fixed.as_os_str().is_empty() {
            path.strip_prefix(".").map(PathBuf::from).unwrap_or(path)
        } else {
            path
        };
        let below = path.strip_prefix(&fixed).map(PathBuf::from).unwrap_or_else(|_| file_name(&path));
        found.insert(Found { path, below });
    }
    Ok(())
}

/// A folder and all below it.
fn folders(folder: &Path, into: &mut BTreeSet<PathBuf>) -> Outcome<()> {
    into.insert(folder.to_path_buf());
    for path in entries(folder)?.into_iter().filter(|path| path.is_dir()) {
        if !path.symlink_metadata().is_ok_and(|data| data.is_symlink()) {
            folders(&path, into)?;
        }
    }
    Ok(())
}

/// Whether a name is as a pattern with `*` and `?` says.
pub(super) fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut p, mut n) = (0, 0);
    // The last star, and where the name was then.
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(one) if *one == '?' || *one == name[n] => {
                p += 1;
                n += 1;
            }
            _ => match star {
                Some((at, from)) => {
                    star = Some((at, from + 1));
                    p = at + 1;
                    n = from + 1;
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|one| *one == '*')
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn patterns_match_as_a_shell_has_them() {
        for (pattern, name, is) in [
            ("*.csv", "a.csv", true),
            ("*.csv", "a.csv.gz", false),
            ("v?_*_b*", "v1_x_by", true),
            ("v?_*_b*", "v12_x_by", false),
            ("*a*a", "banana", true),
            ("", "", true),
        ] {
            assert_eq!(matches(pattern, name), is, "{pattern} {name}");
        }
    }
}
