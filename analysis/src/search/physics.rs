//! What a name may mean: a temperature does not change the Earth's field.
//!
//! A sensitivity that follows a temperature scales what the element feels, and not what the amplifier adds to it. Beside a
//! large offset of the electronics that looks like a field that follows the temperature: it is a gain and an offset of the
//! same column, three coefficients each.

use crate::base::engine::Fitted;
use crate::base::term::{BadShape, Term};
use crate::search::state::{Greedy, MOST_EFFECTS, held_out_rms};
use ironout::effect::{Acts, ColumnKind};
use ironout::study::rule::NEARLY;

/// The temperature that a field is said to follow.
pub(crate) fn field_of_a_temperature<'p>(term: &'p Term) -> Option<&'p str> {
    let column = term.parts().filter(|_| term.acts(Acts::Field)).map(|parts| parts.column);
    column.filter(|column| ColumnKind::of(column) == ColumnKind::Temperature)
}

impl<'a> Greedy<'_, 'a> {
    /// The model with what a temperature does to the sensor instead of the field that has just been found to follow it, where that
    /// hardly leaves more on held-out time: a gain, or gain and offset; their ids, and the model.
    pub(crate) fn of_the_sensor(
        &self,
        before: &Fitted<'a>,
        field: &str,
        with: &Fitted<'a>,
    ) -> Result<Option<(Vec<String>, Fitted<'a>)>, BadShape> {
        let found = with.terms.iter().find(|term| term.id == field);
        let Some(column) = found.and_then(field_of_a_temperature) else { return Ok(None) };
        let plain = self.catalogue.plain(false);
        let own = |acts: Acts| {
            let is_it = |term: &&Term<'a>| {
                term.acts(acts)
                    && term.is_plain()
                    && term.parts().is_some_and(|parts| parts.form.column && parts.column == column)
            };
            plain.iter().find(is_it).filter(|own| before.terms.iter().all(|term| term.id != own.id)).cloned()
        };
        let Some(gain) = own(Acts::Measured) else { return Ok(None) };
        let offset = own(Acts::Added).filter(|_| before.terms.len() + 2 <= MOST_EFFECTS);
        let both = offset.as_ref().map(|offset| vec![&gain, offset]);
        for more in std::iter::once(vec![&gain]).chain(both) {
            let Some(next) = self.with_all(before, more.iter().copied())? else { continue };
            let no_worse =
                held_out_rms(&next).zip(held_out_rms(with)).is_some_and(|(own, field)| own < NEARLY * field);
            if no_worse {
                return Ok(Some((more.into_iter().map(|term| term.id.clone()).collect(), next)));
            }
        }
        Ok(None)
    }
}
