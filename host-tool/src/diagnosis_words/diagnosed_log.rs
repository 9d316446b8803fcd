//! What the explanation of a diagnosis is made from, and the words that all its parts use.

use crate::cli::DiagnoseArgs;
use crate::input::Log;
use ironout::effect::Usual;
use ironout_analysis::Diagnosis;
use ironout_analysis::outcome::outcome::{CandidateRow, Status};

/// Lines are at most this wide.
pub const WIDTH: usize = 100;

/// What the explanation is made from.
#[derive(Clone, Copy)]
pub struct DiagnosedLog<'a> {
    /// The log.
    pub log: &'a Log,
    /// What the user asked for.
    pub arguments: &'a DiagnoseArgs,
    /// The answer.
    pub diagnosis: &'a Diagnosis,
}

/// A title with an empty line before it.
pub fn title(out: &mut Vec<String>, text: &str) {
    out.push(String::new());
    out.push(text.to_string());
}

/// `1 sample`, `2 samples`.
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// The name that a person knows the effect by.
pub fn name_of(diagnosis: &Diagnosis, id: &str) -> String {
    let effect = diagnosis.effects.iter().find(|effect| effect.id == id).map(|effect| &effect.name);
    let candidate = diagnosis.candidates.iter().find(|row| row.id == id).map(|row| &row.name);
    let name = effect.or(candidate).map_or(id, String::as_str);
    // A name that does not name its column says little where there are several.
    let usual = [Usual::TEMPERATURE.column, Usual::CURRENT.column];
    match diagnosis.registry.parse(id).filter(|named| named.form.column) {
        Some(named) if !(named.is_plain() && usual.contains(&named.column)) => {
            let column = named.column;
            match name {
                name if name.contains(column) => name.to_string(),
                name if name.contains("a column") => name.replace("a column", column),
                name => format!("{name} ({column})"),
            }
        }
        _ => name.to_string(),
    }
}

/// `a, b and c`.
pub fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Whether the study was of a resting board's vector.
pub fn at_rest(diagnosis: &Diagnosis) -> bool {
    diagnosis.residual == "vector"
}

/// Groups of effects that the log cannot tell apart, by id.
pub fn groups(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let mut groups: Vec<Vec<String>> = Vec::new();
    // A step may stand for others too: it comes first among them.
    let alike = |row: &&CandidateRow| row.status == Status::Confounded || !row.confounded_with.is_empty();
    for row in diagnosis.candidates.iter().filter(alike) {
        let mut ids = vec![row.id.clone()];
        ids.extend(row.confounded_with.iter().cloned());
        match groups.iter_mut().find(|group| group.iter().any(|id| ids.contains(id))) {
            Some(group) => {
                for id in ids {
                    if !group.contains(&id) {
                        group.push(id);
                    }
                }
            }
            None => groups.push(ids),
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_read_as_people_write_them() {
        let names = |list: &[&str]| listed(&list.iter().map(ToString::to_string).collect::<Vec<_>>());
        assert_eq!(names(&[]), "");
        assert_eq!(names(&["a"]), "a");
        assert_eq!(names(&["a", "b", "c"]), "a, b and c");
        assert_eq!(counted(1, "sample"), "1 sample");
        assert_eq!(counted(0, "sample"), "0 samples");
    }
}
