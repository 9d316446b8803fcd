//! The crates of the workspace and their targets, as cargo knows them, and the files on disk.

use cargo_metadata::{MetadataCommand, Package};
use std::path::{Path, PathBuf};
use walkdir::{DirEntry, WalkDir};

/// One target of a crate.
pub struct Target {
    /// `crate`, or `crate / target` where it is not the library.
    pub name: String,
    /// Whether it is the library.
    pub library: bool,
    /// Its root file.
    pub root: PathBuf,
}

/// One crate.
pub struct Crate {
    /// Its name.
    pub name: String,
    /// What it depends on by path.
    pub depends_on: Vec<String>,
    /// Its targets.
    pub targets: Vec<Target>,
    /// Whether it belongs to the workspace; an example may stand for itself.
    pub member: bool,
}

/// Every crate below `root`.
///
/// # Errors
/// A sentence, where cargo cannot read a manifest.
pub fn crates(root: &Path) -> Result<Vec<Crate>, String> {
    let mut found = Vec::new();
    let mut manifests = vec![(root.join("Cargo.toml"), true)];
    for entry in entries(root).filter(|entry| entry.file_name() == "Cargo.toml" && entry.depth() > 1) {
        let text = std::fs::read_to_string(entry.path()).map_err(|error| error.to_string())?;
        if text.lines().any(|line| line.trim() == "[workspace]") {
            manifests.push((entry.into_path(), false));
        }
    }
    for (manifest, member) in manifests {
        let mut command = MetadataCommand::new();
        command.manifest_path(&manifest).no_deps().other_options(["--offline".to_string()]);
        let metadata = command.exec().map_err(|error| format!("{}: {error}", manifest.display()))?;
        found.extend(metadata.packages.iter().map(|package| of(package, member)));
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(found)
}

fn of(package: &Package, member: bool) -> Crate {
    let name = package.name.to_string();
    let targets = package.targets.iter().filter(|target| !target.is_custom_build());
    let targets = targets.map(|target| {
        let library = target.is_lib();
        let name = if library { name.clone() } else { format!("{name} / {}", target.name) };
        Target { name, library, root: target.src_path.clone().into_std_path_buf() }
    });
    let depends_on = package.dependencies.iter().filter(|dependency| dependency.path.is_some());
    let depends_on = depends_on.map(|dependency| dependency.name.clone()).filter(|other| *other != name);
    Crate { depends_on: depends_on.collect(), targets: targets.collect(), name: name.clone(), member }
}

/// Every file of code below `root`.
pub fn code_files(root: &Path) -> impl Iterator<Item = PathBuf> {
    const CODE: [&str; 9] = ["rs", "py", "js", "ts", "css", "html", "sh", "c", "h"];
    entries(root).map(DirEntry::into_path).filter(|path| {
        path.extension().and_then(|extension| extension.to_str()).is_some_and(|e| CODE.contains(&e))
    })
}

fn entries(root: &Path) -> impl Iterator<Item = DirEntry> {
    let hidden = |entry: &DirEntry| {
        let name = entry.file_name().to_string_lossy();
        entry.depth() > 0
            && (name.starts_with('.') || ["target", "node_modules", "vendor"].contains(&name.as_ref()))
    };
    let walk = WalkDir::new(root).sort_by_file_name().into_iter();
    walk.filter_entry(move |entry| !hidden(entry))
        .filter_map(Result::ok)
        .filter(|entry| entry.file_type().is_file())
}
