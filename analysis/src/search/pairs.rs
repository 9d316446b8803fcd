//! Two effects that hide each other: each alone is lost in the structure that the other leaves.

use crate::base::engine::Fitted;
use crate::base::quality::residue;
use crate::base::term::{BadShape, COLUMNS, Matrix, TERMS, Term};
use crate::search::screen::{SIGNIFICANCE, ranges, ridge, rivalry};
use crate::search::search;
use crate::search::several::numbered;
use crate::search::state::{Greedy, Judged, held_out_rms};
use ironout::effect::{Named, Searched};
use ironout::study::held_out;

/// Candidates of which pairs are made, those first that take off the most by themselves.
const LEADERS: usize = 14;
/// Pairs that are looked at closely.
const CLOSE: usize = 3;
/// A pair leaves at most this share of the squared held-out error: it is the last resort, not a refinement.
const LEAVES: f64 = 0.7;

impl<'a> Greedy<'_, 'a> {
    /// The model with the two candidates that explain together what neither does alone, where structure remains: their
    /// ids, the stronger first. Each must be certain beside the other, with all pairs as the number of tries.
    pub(crate) fn pair(
        &self,
        fitted: &Fitted<'a>,
        judged: &[Judged<'a>],
    ) -> Result<Option<([String; 2], Fitted<'a>)>, BadShape> {
        let inner: Vec<&Term> = fitted.terms.iter().collect();
        let residuals = self.design.residuals(&fitted.model, &inner)?;
        let samples = self.design.samples;
        let left = residue(
            &residuals,
            fitted.columns(),
            samples.quantum_ut,
            samples.step_s(),
            &self.design.turning(&fitted.model),
        );
        if left.structure <= 0.0 {
            return Ok(None);
        }
        let base = fitted.columns();
        let mut leaders: Vec<&Judged> = judged.iter().filter(|one| one.tested.directions > 0).collect();
        leaders.sort_by(|a, b| b.tested.decrease.total_cmp(&a.tested.decrease));
        let mut columns = base;
        leaders.truncate(LEADERS.min(TERMS.saturating_sub(inner.len())));
        leaders.retain(|one| {
            let wide = columns + one.term.k();
            let fits = wide <= COLUMNS;
            columns = if fits { wide } else { columns };
            fits
        });
        let batch: Vec<&Term> = leaders.iter().map(|one| &one.term).collect();
        let all: Vec<&Term> = inner.iter().chain(&batch).copied().collect();
        let blocks = self.design.blocks(&self.design.folds(&all), &fitted.model, &all)?;
        let prior = ridge(&fitted.prior, &Matrix::total(&blocks, Some(&fitted.prior)), base);
        let spans = ranges(base, &batch);
        let own: Vec<usize> = (0..base).collect();
        let Some(alone) = held_out(&blocks, Some(&prior), &own) else { return Ok(None) };
        let leaves = LEAVES * alone.squares / fitted.rows.max(1.0);
        let mut pairs = Vec::new();
        for (i, first) in spans.iter().enumerate() {
            for (j, second) in spans.iter().enumerate().skip(i + 1) {
                let keep: Vec<usize> =
                    own.iter().copied().chain(first.clone()).chain(second.clone()).collect();
                let held = held_out(&blocks, Some(&prior), &keep).map(|held| held.squares);
                pairs.extend(held.filter(|held| *held < LEAVES * alone.squares).map(|held| (held, i, j)));
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        // All candidates could have made a pair, not the leaders alone.
        let tries = (judged.len() * judged.len().saturating_sub(1) / 2) as f64;
        let mut best: Option<(f64, [String; 2], Fitted<'a>)> = None;
        let steps = self.two_steps(fitted)?;
        let close = pairs.into_iter().take(CLOSE).map(|(_, i, j)| [&leaders[i].term, &leaders[j].term]);
        for [a, b] in close.chain(steps.iter().map(|[a, b]| [a, b])) {
            let Some(two) = rivalry(&self.design, fitted, a, b, self.known)? else { continue };
            let certain = |p: f64, searched: f64| p * searched * tries < SIGNIFICANCE;
            if !certain(two.first, a.trials) || !certain(two.second, b.trials) {
                continue;
            }
            let mut terms = fitted.terms.clone();
            terms.extend([a.clone(), b.clone()]);
            let Some(next) = self.design.fit(fitted.model, terms, self.known)? else { continue };
            let next = self.settled(next)?;
            if !self.each_beats_its_copies(&next, fitted.terms.len())? {
                continue;
            }
            let Some(held) = held_out_rms(&next).filter(|held| held * held < leaves) else { continue };
            if best.as_ref().is_none_or(|(least, ..)| held < *least) {
                best = Some((held, [a.id.clone(), b.id.clone()], next));
            }
        }
        Ok(best.map(|(_, ids, next)| (ids, next)))
    }

    /// The step that goes and comes back, and the last two of three that hide each other.
    fn two_steps(&self, fitted: &Fitted<'a>) -> Result<Option<[Term<'a>; 2]>, BadShape> {
        let repeated = |named: &Named| named.form.searched == Some(Searched::At);
        let Some(named) = self.catalogue.searched().into_iter().find(repeated) else { return Ok(None) };
        let Some([first, second]) = search::two_steps(&self.design, fitted, self.catalogue, &named)? else {
            return Ok(None);
        };
        let Some(first) = numbered(fitted, first) else { return Ok(None) };
        let mut with = fitted.clone();
        with.terms.push(first.clone());
        Ok(numbered(&with, second).map(|second| [first, second]))
    }

    /// Whether each effect from the place `from` on does what no copy of its column does, beside the others.
    fn each_beats_its_copies(&self, both: &Fitted<'a>, from: usize) -> Result<bool, BadShape> {
        for place in from..both.terms.len() {
            let mut others = both.terms.clone();
            let own = others.remove(place);
            let Some(without) = self.design.fit(both.model, others, self.known)? else { return Ok(false) };
            if !self.beats_its_copies(&without, &own)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}
