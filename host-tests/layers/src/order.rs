//! The declared order: tables in `host-tests/layers/ROOMS.md`, for people first.
//!
//! ```text
//! ## Order of crates
//! | crate | knows | must never know |
//!
//! ## Order of rooms: `crate`              (its library)
//! ## Order of rooms: `crate` / `program`  (a program, test, bench or example of its own)
//! | room | knows | must never know |
//!
//! ## Not yet in order
//! | file | imports | why |
//! ```
//!
//! The names in backticks of the first column count, from the lowest to the highest: each imports only what stands before
//! it. A room is a module with everything in it, `a` or `a::b`; the deepest that is declared holds a file. The root of a
//! crate stands above its rooms.

use std::collections::BTreeMap;

/// An arrow that is wrong and known to be, both files from the workspace's root.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotYet {
    /// The file that imports.
    pub from: String,
    /// What it imports.
    pub to: String,
    /// Why it is still there.
    pub why: String,
}

/// What the tables say.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Order {
    /// Crates, lowest first.
    pub crates: Vec<String>,
    /// Rooms of each library (`crate`) or other target (`crate / target`), lowest first.
    pub rooms: BTreeMap<String, Vec<String>>,
    /// Wrong arrows that are known.
    pub not_yet: Vec<NotYet>,
}

enum Section {
    Other,
    Crates,
    Rooms(String),
    NotYet,
}

impl Order {
    /// Reads the tables of a document.
    pub fn parse(text: &str) -> Self {
        let mut order = Self::default();
        let mut section = Section::Other;
        for line in text.lines() {
            if let Some(heading) = line.strip_prefix('#') {
                let heading = heading.trim_start_matches('#').trim();
                section = if heading == "Order of crates" {
                    Section::Crates
                } else if let Some(names) = heading.strip_prefix("Order of rooms:") {
                    let key = quoted(names).join(" / ");
                    order.rooms.insert(key.clone(), Vec::new());
                    Section::Rooms(key)
                } else if heading == "Not yet in order" {
                    Section::NotYet
                } else {
                    Section::Other
                };
                continue;
            }
            let Some(row) = line.trim().strip_prefix('|') else { continue };
            let cells: Vec<_> = row.split('|').map(str::trim).collect();
            let names = cells.first().map(|cell| quoted(cell)).unwrap_or_default();
            match &section {
                Section::Other => {}
                Section::Crates => order.crates.extend(names),
                Section::Rooms(key) => {
                    if let Some(rooms) = order.rooms.get_mut(key) {
                        rooms.extend(names);
                    }
                }
                Section::NotYet => {
                    let to = cells.get(1).map(|cell| quoted(cell)).unwrap_or_default();
                    let why = cells.get(2).copied().unwrap_or_default();
                    for from in &names {
                        for to in &to {
                            let (from, to, why) = (from.clone(), to.clone(), why.to_string());
                            order.not_yet.push(NotYet { from, to, why });
                        }
                    }
                }
            }
        }
        order
    }
}

/// What stands in backticks.
fn quoted(text: &str) -> Vec<String> {
    text.split('`').skip(1).step_by(2).map(String::from).collect()
}

/// The place of the deepest declared room that holds a module: among `rooms`, or above all for the root.
pub fn rank(rooms: &[String], module: &[String]) -> Option<usize> {
    if module.is_empty() {
        return Some(usize::MAX);
    }
    let holds = |room: &str| {
        let names: Vec<_> = room.split("::").collect();
        (module.len() >= names.len() && module.iter().zip(&names).all(|(a, b)| a == b)).then_some(names.len())
    };
    let depth = |index: &usize| holds(&rooms[*index]).unwrap_or_default();
    (0..rooms.len()).filter(|index| depth(index) > 0).max_by_key(depth)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_and_the_deepest_room_holds() {
        let order = Order::parse(
            "# A\n| `no` | x |\n## Order of crates\n| crate | knows |\n|---|---|\n| `low`, `mid` | much |\n| `high` | all |\n\
             ## Order of rooms: `low`\n| `a` |\n| `a::b` |\n## Order of rooms: `low` / `prog`\n| `x` |\n\
             ## Not yet in order\n| `f.rs` | `g.rs` | later |\n",
        );
        assert_eq!(order.crates, ["low", "mid", "high"]);
        assert_eq!(order.rooms["low"], ["a", "a::b"]);
        assert_eq!(order.rooms["low / prog"], ["x"]);
        assert_eq!(order.not_yet, [NotYet { from: "f.rs".into(), to: "g.rs".into(), why: "later".into() }]);
        let at = |path: &[&str]| {
            rank(&order.rooms["low"], &path.iter().map(|name| name.to_string()).collect::<Vec<_>>())
        };
        assert_eq!(at(&["a", "c"]), Some(0));
        assert_eq!(at(&["a", "b", "c"]), Some(1));
        assert_eq!(at(&["c"]), None);
        assert_eq!(at(&[]), Some(usize::MAX));
    }
}
