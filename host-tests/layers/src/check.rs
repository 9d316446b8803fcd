//! The check itself: crates, trees, arrows and lengths against the declared order.

use crate::arrows::{Arrow, arrows};
use crate::circles::circles;
use crate::finding::{Finding, Import, MOST_LINES, Report};
use crate::order::{NotYet, Order, rank};
use crate::tree::Tree;
use crate::workspace::{Crate, Target, code_files, crates};
use std::collections::BTreeSet;
use std::path::Path;

/// Checks every crate below `root`, the folder of the workspace's manifest.
///
/// # Errors
/// A sentence, where the crates or the declared order cannot be read at all.
pub fn check_workspace(root: &Path) -> Result<Report, String> {
    let document = root.join("host-tests/layers/ROOMS.md");
    let text =
        std::fs::read_to_string(&document).map_err(|error| format!("{}: {error}", document.display()))?;
    let order = Order::parse(&text);
    let crates = crates(root)?;
    let mut check = Check { root, order: &order, report: Report::default(), met: BTreeSet::new() };
    check.report.crates = crates.len();
    check.report.rooms = order.rooms.values().map(Vec::len).sum();
    check.crates(&crates);
    for target in crates.iter().flat_map(|one| &one.targets) {
        check.target(target);
    }
    let targets: BTreeSet<_> =
        crates.iter().flat_map(|one| &one.targets).map(|target| &target.name).collect();
    for name in order.rooms.keys().filter(|name| !targets.contains(name)) {
        let (target, room) = ("Order of rooms".to_string(), name.clone());
        check.report.findings.push(Finding::EmptyRoom { target, room });
    }
    check.lengths();
    check.known();
    Ok(check.report)
}

struct Check<'a> {
    root: &'a Path,
    order: &'a Order,
    report: Report,
    /// Places in the list of known wrong arrows that were met.
    met: BTreeSet<usize>,
}

impl Check<'_> {
    /// A path as people say it.
    fn say(&self, path: &Path) -> String {
        path.strip_prefix(self.root).unwrap_or(path).to_string_lossy().replace('\\', "/")
    }

    fn crates(&mut self, crates: &[Crate]) {
        let place = |name: &str| self.order.crates.iter().position(|other| other == name);
        let mut findings = Vec::new();
        for one in crates.iter().filter(|one| one.member) {
            let Some(own) = place(&one.name) else {
                findings.push(Finding::CrateUndeclared { name: one.name.clone() });
                continue;
            };
            for other in &one.depends_on {
                if place(other).is_none_or(|other| other >= own) {
                    findings.push(Finding::CrateUpward { from: one.name.clone(), to: other.clone() });
                }
            }
        }
        for room in self.order.crates.iter().filter(|name| !crates.iter().any(|one| one.name == **name)) {
            let target = "Order of crates".to_string();
            findings.push(Finding::EmptyRoom { target, room: room.clone() });
        }
        self.report.findings.extend(findings);
    }

    fn target(&mut self, target: &Target) {
        self.report.targets += 1;
        let tree = match Tree::read(&target.root) {
            Ok(tree) => tree,
            Err(why) => return self.report.findings.push(Finding::Unreadable { why }),
        };
        let (mut arrows, paths) = arrows(&tree);
        self.report.files += tree.files.len();
        self.report.paths += paths;
        self.report.imports +=
            arrows.iter().map(|arrow| (arrow.from, arrow.to)).collect::<BTreeSet<_>>().len();
        arrows.retain(|arrow| !self.is_known(&tree, arrow));
        self.circles(target, &tree, &arrows);
        self.rooms(target, &tree, &arrows);
    }

    fn import(&self, tree: &Tree, arrow: &Arrow) -> Import {
        let (from, to) = (self.say(&tree.files[arrow.from].path), self.say(&tree.files[arrow.to].path));
        Import { from, line: arrow.line, text: arrow.text.clone(), to }
    }

    fn is_known(&mut self, tree: &Tree, arrow: &Arrow) -> bool {
        let import = self.import(tree, arrow);
        let listed = |known: &NotYet| known.from == import.from && known.to == import.to;
        let Some(place) = self.order.not_yet.iter().position(listed) else { return false };
        if self.met.insert(place) {
            self.report.not_yet.push(format!("{import} ({})", self.order.not_yet[place].why));
        }
        true
    }

    fn circles(&mut self, target: &Target, tree: &Tree, arrows: &[Arrow]) {
        for members in circles(tree.files.len(), arrows) {
            let files = members.iter().map(|file| self.say(&tree.files[*file].path)).collect();
            let among =
                arrows.iter().filter(|arrow| members.contains(&arrow.from) && members.contains(&arrow.to));
            let imports = among.map(|arrow| self.import(tree, arrow)).collect();
            self.report.findings.push(Finding::Circle { target: target.name.clone(), files, imports });
        }
    }

    fn rooms(&mut self, target: &Target, tree: &Tree, arrows: &[Arrow]) {
        let name = || target.name.clone();
        let Some(rooms) = self.order.rooms.get(&target.name) else {
            // A library of one module, and a program's or test's few files, need none.
            if target.library
                && tree.modules[0].children.values().filter(|child| tree.file_of(**child) > 0).count() > 1
            {
                self.report.findings.push(Finding::NoOrder { target: name() });
            }
            return;
        };
        let module = |file: usize| tree.modules[tree.files[file].module].path.as_slice();
        let mut ranks = Vec::new();
        for (number, file) in tree.files.iter().enumerate() {
            let rank = rank(rooms, module(number));
            if rank.is_none() {
                self.report.findings.push(Finding::NoRoom { target: name(), file: self.say(&file.path) });
            }
            ranks.push(rank);
        }
        for room in rooms.iter().enumerate().filter(|(place, _)| !ranks.contains(&Some(*place))) {
            self.report.findings.push(Finding::EmptyRoom { target: name(), room: room.1.clone() });
        }
        let word = |rank: usize| rooms.get(rank).map_or("the crate's root", String::as_str).to_string();
        for arrow in arrows {
            let (Some(from), Some(to)) = (ranks[arrow.from], ranks[arrow.to]) else { continue };
            if to > from {
                let (from, to, import) = (word(from), word(to), self.import(tree, arrow));
                self.report.findings.push(Finding::Upward { target: name(), from, to, import });
            }
        }
    }

    fn lengths(&mut self) {
        for path in code_files(self.root) {
            let file = self.say(&path);
            self.report.measured += 1;
            match std::fs::read_to_string(&path) {
                Ok(text) => {
                    let lines = text.lines().count();
                    if lines > MOST_LINES {
                        self.report.findings.push(Finding::TooLong { file, lines });
                    }
                }
                Err(error) => {
                    self.report.findings.push(Finding::Unreadable { why: format!("{file}: {error}") })
                }
            }
        }
    }

    /// A list of what is wrong must not outlive it.
    fn known(&mut self) {
        for (place, NotYet { from, to, .. }) in self.order.not_yet.iter().enumerate() {
            if !self.met.contains(&place) {
                self.report.findings.push(Finding::NotThereAnyMore { from: from.clone(), to: to.clone() });
            }
        }
    }
}
