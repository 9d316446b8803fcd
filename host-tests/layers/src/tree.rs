//! The modules of one target, and the file that each stands in.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use syn::{Attribute, Expr, Item, ItemMod, Lit, Meta};

/// One module: where it is, and what it holds.
pub struct Module {
    /// The names from the crate's root to it; empty for the root.
    pub path: Vec<String>,
    /// Its file, as a place in [`Tree::files`].
    pub file: usize,
    /// Its parent, as a place in [`Tree::modules`].
    pub parent: Option<usize>,
    /// Its children by name.
    pub children: BTreeMap<String, usize>,
    /// What stands in it; the bodies of inline children are theirs.
    pub items: Vec<Item>,
    /// Whether it or a parent is only there for tests.
    pub test: bool,
}

/// A file of the tree.
pub struct File {
    /// Where it is.
    pub path: PathBuf,
    /// The module that it is.
    pub module: usize,
}

/// All modules and files of one target.
pub struct Tree {
    /// The root is first.
    pub modules: Vec<Module>,
    /// The root's is first.
    pub files: Vec<File>,
}

impl Tree {
    /// Reads a target from its root file.
    ///
    /// # Errors
    /// A sentence, for a file that cannot be read or parsed.
    pub fn read(root: &Path) -> Result<Self, String> {
        let mut tree = Tree { modules: Vec::new(), files: Vec::new() };
        let directory = root.parent().unwrap_or(Path::new(".")).to_path_buf();
        tree.add_file(root.to_path_buf(), directory, Vec::new(), None, false)?;
        Ok(tree)
    }

    /// Reads a file as a module; its children's files stand in `directory`.
    fn add_file(
        &mut self,
        file: PathBuf,
        directory: PathBuf,
        path: Vec<String>,
        parent: Option<usize>,
        test: bool,
    ) -> Result<usize, String> {
        let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        let parsed = syn::parse_file(&text)
            .map_err(|error| format!("{}:{}: {error}", file.display(), error.span().start().line))?;
        let number = self.files.len();
        self.files.push(File { path: file, module: self.modules.len() });
        self.add_module(parsed.items, number, &directory, path, parent, test)
    }

    fn add_module(
        &mut self,
        items: Vec<Item>,
        file: usize,
        directory: &Path,
        path: Vec<String>,
        parent: Option<usize>,
        test: bool,
    ) -> Result<usize, String> {
        let own = self.modules.len();
        let (children, items): (Vec<_>, Vec<_>) =
            items.into_iter().partition(|item| matches!(item, Item::Mod(_)));
        self.modules.push(Module { path, file, parent, children: BTreeMap::new(), items, test });
        for item in children {
            let Item::Mod(child) = item else { continue };
            let name = child.ident.to_string();
            let test = test || child.attrs.iter().any(is_for_tests);
            let mut path = self.modules[own].path.clone();
            path.push(name.clone());
            let number = self.add_child(child, file, directory, path, own, test)?;
            self.modules[own].children.insert(name, number);
        }
        Ok(own)
    }

    fn add_child(
        &mut self,
        child: ItemMod,
        file: usize,
        directory: &Path,
        path: Vec<String>,
        parent: usize,
        test: bool,
    ) -> Result<usize, String> {
        let name = child.ident.to_string();
        let name = name.strip_prefix("r#").unwrap_or(&name);
        if let Some((_, items)) = child.content {
            return self.add_module(items, file, &directory.join(name), path, Some(parent), test);
        }
        let beside = match child.attrs.iter().find_map(path_attribute) {
            // Relative to the folder of the file that says so; a file named like that has its children beside it.
            Some(given) => {
                let folder = self.files[file].path.parent().unwrap_or(Path::new(".")).to_path_buf();
                let file = folder.join(given);
                let directory = file.parent().unwrap_or(Path::new(".")).to_path_buf();
                return self.add_file(file, directory, path, Some(parent), test);
            }
            None => directory.join(format!("{name}.rs")),
        };
        let inside = directory.join(name).join("mod.rs");
        let found = if beside.is_file() { beside } else { inside };
        self.add_file(found, directory.join(name), path, Some(parent), test)
    }

    /// The file that a module stands in.
    pub fn file_of(&self, module: usize) -> usize {
        self.modules[module].file
    }
}

/// `#[cfg(test)]`.
fn is_for_tests(attribute: &Attribute) -> bool {
    matches!(&attribute.meta, Meta::List(list) if list.path.is_ident("cfg") && list.tokens.to_string() == "test")
}

/// The file of `#[path = "file"]`.
fn path_attribute(attribute: &Attribute) -> Option<String> {
    let Meta::NameValue(pair) = &attribute.meta else { return None };
    let Expr::Lit(literal) = &pair.value else { return None };
    match &literal.lit {
        Lit::Str(text) if pair.path.is_ident("path") => Some(text.value()),
        _ => None,
    }
}
