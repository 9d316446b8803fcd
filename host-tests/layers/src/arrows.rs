//! From the paths in a target's modules to arrows between its files.

use crate::paths::{Named, Role, named_in};
use crate::tree::Tree;
use std::collections::BTreeMap;

/// One file names something of another.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arrow {
    /// The file that imports, as a place in the tree's files.
    pub from: usize,
    /// The file that is imported.
    pub to: usize,
    /// The line in the importing file.
    pub line: usize,
    /// The path as it is written.
    pub text: String,
}

/// How often a name is looked up through another, before it is given up: more than any sound code needs.
const MOST_ALIASES: usize = 16;

struct Scope<'t> {
    tree: &'t Tree,
    paths: Vec<Vec<Named>>,
    /// Paths behind the names that a module imports.
    aliases: Vec<BTreeMap<String, Vec<String>>>,
    /// Paths that a module imports all of.
    globs: Vec<Vec<Vec<String>>>,
}

/// The arrows between the files of a target, sorted, and the number of paths that were looked at.
pub fn arrows(tree: &Tree) -> (Vec<Arrow>, usize) {
    let paths: Vec<_> = tree.modules.iter().map(|module| named_in(&module.items)).collect();
    let number = paths.iter().map(Vec::len).sum();
    let aliases = paths
        .iter()
        .map(|paths| {
            paths
                .iter()
                .filter_map(|named| match &named.role {
                    Role::Import(alias) => Some((alias.clone(), named.names.clone())),
                    _ => None,
                })
                .collect()
        })
        .collect();
    let globs = paths
        .iter()
        .map(|paths| {
            paths.iter().filter(|named| named.role == Role::Glob).map(|named| named.names.clone()).collect()
        })
        .collect();
    let scope = Scope { tree, paths, aliases, globs };
    let mut found = Vec::new();
    for (module, paths) in scope.paths.iter().enumerate() {
        let from = tree.file_of(module);
        for named in paths {
            let inline = named.role == Role::Inline;
            let Some(target) = scope.resolve(module, &named.names, inline, MOST_ALIASES) else { continue };
            let to = tree.file_of(target);
            if from != to && !scope.tests_its_parent(from, to) {
                let glob = if named.role == Role::Glob { "::*" } else { "" };
                let text = format!("{}{glob}", named.names.join("::"));
                found.push(Arrow { from, to, line: named.line, text });
            }
        }
    }
    found.sort();
    found.dedup();
    (found, number)
}

impl Scope<'_> {
    /// A test module in a file of its own may import its parent.
    fn tests_its_parent(&self, from: usize, to: usize) -> bool {
        let module = &self.tree.modules[self.tree.files[from].module];
        module.test && module.parent.is_some_and(|parent| self.tree.file_of(parent) == to)
    }

    /// The deepest module of this crate that a path names; `None` for paths into other crates and for plain items.
    fn resolve(&self, module: usize, names: &[String], inline: bool, depth: usize) -> Option<usize> {
        let (first, rest) = names.split_first()?;
        let depth = depth.checked_sub(1)?;
        let start = match first.as_str() {
            "crate" => 0,
            "self" => module,
            "super" => self.tree.modules[module].parent?,
            name => {
                // A lone name that is used where it stands is no path to a module.
                if inline && rest.is_empty() {
                    return None;
                }
                return self.through_name(module, name, rest, depth);
            }
        };
        Some(self.walk(start, rest, depth))
    }

    /// Follows names down from a module, as far as they are modules.
    fn walk(&self, start: usize, names: &[String], depth: usize) -> usize {
        let mut at = start;
        let mut names = names;
        while let Some((name, rest)) = names.split_first() {
            let next = match name.as_str() {
                "super" => self.tree.modules[at].parent,
                name => self.tree.modules[at].children.get(name).copied(),
            };
            match next {
                Some(next) => at = next,
                // A module under another name: `pub use crate::a::b;`, and then `c::b::X`. What is named is the deepest.
                None => return self.renamed(at, name, rest, depth).unwrap_or(at),
            }
            names = rest;
        }
        at
    }

    /// What `name::rest` leads to where `name` is imported into the module and is a module itself.
    fn renamed(&self, module: usize, name: &str, rest: &[String], depth: usize) -> Option<usize> {
        let depth = depth.checked_sub(1)?;
        let alias = self.aliases[module].get(name)?;
        let through = self.module_of(module, alias, depth)?;
        (!rest.is_empty()).then(|| self.walk(through, rest, depth))
    }

    /// The module that a whole path is; `None` where it is an item or of another crate.
    fn module_of(&self, module: usize, names: &[String], depth: usize) -> Option<usize> {
        let found = self.resolve(module, names, false, depth)?;
        let name = names.last()?;
        let is_start = matches!(name.as_str(), "crate" | "self" | "super");
        (is_start || self.tree.modules[found].path.last() == Some(name)).then_some(found)
    }

    /// Whether a path begins in this crate by what its first name alone says. What begins with another crate's name is not
    /// looked for behind the globs of the module: among many such globs each would be opened through all the others.
    fn is_own(&self, module: usize, names: &[String]) -> bool {
        names.first().is_some_and(|first| {
            matches!(first.as_str(), "crate" | "self" | "super")
                || self.tree.modules[module].children.contains_key(first)
                || self.aliases[module].contains_key(first)
        })
    }

    /// A path that begins with a plain name: a child, an imported name, or one that comes with a glob.
    fn through_name(&self, module: usize, name: &str, rest: &[String], depth: usize) -> Option<usize> {
        if let Some(child) = self.tree.modules[module].children.get(name) {
            return Some(self.walk(*child, rest, depth));
        }
        if let Some(alias) = self.aliases[module].get(name) {
            // `use x;` of another crate leads to itself.
            if alias.first().is_some_and(|first| first == name) {
                return None;
            }
            let whole: Vec<_> = alias.iter().chain(rest).cloned().collect();
            return self.resolve(module, &whole, false, depth);
        }
        let depth = depth.checked_sub(1)?;
        self.globs[module].iter().filter(|glob| self.is_own(module, glob)).find_map(|glob| {
            let opened = self.resolve(module, glob, false, depth)?;
            let known = self.tree.modules[opened].children.contains_key(name)
                || self.aliases[opened].contains_key(name) && opened != module;
            known.then(|| self.walk(opened, &[&[name.to_string()], rest].concat(), depth))
        })
    }
}
