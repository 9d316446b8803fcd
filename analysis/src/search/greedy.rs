//! Effects added one at a time until none helps, earlier ones dropped when they no longer do.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, Term};
use crate::evidence::select::{Begin, select};
use crate::search::candidates::Catalogue;
use crate::search::collinear::may_follow;
use crate::search::screen::{SIGNIFICANCE, rivalry, screen};
use crate::search::search;
use crate::search::several::numbered;
use crate::search::state::{Confounded, Explanation, Greedy, Judged, MOST_EFFECTS};
use crate::search::true_field::prefer;
use ironout::effect::{Acts, Follows, Named, Searched};
use ironout::study::Residual;
use ironout::study::rule::{ALIKE, RIVAL_SHARE};

/// The same at rest, where a coil has a prompt, a late and a squared part.
pub const MOST_AT_REST: usize = 9;

/// Candidates explain the same if the squared held-out error with the one is at most this many times the other's.
const NO_WORSE: f64 = 2.0;

/// The candidates of one round, the searched ones at their best places.
fn candidates<'a>(
    design: &Design,
    catalogue: &Catalogue<'a>,
    fitted: &Fitted<'a>,
    periodic: bool,
) -> Result<Vec<Term<'a>>, BadShape> {
    let at_rest = design.residual == Residual::Vector;
    let mut list = catalogue.plain(at_rest);
    for named in catalogue.searched() {
        if periodic || named.form.searched != Some(Searched::Frequency) {
            let found = finite(search::best(design, fitted, catalogue, &named))?.flatten();
            list.extend(found.and_then(|found| numbered(fitted, found)));
        }
    }
    for named in catalogue.usable_columns().flat_map(|column| catalogue.late(column)) {
        // Of a board at rest the vector shows a column's past by a delay; a low-pass beside it is hardly another shape.
        if at_rest && named.form.searched == Some(Searched::TimeConstant) {
            continue;
        }
        // A late column stands beside the prompt one, or shows through it.
        let is_prompt = |own: Named| own.is_plain() && own.is_variant_of(&named);
        if fitted.terms.iter().filter_map(Term::named).any(is_prompt) {
            list.extend(finite(search::best(design, fitted, catalogue, &named))?.flatten());
        } else if !at_rest
            // Through a low-pass any column becomes smooth, and smooth shapes imitate each other: by heredity only.
            && named.form.searched != Some(Searched::TimeConstant)
            && finite(search::acts_late(design, fitted, catalogue, &named))?.unwrap_or(false)
        {
            // A long delay leaves little of the prompt one to show through.
            list.extend(finite(search::best(design, fitted, catalogue, &named))?.flatten());
        }
    }
    list.retain(|candidate| !fitted.terms.iter().any(|term| term.id == candidate.id));
    Ok(list)
}

/// What was found, unless some shape was not finite on the way.
pub(super) fn finite<T>(found: Result<T, BadShape>) -> Result<Option<T>, BadShape> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(BadShape::NotFinite(_)) => Ok(None),
        Err(bad) => Err(bad),
    }
}

// One at a time, on the stack: the size does not matter.
#[allow(clippy::large_enum_variant)]
enum Reconsidered<'a> {
    /// Another candidate is better than one in the model.
    Swap { from: String, to: String, fitted: Box<Fitted<'a>> },
    /// All stand; some of them with rivals that explain as much.
    Stands { confounded: Vec<Confounded>, families: Vec<Confounded> },
}

/// Whether one leaves hardly more held-out error than another: what leaves much more does not explain the same.
fn as_good(one: &Judged, other: &Judged) -> bool {
    match (one.tested.held_out, other.tested.held_out) {
        (Some(one), Some(other)) => one <= NO_WORSE * other,
        (one, other) => one.is_some() || other.is_none(),
    }
}

impl<'a> Greedy<'_, 'a> {
    fn judge(&self, fitted: &Fitted<'a>, periodic: bool) -> Result<(Vec<Judged<'a>>, usize), BadShape> {
        let mut list = candidates(&self.design, self.catalogue, fitted, periodic)?;
        if self.held() {
            // Whatever turns with the board would stand in for the soft iron that is held, a coupling of nine numbers to
            // its turning too, and with little attitude a stronger field and an offset along it are the same.
            let turns = |term: &Term| {
                [Acts::Measured, Acts::Field, Acts::Turning].iter().any(|acts| term.acts(*acts))
            };
            list.retain(|candidate| !turns(candidate));
        }
        list.retain(|candidate| !self.dropped.borrow().contains(&candidate.id));
        let count = self.independent(&list);
        let tested = loop {
            match screen(&self.design, fitted, &list, count) {
                // One candidate that runs away is no reason to give up the others.
                Err(BadShape::NotFinite(id)) if list.iter().any(|one| one.id == id) => {
                    list.retain(|one| one.id != id);
                    self.dropped.borrow_mut().push(id);
                }
                tested => break tested?,
            }
        };
        let mut judged: Vec<Judged> = tested
            .into_iter()
            .filter_map(|tested| Some(Judged { term: list.get(tested.index)?.clone(), tested }))
            .collect();
        self.judge_strong(fitted, &mut judged, count)?;
        Ok((judged, count))
    }

    /// The model with the effects that stand in it from the beginning and those that the likelihood selects.
    pub fn selected(&self, start: Fitted<'a>) -> Result<Explanation<'a>, BadShape> {
        let start = self.aligned(start)?;
        let base = match start.terms.is_empty() {
            true => start.clone(),
            false => self.design.fit(start.model, Vec::new(), self.known)?.unwrap_or_else(|| start.clone()),
        };
        let begin = Begin {
            model: &start.model,
            known: self.known,
            stay: &start.terms,
            is_at_rest: self.design.residual == Residual::Vector,
        };
        let trace = std::env::var("TRACE").is_ok();
        let found = select(self.design.samples, self.catalogue.table(), self.catalogue.registry, &begin, trace)
            .unwrap_or_default();
        let mut fitted = start;
        let mut order: Vec<String> = fitted.terms.iter().map(|term| term.id.clone()).collect();
        let mut confounded = Vec::new();
        for one in &found.found {
            let Some(named) = self.catalogue.registry.parse(&one.id) else { continue };
            let Some(term) = self.catalogue.build(&named, one.parameter) else { continue };
            let Some(term) = numbered(&fitted, Term { trials: one.places, ..term }) else { continue };
            let id = term.id.clone();
            match self.with(&fitted, &term)? {
                Some(next) => {
                    fitted = self.aligned(prefer(&self.design, next, None, self.known)?)?;
                    if !one.rivals.is_empty() {
                        let ids = std::iter::once(id.clone()).chain(one.rivals.iter().cloned()).collect();
                        confounded.push(Confounded { ids });
                    }
                    order.push(id);
                }
                None => eprintln!("cannot fit {id}"),
            }
        }
        let (first, count) = self.judge(&base, true)?;
        let last = if order.is_empty() { first.clone() } else { self.judge(&fitted, true)?.0 };
        let steps = self.falling(&base, &fitted, &order)?;
        Ok(Explanation {
            base,
            fitted,
            steps,
            confounded,
            families: Vec::new(),
            first,
            last,
            withdrawn: Vec::new(),
            dropped: self.dropped.take(),
            ended_early: found.ended_early,
            count,
            chances: Vec::new(),
            shown: Vec::new(),
        })
    }

    /// Runs the search from a base model and the effects that stand in it from the beginning.
    pub fn run(&self, start: Fitted<'a>) -> Result<Explanation<'a>, BadShape> {
        let mut fitted = self.aligned(start)?;
        let base = match fitted.terms.is_empty() {
            true => fitted.clone(),
            false => self.design.fit(fitted.model, Vec::new(), self.known)?.unwrap_or_else(|| fitted.clone()),
        };
        let mut order: Vec<String> = fitted.terms.iter().map(|term| term.id.clone()).collect();
        let mut first = None;
        let (mut last, mut count) = (Vec::new(), 0);
        let (mut confounded, mut families) = (Vec::new(), Vec::new());
        let mut swapped: Vec<(String, String)> = Vec::new();
        let mut ended_early = false;
        for round in 0..3 * MOST_AT_REST {
            if self.is_spent() {
                ended_early = true;
                break;
            }
            // What stands is not given up because something ran away beside it.
            let Some((judged, tried)) = finite(self.judge(&fitted, true))? else {
                ended_early = true;
                break;
            };
            count = tried;
            first.get_or_insert_with(|| judged.clone());
            last = judged;
            let most = if self.design.residual == Residual::Vector { MOST_AT_REST } else { MOST_EFFECTS };
            let next =
                if fitted.terms.len() < most { finite(self.choose(&fitted, &last, count))? } else { None };
            let next = next.flatten();
            if let Some((winner, next)) = next {
                let next = match finite(self.of_the_sensor(&fitted, &winner, &next))?.flatten() {
                    Some((own, next)) => {
                        order.extend(own);
                        next
                    }
                    None => {
                        order.push(winner);
                        next
                    }
                };
                fitted = self.aligned(prefer(&self.design, next, None, self.known)?)?;
                while let Some((dropped, without)) = finite(self.drop_one(&fitted))?.flatten() {
                    order.retain(|id| *id != dropped);
                    fitted = self.aligned(without)?;
                }
                continue;
            }
            if fitted.terms.len() + 2 <= MOST_EFFECTS
                && let Some((both, next)) = finite(self.pair(&fitted, &last))?.flatten()
            {
                fitted = self.aligned(next)?;
                order.extend(both);
                while let Some((dropped, without)) = finite(self.drop_one(&fitted))?.flatten() {
                    order.retain(|id| *id != dropped);
                    fitted = self.aligned(without)?;
                }
                continue;
            }
            // Nothing more to add: now that all is in, is each effect the best of those that explain the same?
            let stands = Reconsidered::Stands { confounded: Vec::new(), families: Vec::new() };
            match finite(self.reconsider(&fitted, count))?.unwrap_or(stands) {
                Reconsidered::Swap { from, to, .. } if swapped.contains(&(to.clone(), from.clone())) => {
                    // Each is better than the other: the log cannot tell.
                    confounded = vec![Confounded { ids: vec![from, to] }];
                    break;
                }
                Reconsidered::Swap { from, to, fitted: next } if round < 2 * MOST_AT_REST => {
                    swapped.push((from.clone(), to.clone()));
                    fitted = self.aligned(*next)?;
                    for id in order.iter_mut().filter(|id| **id == from) {
                        id.clone_from(&to);
                    }
                }
                Reconsidered::Swap { .. } => break,
                Reconsidered::Stands { confounded: groups, families: together } => {
                    (confounded, families) = (groups, together);
                    break;
                }
            }
        }
        let steps = self.falling(&base, &fitted, &order)?;
        Ok(Explanation {
            base,
            fitted,
            steps,
            confounded,
            families,
            first: first.unwrap_or_default(),
            last,
            withdrawn: Vec::new(),
            dropped: self.dropped.take(),
            ended_early,
            count,
            chances: Vec::new(),
            shown: Vec::new(),
        })
    }

    /// Compares every effect of the model with the candidates that could stand in its place.
    fn reconsider(&self, fitted: &Fitted<'a>, count: usize) -> Result<Reconsidered<'a>, BadShape> {
        let (mut groups, mut families) = (Vec::new(), Vec::new());
        for index in 0..fitted.terms.len() {
            if self.is_spent() {
                break;
            }
            let mut terms = fitted.terms.clone();
            let own = terms.remove(index);
            let Some(without) = self.design.fit(fitted.model, terms, self.known)? else { continue };
            let own = Term { coefficients: Default::default(), ..own };
            let (judged, _) = self.judge(&without, own.follows(Follows::Tone))?;
            let Some(mine) = judged.iter().find(|one| one.term.id == own.id) else { continue };
            let mut group = vec![own.id.clone()];
            let mut family = vec![own.id.clone()];
            for other in &judged {
                let id = &other.term.id;
                let collinear = self.together(&own, &other.term);
                if fitted.terms.iter().any(|term| &term.id == id)
                    || other.term.is_variant_of(&own)
                    || !(other.tested.accepted || collinear)
                    || other.tested.decrease < RIVAL_SHARE * mine.tested.decrease
                {
                    continue;
                }
                let Some(pair) = rivalry(&self.design, &without, &own, &other.term, self.known)? else {
                    continue;
                };
                if pair.first * (count as f64) < SIGNIFICANCE {
                    continue;
                }
                if collinear {
                    // What several channels have in common stands for them; a channel that has more to say has been
                    // tested beside it.
                    if other.term.is_plain() {
                        family.push(id.clone());
                    }
                    continue;
                }
                // The other explains all that this one does.
                let fewer = other.tested.directions < mine.tested.directions;
                if fewer || pair.second * (count as f64) * other.term.trials < SIGNIFICANCE {
                    if let Some(next) = self.with(&without, &other.term)?
                        && may_follow(&own, &other.term, fitted, &next)
                        && self.beats_its_copies(&without, &other.term)?
                    {
                        return Ok(Reconsidered::Swap {
                            from: own.id,
                            to: id.clone(),
                            fitted: Box::new(next),
                        });
                    }
                } else if other.tested.directions == mine.tested.directions
                    && pair.correlation > ALIKE
                    && as_good(other, mine)
                {
                    group.push(id.clone());
                }
            }
            if group.len() > 1 {
                groups.push(Confounded { ids: group });
            }
            if family.len() > 1 {
                families.push(Confounded { ids: family });
            }
        }
        Ok(Reconsidered::Stands { confounded: groups, families })
    }

    /// The earlier effect that the later ones have made superfluous, and the model without it.
    fn drop_one(&self, fitted: &Fitted<'a>) -> Result<Option<(String, Fitted<'a>)>, BadShape> {
        let newest = fitted.terms.len().saturating_sub(1);
        for index in 0..newest {
            let mut terms = fitted.terms.clone();
            let removed = terms.remove(index);
            let beside =
                |term: &Term| removed.is_plain() && term.id != removed.id && term.is_variant_of(&removed);
            if self.design.residual == Residual::Vector && terms.iter().any(beside) {
                continue;
            }
            let Some(without) = self.design.fit(fitted.model, terms, self.known)? else { continue };
            let candidate = Term { coefficients: Default::default(), trials: 1.0, ..removed.clone() };
            let tested = screen(&self.design, &without, &[candidate], 1)?;
            if tested.first().is_none_or(|tested| !tested.accepted) {
                return Ok(Some((removed.id, without)));
            }
        }
        Ok(None)
    }
}
