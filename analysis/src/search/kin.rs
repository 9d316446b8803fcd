//! Columns that move together, in the search: what they have in common stands for them.

use crate::base::engine::Fitted;
use crate::base::piece::BadShape;
use crate::search::screen::{Candidate, RELEVANCE, SIGNIFICANCE, screen, stands};
use crate::search::state::{Greedy, Judged, held_out_rms, plain_id};
use std::collections::HashSet;

/// An effect with fewer coefficients may leave this much more error on unseen time.
pub(crate) const NEARLY: f64 = 1.1;
/// What columns have in common is looked at if it takes this much off the squared error of what one of them takes.
const COMMON_SHARE: f64 = 0.5;

/// Whether one model predicts unseen time as well as another, or nearly. With few independent samples an effect of one
/// coefficient can hide one of three from a test of significance though it leaves half of the error.
fn as_good(one: &Fitted, other: &Fitted) -> bool {
    match (held_out_rms(one), held_out_rms(other)) {
        (Some(one), Some(other)) => one < NEARLY * other,
        (one, _) => one.is_some(),
    }
}

/// Whether an effect is a shape in time alone, searched for or not, with no column behind it.
pub(crate) fn in_time(id: &str) -> bool {
    ["drift", "step", "periodic"].contains(&id)
}

/// Whether one effect may take another's place: a shape in time takes that of a logged cause only where it is clearly
/// better.
pub(crate) fn may_follow(from: &str, to: &str, now: &Fitted, next: &Fitted) -> bool {
    if in_time(to) && !in_time(from) {
        return held_out_rms(next).zip(held_out_rms(now)).is_some_and(|(next, now)| NEARLY * next < now);
    }
    as_good(next, now)
}

/// The column of `offset:COLUMN`, squared or late too.
fn offset_column(id: &str) -> Option<&str> {
    plain_id(id).strip_prefix("offset:")
}

impl<'a> Greedy<'_, 'a> {
    /// Whether two effects are of columns that move together.
    pub(crate) fn together(&self, one: &str, other: &str) -> bool {
        offset_column(one)
            .zip(offset_column(other))
            .is_some_and(|(one, other)| self.catalogue.families.together(one, other))
    }

    /// How many candidates there are, columns that move together counted once.
    pub(crate) fn independent(&self, list: &[Candidate]) -> usize {
        let central = |id: &str| match id.split_once(':') {
            Some((kind, rest)) => {
                let column = plain_id(rest);
                let variant = rest.strip_prefix(column).unwrap_or("");
                format!("{kind}:{}{variant}", self.catalogue.families.centre(column))
            }
            None => id.to_string(),
        };
        let ids: HashSet<String> = list.iter().map(|candidate| central(&candidate.piece.id)).collect();
        ids.len()
    }

    /// One channel of several that move together: what they have in common comes first, unless the channel is
    /// significantly better.
    pub(crate) fn for_its_family(
        &self,
        fitted: &Fitted<'a>,
        winner: Judged<'a>,
        judged: &[Judged<'a>],
        count: usize,
    ) -> Result<Judged<'a>, BadShape> {
        let Some(column) = offset_column(&winner.candidate.piece.id) else { return Ok(winner) };
        let id = format!("offset:{}", self.catalogue.families.centre(column));
        let Some(common) = judged
            .iter()
            .find(|one| one.candidate.piece.id == id && id != winner.candidate.piece.id)
            .filter(|one| one.tested.decrease > COMMON_SHARE * winner.tested.decrease)
        else {
            return Ok(winner);
        };
        // Large effects bend the model: the channel is tested beside the common one once that is in it.
        let Some(with) = self.with(fitted, &common.candidate.piece)? else { return Ok(winner) };
        let falls = held_out_rms(fitted)
            .zip(held_out_rms(&with))
            .is_some_and(|(before, after)| after * after < before * before * (1.0 - RELEVANCE));
        let sure = common.tested.accepted
            || (falls
                && stands(&self.pass, &with)?
                    .is_some_and(|test| test.p_value * (count as f64) < SIGNIFICANCE));
        if !sure {
            return Ok(winner);
        }
        let screening = screen(&self.pass, &with, std::slice::from_ref(&winner.candidate), count)?;
        let better = screening.tested.first().is_some_and(|tested| tested.accepted);
        Ok(if better { winner } else { common.clone() })
    }
}
