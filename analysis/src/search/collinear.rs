//! Columns that move together, in the search: what they have in common stands for them.

use crate::base::term::Term;
use crate::search::state::Fitter;
use ironout::effect::Named;
use std::collections::HashSet;

impl<'a> Fitter<'_, 'a> {
    /// How many candidates there are, columns that move together counted once.
    pub(crate) fn independent(&self, list: &[Term]) -> usize {
        let central = |term: &Term| match term.named() {
            Some(Named { family, column, form }) => {
                Named { family, column: self.catalogue.families.centre(column), form }.to_string()
            }
            None => term.id.clone(),
        };
        let ids: HashSet<String> = list.iter().map(central).collect();
        ids.len()
    }
}
