//! Several steps, several tones: each a candidate of its own, with its place and size, numbered from the second on.

use crate::base::engine::Fitted;
use crate::base::term::Term;
use crate::search::state::Explanation;

/// A model holds so many of a kind.
const MOST_OF_A_KIND: usize = 4;

/// The kind of an effect that a log may hold several of.
fn kind(term: &Term) -> Option<&'static str> {
    let named = term.named()?;
    named.form.is_repeated().then(|| named.family.kind())
}

fn id(kind: &str, number: usize) -> String {
    if number == 1 { kind.into() } else { format!("{kind}#{number}") }
}

/// The next of its kind beside those in the model; `None` where the model holds enough of them.
pub(crate) fn numbered<'a>(fitted: &Fitted, candidate: Term<'a>) -> Option<Term<'a>> {
    let Some(kind) = kind(&candidate) else { return Some(candidate) };
    let is_free = |id: &String| !fitted.terms.iter().any(|term| term.id == *id);
    let id = (1..=MOST_OF_A_KIND).map(|number| id(kind, number)).find(is_free)?;
    Some(Term { id, ..candidate })
}

impl Explanation<'_> {
    /// Numbers what there are several of in the order in which they were added: one of them may have gone.
    pub(crate) fn renumber(&mut self) {
        let mut names: Vec<(String, String)> = Vec::new();
        let order: Vec<String> = self.steps.iter().filter_map(|step| step.added.clone()).collect();
        let place = |term: &Term| order.iter().position(|id| *id == term.id);
        let mut terms: Vec<&Term> = self.fitted.terms.iter().collect();
        terms.sort_by_key(|term| place(term));
        let mut seen: Vec<&str> = Vec::new();
        for term in terms {
            if let Some(kind) = kind(term) {
                seen.push(kind);
                let number = seen.iter().filter(|own| **own == kind).count();
                names.push((term.id.clone(), id(kind, number)));
            }
        }
        let rename = |own: &mut String| {
            if let Some((_, new)) = names.iter().find(|(old, _)| old == own) {
                own.clone_from(new);
            }
        };
        self.fitted.terms.iter_mut().for_each(|term| rename(&mut term.id));
        self.steps.iter_mut().filter_map(|step| step.added.as_mut()).for_each(rename);
        let groups = self.confounded.iter_mut();
        groups.flat_map(|group| &mut group.ids).for_each(rename);
    }
}
