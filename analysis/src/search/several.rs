//! Several steps, several tones: each a candidate of its own, with its place and size, numbered from the second on.

use crate::base::engine::Fitted;
use crate::base::term::Term;

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
