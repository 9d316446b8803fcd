//! Columns that move together, in the search: what they have in common stands for them.

use crate::base::engine::Fitted;
use crate::base::term::{BadShape, Term};
use crate::search::physics::field_of_a_temperature;
use crate::search::screen::{RELEVANCE, SIGNIFICANCE, stands};
use crate::search::state::{Greedy, Judged, held_out_rms};
use ironout::effect::{Acts, Follows, Named};
pub(crate) use ironout::study::rule::NEARLY;
use std::collections::HashSet;

/// What columns have in common is looked at if it takes this much off the squared error of what one of them takes.
const COMMON_SHARE: f64 = 0.5;

/// Whether one model predicts held-out time as well as another, or nearly. With few independent samples an effect of one
/// coefficient can hide one of three from a test of significance though it leaves half of the error.
fn as_good(one: &Fitted, other: &Fitted) -> bool {
    match (held_out_rms(one), held_out_rms(other)) {
        (Some(one), Some(other)) => one < NEARLY * other,
        (one, _) => one.is_some(),
    }
}

/// Whether one effect may take another's place: a shape in time takes that of a logged cause only where it is clearly
/// better, and no field follows a temperature where the sensor does.
pub(crate) fn may_follow(from: &Term, to: &Term, now: &Fitted, next: &Fitted) -> bool {
    let column = |term: &Term| term.parts().map(|parts| parts.column.to_owned());
    if field_of_a_temperature(to).is_some_and(|own| column(from).as_deref() == Some(own)) {
        return false;
    }
    if to.is_in_time() && !from.is_in_time() {
        return held_out_rms(next).zip(held_out_rms(now)).is_some_and(|(next, now)| NEARLY * next < now);
    }
    as_good(next, now)
}

/// The column of an effect that adds a vector of its own, squared or late too: what several columns of one cause have in
/// common adds up in such effects.
fn added_by<'a>(term: &Term<'a>) -> Option<&'a str> {
    let adds = term.acts(Acts::Added) && term.follows(Follows::Column);
    term.parts().filter(|parts| adds && parts.form.column).map(|parts| parts.column)
}

impl<'a> Greedy<'_, 'a> {
    /// Whether two effects are of columns that move together.
    pub(crate) fn together(&self, one: &Term, other: &Term) -> bool {
        let kind = |term: &Term| term.named().map(|named| named.family.kind());
        kind(one) == kind(other)
            && added_by(one)
                .zip(added_by(other))
                .is_some_and(|(one, other)| self.catalogue.families.together(one, other))
    }

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

    /// One channel of several that move together: what they have in common comes first, unless the channel predicts held-out time
    /// better.
    pub(crate) fn for_its_family(
        &self,
        fitted: &Fitted<'a>,
        winner: Judged<'a>,
        judged: &[Judged<'a>],
        count: usize,
    ) -> Result<Judged<'a>, BadShape> {
        let own = &winner.term;
        let (Some(column), Some(named)) = (added_by(own), own.named()) else { return Ok(winner) };
        let centre = self.catalogue.families.centre(column);
        // Which form of one column it is has been tested already, and a column is not what it has in common with itself.
        if centre == column {
            return Ok(winner);
        }
        let stands_for_all = |other: &Term| {
            let kind = other.named().map(|other| other.family.kind());
            kind == Some(named.family.kind()) && other.is_plain() && added_by(other) == Some(centre)
        };
        let Some(common) = judged
            .iter()
            .find(|one| stands_for_all(&one.term) && one.term.id != own.id)
            .filter(|one| one.tested.decrease > COMMON_SHARE * winner.tested.decrease)
        else {
            return Ok(winner);
        };
        // Whichever predicts held-out time better; as well as the other, what they have in common.
        let Some(with) = self.with(fitted, &common.term)? else { return Ok(winner) };
        let squares = |fit: &Fitted| held_out_rms(fit).map(|rms| rms * rms);
        let falls = squares(fitted)
            .zip(squares(&with))
            .is_some_and(|(before, after)| after < before * (1.0 - RELEVANCE));
        let sure = common.tested.accepted
            || (falls
                && stands(&self.design, &with)?
                    .is_some_and(|test| test.p_value * (count as f64) < SIGNIFICANCE));
        if !sure {
            return Ok(winner);
        }
        let own = self.with(fitted, &winner.term)?.as_ref().and_then(squares);
        let better = own.zip(squares(&with)).is_some_and(|(own, common)| own * (1.0 + RELEVANCE) < common);
        Ok(if better { winner } else { common.clone() })
    }
}
