//! Every path that a module's items name, with its line.

use proc_macro2::{Spacing, TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemUse, LitStr, Macro, UseTree};

/// A path as it is written.
pub struct Named {
    /// Its names; a leading `::` is an empty first one.
    pub names: Vec<String>,
    /// The line it stands in.
    pub line: usize,
    /// What it does to the names of its module.
    pub role: Role,
}

/// What a path is there for.
#[derive(Clone, PartialEq, Eq)]
pub enum Role {
    /// It is used where it stands.
    Inline,
    /// `use path as name;`
    Import(String),
    /// `use path::*;`
    Glob,
}

/// All paths of a module's items. Inline modules are modules of their own and not among the items.
pub fn named_in(items: &[Item]) -> Vec<Named> {
    let mut collect = Collect { found: Vec::new() };
    for item in items {
        collect.visit_item(item);
    }
    collect.found
}

struct Collect {
    found: Vec<Named>,
}

impl Collect {
    fn tree(&mut self, tree: &UseTree, mut names: Vec<String>) {
        match tree {
            UseTree::Path(path) => {
                names.push(path.ident.to_string());
                self.tree(&path.tree, names);
            }
            UseTree::Name(name) => {
                let line = name.ident.span().start().line;
                let mut alias = name.ident.to_string();
                if alias == "self" {
                    alias = names.last().cloned().unwrap_or_default();
                } else {
                    names.push(alias.clone());
                }
                self.found.push(Named { names, line, role: Role::Import(alias) });
            }
            UseTree::Rename(rename) => {
                let line = rename.ident.span().start().line;
                if rename.ident != "self" {
                    names.push(rename.ident.to_string());
                }
                self.found.push(Named { names, line, role: Role::Import(rename.rename.to_string()) });
            }
            UseTree::Glob(glob) => {
                let line = glob.star_token.spans[0].start().line;
                self.found.push(Named { names, line, role: Role::Glob });
            }
            UseTree::Group(group) => {
                for tree in &group.items {
                    self.tree(tree, names.clone());
                }
            }
        }
    }

    /// Paths in tokens that no grammar is known for: macro calls, `macro_rules!`, attributes.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut names: Vec<String> = Vec::new();
        let (mut line, mut colons) = (0, 0);
        for token in tokens {
            match token {
                TokenTree::Ident(ident) => {
                    if colons != 2 {
                        self.end(&mut names, line);
                        line = ident.span().start().line;
                    }
                    names.push(ident.to_string());
                    colons = 0;
                }
                TokenTree::Punct(punct) if punct.as_char() == ':' => {
                    let joined = punct.spacing() == Spacing::Joint || colons == 1;
                    colons = if joined { colons + 1 } else { 0 };
                    if colons == 0 {
                        self.end(&mut names, line);
                    }
                }
                other => {
                    self.end(&mut names, line);
                    colons = 0;
                    if let TokenTree::Group(group) = other {
                        self.tokens(group.stream());
                    }
                }
            }
        }
        self.end(&mut names, line);
    }

    fn end(&mut self, names: &mut Vec<String>, line: usize) {
        let names = std::mem::take(names);
        if names.len() > 1 {
            self.found.push(Named { names, line, role: Role::Inline });
        }
    }
}

impl<'ast> Visit<'ast> for Collect {
    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        let names = if item.leading_colon.is_some() { vec![String::new()] } else { Vec::new() };
        self.tree(&item.tree, names);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let mut names = if path.leading_colon.is_some() { vec![String::new()] } else { Vec::new() };
        names.extend(path.segments.iter().map(|segment| segment.ident.to_string()));
        if let (true, Some(first)) = (names.len() > 1, path.segments.first()) {
            let line = first.ident.span().start().line;
            self.found.push(Named { names, line, role: Role::Inline });
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast Macro) {
        self.visit_path(&call.path);
        self.tokens(call.tokens.clone());
    }

    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        if let syn::Meta::List(list) = &attribute.meta {
            self.tokens(list.tokens.clone());
            // `#[serde(with = "crate::a::b")]`
            for token in list.tokens.clone() {
                let TokenTree::Literal(literal) = token else { continue };
                let line = literal.span().start().line;
                let text = syn::parse2::<LitStr>(TokenTree::Literal(literal).into());
                if let Some(path) = text.ok().and_then(|text| text.parse::<syn::Path>().ok()) {
                    let names: Vec<_> =
                        path.segments.iter().map(|segment| segment.ident.to_string()).collect();
                    if names.len() > 1 {
                        self.found.push(Named { names, line, role: Role::Inline });
                    }
                }
            }
        }
    }

    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        // Inside a function's body; elsewhere modules are not among the items.
        visit::visit_item_mod(self, module);
    }
}
