//! Which terms a log asks for: add, drop and swap by one score.

use crate::base::term::Term;
use crate::bounds::{
    FORMS_DIFFER, LEADERS, MAX_P_HELD_OUT, MAX_TERMS, MIN_ODDS, MIN_SHARE, MOST_LOOKS, MOST_SWAPS,
    RIVAL_SHARE, RIVALS,
};
use crate::evidence::candidates::Catalogue;
use crate::evidence::design::Model;
use crate::evidence::fit::{Fit, Setting};
use crate::evidence::held_out::p_values;
use crate::evidence::hidden::hidden_cause_gain;
use crate::evidence::log::Log;
use crate::evidence::screen::Screen;
use ironout::effect::{Bends, Named};

/// Share of the least share that a term must have under white noise to be fitted: strong terms explain more than their columns tell.
const SHARE_TO_FIT: f64 = 0.5;
/// Candidates that are fitted at each step under white noise.
const WHITE_LEADERS: usize = 2;

/// The result of a search.
pub struct Found<'a> {
    /// The fit with those that the log asks for, in the order in which they were found.
    pub fit: Fit<'a>,
    /// For each of them, what may stand in its place: id, and how much less likely, as −2 log odds.
    pub rivals: Vec<Vec<Rival>>,
}

/// A term in the place of another.
#[derive(Debug, Clone)]
pub struct Rival {
    /// Its id.
    pub id: String,
    /// −2 log odds against it.
    pub odds: f64,
    /// Whether it is another form of the same cause.
    pub is_variant: bool,
}

/// A search over a log.
pub struct Search<'l, 'a> {
    /// The log.
    pub log: &'l Log<'a>,
    /// Its candidates.
    pub catalogue: &'l Catalogue<'l, 'a>,
    /// How fits are made.
    pub setting: Setting,
    /// How many terms the model keeps whatever the score: those that were asked for come first.
    pub keep: usize,
}

impl<'a> Search<'_, 'a> {
    /// Whether the search has looked at as much as it may.
    pub fn is_spent(&self) -> bool {
        self.log.evaluations() > MOST_LOOKS
    }

    /// Whether a model with more terms is worth them.
    fn is_worth(more: &Fit, fewer: &Fit, terms: usize) -> bool {
        fewer.score - more.score > MIN_ODDS * terms as f64 && more.squares < (1.0 - MIN_SHARE) * fewer.squares
    }

    /// Whether the last term of a fit is shown by the parts of the log together.
    fn holds(&self, fit: &Fit) -> bool {
        let p = p_values(fit);
        p.last().is_some_and(|p| *p < MAX_P_HELD_OUT)
    }

    /// The fit with one more term. A term that reads the field is tried in both of its forms.
    pub fn with(&self, fit: &Fit<'a>, term: &Term<'a>) -> Option<Fit<'a>> {
        let mut model = fit.model.clone();
        model.terms.push(term.clone());
        // The forms differ by the square of a disturbance over the field: of a weak one that is less than the noise.
        let strong = fit.rms() * fit.rms() / fit.model.field > FORMS_DIFFER * fit.noise.variance.sqrt();
        if !model.terms.iter().any(Term::reads) || !strong {
            return Fit::of(self.log, &self.setting, model, Some(fit));
        }
        let forms = [Bends::Field, Bends::Reading].map(|bends| Model { bends, ..model.clone() });
        let fits = forms.into_iter().filter_map(|model| Fit::of(self.log, &self.setting, model, Some(fit)));
        fits.min_by(|a, b| a.score.total_cmp(&b.score))
    }

    /// An effect, what is searched of it at the likeliest of its best places under coloured and under white noise (the first may have taken
    /// it for its own), and the fit with it, if there is one.
    pub fn asked(&self, named: &Named, fit: &Fit<'a>) -> Option<(Term<'a>, Option<Fit<'a>>)> {
        let place = |white: bool| {
            self.catalogue.asked(named, fit, &Screen::new(self.log, fit, self.setting.blocks, white)?)
        };
        let first = place(false);
        let mut terms: Vec<Term<'a>> = first.into_iter().collect();
        if named.form.searched.is_some() {
            terms.extend(place(true));
        }
        let fits = terms.iter().filter_map(|term| self.with(fit, term));
        let best = fits.min_by(|a, b| a.score.total_cmp(&b.score));
        let term = best.as_ref().and_then(|best| best.model.terms.last()).or(terms.first()).cloned();
        Some((term?, best))
    }

    /// The fit without one of its terms.
    pub fn without(&self, fit: &Fit<'a>, place: usize) -> Option<Fit<'a>> {
        let mut model = fit.model.clone();
        model.terms.remove(place);
        Fit::of(self.log, &self.setting, model, Some(fit))
    }

    /// Candidates at a fit, those with the most promise first; the fits are still to be made.
    /// With `own`, only those that gain about as much as that one.
    pub fn leaders(&self, fit: &Fit<'a>, own: Option<&Term<'a>>) -> Vec<Term<'a>> {
        self.leaders_under(fit, own, &[false, true])
    }

    fn leaders_under(&self, fit: &Fit<'a>, own: Option<&Term<'a>>, noises: &[bool]) -> Vec<Term<'a>> {
        let mut list: Vec<(Term<'a>, usize)> = Vec::new();
        let n = fit.track.weight.len() as f64;
        let Some(plain) = Screen::new(self.log, fit, self.setting.blocks, true) else { return Vec::new() };
        let least_plain = -n * (1.0 - SHARE_TO_FIT * MIN_SHARE).ln();
        // White noise that was found to be so needs one look.
        let is_white = fit.noise.wander.is_none() && fit.noise.ar.len() == 1 && noises.contains(&true);
        for white in noises.iter().copied().filter(|white| *white || !is_white) {
            let coloured = if white { None } else { Screen::new(self.log, fit, self.setting.blocks, false) };
            let screen = match (white, &coloured) {
                (true, _) => &plain,
                (false, Some(coloured)) => coloured,
                (false, None) => continue,
            };
            let mut terms = self.catalogue.fixed.clone();
            terms.extend(self.catalogue.searched(fit, screen));
            let known =
                |term: &Term| fit.model.terms.iter().any(|own| own.id == term.id && !term.is_repeated());
            terms.retain(|term| !known(term));
            let refs: Vec<&Term<'a>> = terms.iter().collect();
            let gains = screen.gains(fit, &refs);
            // A term that explains too small a share is not worth a fit.
            let shares = if white { gains.clone() } else { plain.gains(fit, &refs) };
            let mut order: Vec<(f64, Term<'a>)> = terms
                .into_iter()
                .zip(gains)
                .zip(shares)
                .filter(|(_, plain)| *plain > least_plain)
                .map(|((term, gain), _)| {
                    (gain - term.visible() as f64 * n.ln() - term.odds - 2.0 * term.trials.ln(), term)
                })
                .collect();
            order.sort_by(|a, b| b.0.total_cmp(&a.0));
            // What is fitted gains about as much as the term whose place it may take, or as the best.
            let to_beat = match own {
                Some(own) => order.iter().find(|(_, term)| term.id == own.id),
                None => order.first(),
            };
            let least = to_beat.map_or(0.0, |(gain, _)| (RIVAL_SHARE * gain).max(0.0));
            order.retain(|(gain, term)| *gain > least && own.is_none_or(|own| own.id != term.id));
            let most = if own.is_some() { RIVALS } else { LEADERS };
            for (rank, (_, term)) in order.into_iter().take(most).enumerate() {
                let same =
                    |own: &&mut (Term<'a>, usize)| own.0.id == term.id && own.0.searched() == term.searched();
                match list.iter_mut().find(same) {
                    Some(own) => own.1 = own.1.min(rank),
                    None => list.push((term, rank)),
                }
            }
        }
        list.sort_by_key(|(_, rank)| *rank);
        list.into_iter().map(|(term, _)| term).collect()
    }

    /// The search from a base fit.
    pub fn run(&self, base: Fit<'a>) -> Found<'a> {
        let mut fit = base.clone();
        let mut path = vec![base];
        while fit.model.terms.len() < MAX_TERMS && !self.is_spent() {
            let leaders = self.leaders(&fit, None);
            let mut tried: Vec<Fit<'a>> = leaders.iter().filter_map(|term| self.with(&fit, term)).collect();
            tried.sort_by(|a, b| a.score.total_cmp(&b.score));
            let Some(place) = tried.iter().position(|one| Self::is_worth(one, &fit, 1) && self.holds(one))
            else {
                break;
            };
            let best = Self::plainer(tried, place);
            fit = best;
            // The last one is new.
            let last = fit.model.terms.len() - 1;
            self.drop_idle(&mut fit, last);
            path.push(fit.clone());
        }
        if let Some(several) = self.together(&fit) {
            path.push(several.clone());
            fit = several;
        }
        fit = self.likeliest_of(path).unwrap_or(fit);
        let rivals = self.swap(&mut fit);
        Found { fit, rivals }
    }

    /// Several terms that are worth their price together. Where the motion repeats itself, an autoregressive noise imitates the misfit of
    /// each single one; under white noise they are found one by one, and judged by the full score at the end.
    fn together(&self, fit: &Fit<'a>) -> Option<Fit<'a>> {
        let white = Search { setting: Setting { is_white: true, ..self.setting }, ..*self };
        let mut now = Fit::of(self.log, &white.setting, fit.model.clone(), None)?;
        let before = fit.model.terms.len();
        while now.model.terms.len() < MAX_TERMS {
            if self.is_spent() {
                return None;
            }
            let leaders = white.leaders_under(&now, None, &[true]);
            let tried = leaders.iter().take(WHITE_LEADERS).filter_map(|term| white.with(&now, term));
            let Some(next) = tried.min_by(|a, b| a.score.total_cmp(&b.score)) else { break };
            if !Self::is_worth(&next, &now, 1) {
                break;
            }
            now = next;
        }
        if now.model.terms.len() < before + 2 {
            return None;
        }
        let mut full = Fit::of(self.log, &self.setting, now.model.clone(), None)?;
        loop {
            let more = full.model.terms.len().checked_sub(before).filter(|more| *more > 1)?;
            if Self::is_worth(&full, fit, more) {
                let fewer = (before..full.model.terms.len())
                    .filter_map(|place| self.without(&full, place))
                    .min_by(|a, b| a.score.total_cmp(&b.score));
                match fewer {
                    Some(fewer) if !Self::is_worth(&full, &fewer, 1) => full = fewer,
                    _ => break,
                }
            } else {
                // The last that white noise let in.
                full = self.without(&full, full.model.terms.len() - 1)?;
            }
        }
        p_values(&full)[before..].iter().all(|p| *p < MAX_P_HELD_OUT).then_some(full)
    }

    /// The likeliest fit, or that with the plain form of its last term where the derived one changes next to nothing.
    fn plainer(mut tried: Vec<Fit<'a>>, place: usize) -> Fit<'a> {
        let best = &tried[place];
        let is_plain = |one: &Fit<'a>| match (one.model.terms.last(), best.model.terms.last()) {
            (Some(own), Some(derived)) => {
                derived.odds > 0.0
                    && own.odds == 0.0
                    && own.is_variant_of(derived)
                    && one.score - best.score < MIN_ODDS
            }
            _ => false,
        };
        let plain = tried.iter().position(is_plain).unwrap_or(place);
        tried.swap_remove(plain)
    }

    /// The fit of a path that is likeliest with whatever single cause nobody logged: several columns together imitate any history.
    fn likeliest_of(&self, path: Vec<Fit<'a>>) -> Option<Fit<'a>> {
        // Without terms there is nothing that could stand in for a cause.
        if path.len() < 2 {
            return path.into_iter().next();
        }
        let mut best: Option<(f64, Fit<'a>)> = None;
        for fit in path {
            let total = fit.score - self.hidden_cause_gain(&fit);
            let terms = fit.model.terms.len();
            let own = best.as_ref().map_or(0, |(_, best)| best.model.terms.len());
            let margin = MIN_ODDS * terms.saturating_sub(own) as f64;
            if best.as_ref().is_none_or(|(least, _)| total < least - margin) {
                best = Some((total, fit));
            }
        }
        best.map(|(_, fit)| fit)
    }

    /// What a single cause that nobody logged would gain. A board at rest shows the whole vector at each time: any history of one
    /// direction fits it, and says nothing.
    fn hidden_cause_gain(&self, fit: &Fit<'a>) -> f64 {
        if self.log.is_at_rest { 0.0 } else { hidden_cause_gain(fit) }
    }

    /// Drops terms that only stand in for a cause that nobody logged: a term must be worth its price beside such a cause too.
    pub fn against_hidden_cause(&self, found: &mut Found<'a>) {
        if found.fit.model.terms.len() <= self.keep {
            return;
        }
        let mut gain = self.hidden_cause_gain(&found.fit);
        'again: while gain > MIN_ODDS {
            for place in (self.keep..found.fit.model.terms.len()).rev() {
                let Some(fewer) = self.without(&found.fit, place) else { continue };
                let other = self.hidden_cause_gain(&fewer);
                if (fewer.score - other) - (found.fit.score - gain) < MIN_ODDS {
                    found.fit = fewer;
                    found.rivals.remove(place);
                    gain = other;
                    continue 'again;
                }
            }
            break;
        }
    }

    /// Puts likelier terms in the place of those that were found first; gives what else may stand in each place.
    fn swap(&self, fit: &mut Fit<'a>) -> Vec<Vec<Rival>> {
        let mut swaps = 0;
        'again: loop {
            let mut all = Vec::new();
            for place in 0..fit.model.terms.len() {
                if place < self.keep || self.is_spent() {
                    all.push(Vec::new());
                    continue;
                }
                let own = &fit.model.terms[place];
                let Some(fewer) = self.without(fit, place) else {
                    all.push(Vec::new());
                    continue;
                };
                let leaders = self.leaders(&fewer, Some(own));
                let mut fits: Vec<Fit<'a>> =
                    leaders.iter().filter_map(|term| self.with(&fewer, term)).collect();
                // The term itself goes the same way: the likelihood of a noise has several tops, and each way finds its own.
                let own_score = match self.with(&fewer, own) {
                    Some(again) if !fits.is_empty() => again.score.min(fit.score),
                    _ => fit.score,
                };
                fits.sort_by(|a, b| a.score.total_cmp(&b.score));
                let is_likelier = |one: &Fit<'a>| {
                    let is_derived =
                        one.model.terms.last().is_some_and(|term| {
                            term.odds > 0.0 && own.odds == 0.0 && term.is_variant_of(own)
                        });
                    one.score < own_score - 1.0 && (!is_derived || one.score < own_score - MIN_ODDS)
                };
                if fits.first().is_some_and(is_likelier) && swaps < MOST_SWAPS {
                    let mut best = fits.swap_remove(0);
                    // In the place of the other: the order of the list is that of what was found first.
                    if let Some(term) = best.model.terms.pop() {
                        best.model.terms.insert(place, term);
                    }
                    let Some(best) = self.again(best) else { return all };
                    *fit = best;
                    let terms = fit.model.terms.len();
                    self.drop_idle(fit, terms);
                    swaps += 1;
                    continue 'again;
                }
                let rival = |one: &Fit<'a>| {
                    let term = one.model.terms.last()?;
                    Some(Rival {
                        id: term.id.clone(),
                        odds: one.score - own_score,
                        is_variant: term.is_variant_of(own),
                    })
                };
                all.push(fits.iter().filter_map(rival).collect());
            }
            return all;
        }
    }

    /// The same model fitted from where it stands.
    fn again(&self, fit: Fit<'a>) -> Option<Fit<'a>> {
        Fit::of(self.log, &self.setting, fit.model.clone(), Some(&fit))
    }

    /// Drops terms among the first `count` that others have made superfluous.
    fn drop_idle(&self, fit: &mut Fit<'a>, mut count: usize) {
        let mut place = self.keep;
        while fit.model.terms.len() > 1 && place < count {
            match self.without(fit, place) {
                Some(fewer) if !Self::is_worth(fit, &fewer, 1) => {
                    *fit = fewer;
                    (place, count) = (self.keep, count - 1);
                }
                _ => place += 1,
            }
        }
    }
}
