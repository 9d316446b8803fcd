//! Which terms a log asks for, with what may stand in the place of each.

use crate::base::prior::Prior;
use crate::base::term::Term;
use crate::bounds::{MAX_BLOCKS, MOST_TONES, UNCLEAR_ODDS};
use crate::evidence::candidates::Catalogue;
use crate::evidence::design::{Blocks, Model};
use crate::evidence::fast_tones::{fast_tone, without_tone};
use crate::evidence::fit::{Fit, Setting, starts};
use crate::evidence::held_out::p_values;
use crate::evidence::log::Log;
use crate::evidence::screen::Screen;
use crate::evidence::search::{Found, Rival, Search};
use crate::evidence::significance::{Test, of_tone, tests};
use crate::evidence::wander::Moving;
use crate::samples::samples::Samples;
use crate::table::Table;
use ironout::effect::{Acts, MAX_COEFFICIENTS, Named, Registry, Searched};
use ironout::study::Model as CoreModel;
use std::borrow::Cow;

/// What a selection begins with.
pub struct Begin<'b> {
    /// The model of the log without effects, or with those that stay.
    pub model: &'b CoreModel<f64>,
    /// What is known besides the log.
    pub known: &'b Prior,
    /// Effects that stay in the model.
    pub stay: &'b [Term<'b>],
    /// Whether the board rests.
    pub is_at_rest: bool,
}

/// A term that the log asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Selected {
    /// Its id.
    pub id: String,
    /// Where what was searched of it was found; zero where nothing was.
    pub parameter: f64,
    /// Its coefficients beside the others.
    pub coefficients: [f64; MAX_COEFFICIENTS],
    /// Places tried for it.
    pub trials: f64,
    /// Ids of others that the log cannot tell from it.
    pub rivals: Vec<String>,
}

/// The terms of a log.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// Those that were found, in their order.
    pub found: Vec<Selected>,
    /// Offset and matrix beside them.
    pub model: Option<CoreModel<f64>>,
    /// The tests of all candidates beside the model that the selection began with.
    pub first: Vec<Test>,
    /// The same beside what was found.
    pub last: Vec<Test>,
    /// How many candidates there are.
    pub candidates: usize,
    /// Terms whose shape is not finite on this log.
    pub dropped: Vec<String>,
    /// Whether the search ended before all was tried.
    pub ended_early: bool,
}

/// Selects the terms of these samples. `None` where no model can be fitted.
pub fn select(samples: &Samples, table: &Table, registry: Registry, begin: &Begin) -> Option<Selection> {
    let mut samples = Cow::Borrowed(samples);
    let (mut tones, mut tests_of_tones): (Vec<Selected>, Vec<Test>) = Default::default();
    loop {
        match one_search(&samples, table, registry, begin, tones.len() < MOST_TONES)? {
            Round::Tone { rest, tone, test } => {
                samples = Cow::Owned(*rest);
                tones.push(tone);
                tests_of_tones.push(test);
            }
            Round::End(mut selection) => {
                // Two tones are one name.
                tones.dedup_by(|one, other| one.id == other.id);
                selection.found.retain(|one| !tones.iter().any(|tone| tone.id == one.id));
                selection.found.splice(..0, tones);
                selection.first.retain(|test| !tests_of_tones.iter().any(|own| own.id == test.id));
                selection.first.extend(tests_of_tones);
                return Some(selection);
            }
        }
    }
}

/// What one search ends with.
enum Round {
    /// A fast tone, and the samples without it.
    Tone { rest: Box<Samples>, tone: Selected, test: Test },
    /// The end.
    End(Selection),
}

fn selected(term: &Term, rivals: Vec<String>) -> Selected {
    let parameter = term.searched().map_or(0.0, |(_, parameter)| parameter);
    Selected { id: term.id.clone(), parameter, coefficients: term.coefficients, trials: term.trials, rivals }
}

/// Effects of these ids with what is searched of each at its likeliest place, and offset and matrix beside them.
///
/// # Errors
/// The number of an effect for which the log lacks what it needs; `None` where no model can be fitted.
pub fn placed(
    samples: &Samples,
    table: &Table,
    registry: Registry,
    begin: &Begin,
    asked: &[Named],
) -> Result<Selection, Option<usize>> {
    let sampled = Sampled::of(samples, table, begin);
    let (log, few_log) = sampled.logs(table, begin);
    let searched = few_log.as_ref().unwrap_or(&log);
    let (mut fit, setting) = base_of(searched, begin, registry).ok_or(None)?;
    let catalogue = Catalogue::new(searched, registry);
    let search = Search { log: searched, catalogue: &catalogue, setting, keep: begin.stay.len() };
    // Each with its place among the terms of the fit, where it stands there.
    let mut list: Vec<(Selected, Option<usize>)> = Vec::new();
    for (index, named) in asked.iter().enumerate() {
        let tone = match (named.form.searched, few_log.is_some()) {
            (Some(Searched::Frequency), true) => tone_of(&log, &fit, registry, setting),
            _ => None,
        };
        if let Some((term, _)) = tone {
            list.push((selected(&term, Vec::new()), None));
            continue;
        }
        let (term, next) = search.asked(named, &fit).ok_or(Some(index))?;
        // What does not fit beside the others yet may fit beside those that follow.
        let own = next.as_ref().map(|_| fit.model.terms.len());
        list.push((selected(&term, Vec::new()), own));
        fit = next.unwrap_or(fit);
    }
    // What was searched before the others stood beside it is searched once more.
    for (index, named) in asked.iter().enumerate().filter(|(_, named)| named.form.searched.is_some()) {
        let Some(own) = list[index].1.filter(|_| asked.len() > 1) else { continue };
        let Some(fewer) = search.without(&fit, own) else { continue };
        let again = search.asked(named, &fewer).and_then(|(_, next)| next);
        if let Some(mut next) = again.filter(|next| next.score < fit.score - 1.0)
            && let Some(term) = next.model.terms.pop()
        {
            next.model.terms.insert(own, term);
            fit = Fit::of(searched, &setting, next.model.clone(), Some(&next)).unwrap_or(fit);
        }
    }
    let found = list.into_iter().map(|(one, own)| match own {
        Some(own) => selected(&fit.model.terms[own], Vec::new()),
        None => one,
    });
    let found = found.collect();
    Ok(Selection { found, model: core_model(&fit, begin.model), ..Selection::default() })
}

/// Offset and matrix of a fit, with the rotation of another model.
fn core_model(fit: &Fit, other: &CoreModel<f64>) -> Option<CoreModel<f64>> {
    let Model { offset, matrix, .. } = &fit.model;
    let rows = core::array::from_fn(|i| core::array::from_fn(|j| matrix[(i, j)]));
    CoreModel::new((*offset).into(), rows, other.field_ut, other.rotation, other.sin_dip)
}

/// The samples that the likelihood looks at, and what is known besides them.
struct Sampled<'s> {
    /// All of them; of a board at rest each three times, once for each axis.
    all: Cow<'s, Samples>,
    /// One of each block of a long log: a term that matters shows in those as well.
    few: Option<Samples>,
    /// Where that is more than how magnetometers are.
    known: Option<Prior>,
}

impl<'s> Sampled<'s> {
    fn of(samples: &'s Samples, table: &Table, begin: &Begin) -> Self {
        let (all, few) = match begin.is_at_rest {
            true => (Cow::Owned(one_per_axis(samples, table)), None),
            false => (Cow::Borrowed(samples), thinned(samples, table)),
        };
        let is_known = begin.known.earlier.is_some() || begin.known.holds_matrix();
        let known = is_known.then(|| Prior { memory: 1.0, ..begin.known.clone() });
        Sampled { all, few, known }
    }

    /// The log of all samples, and that of the few of a long one.
    fn logs<'l>(&'l self, table: &'l Table<'l>, begin: &Begin) -> (Log<'l>, Option<Log<'l>>) {
        let log = |samples| Log::new(samples, table, self.known.as_ref(), begin.is_at_rest);
        (log(&self.all), self.few.as_ref().map(log))
    }
}

/// A fit of what stays in the model, to the few samples of a long log, and something that is made of it and of the log of all samples.
fn of_base<T>(
    samples: &Samples,
    table: &Table,
    registry: Registry,
    begin: &Begin,
    made: impl FnOnce(Fit<'_>, &Log<'_>) -> Option<T>,
) -> Option<T> {
    let sampled = Sampled::of(samples, table, begin);
    let (log, few_log) = sampled.logs(table, begin);
    made(base_of(few_log.as_ref().unwrap_or(&log), begin, registry)?.0, &log)
}

/// A tone that is too fast for the blocks beside a fit of a thinned log, and the fit to all samples that it stands out of.
fn tone_of<'l>(
    log: &Log<'l>,
    fit: &Fit,
    registry: Registry,
    setting: Setting,
) -> Option<(Term<'l>, Fit<'l>)> {
    let setting = Setting { blocks: Blocks::at_most(log.len(), MAX_BLOCKS), ..setting };
    let whole = Fit::of(log, &setting, fit.model.rebound(log)?, None)?;
    Some((fast_tone(log, registry, &setting, &whole)?, whole))
}

fn one_search(
    samples: &Samples,
    table: &Table,
    registry: Registry,
    begin: &Begin,
    looks_again: bool,
) -> Option<Round> {
    let sampled = Sampled::of(samples, table, begin);
    let (log, few_log) = sampled.logs(table, begin);
    let searched = few_log.as_ref().unwrap_or(&log);
    let (base, setting) = base_of(searched, begin, registry)?;
    // Tones are looked for at the rate of the samples.
    let tone_beside = |fit: &Fit| {
        let (term, whole) = tone_of(&log, fit, registry, setting)?;
        let rest = Box::new(without_tone(log.samples, &term, &whole));
        Some(Round::Tone { rest, tone: selected(&term, Vec::new()), test: of_tone(&whole, &term) })
    };
    let looks_again = looks_again && few_log.is_some();
    if looks_again && let Some(tone) = tone_beside(&base) {
        return Some(tone);
    }
    let catalogue = Catalogue::new(searched, registry);
    let search = Search { log: searched, catalogue: &catalogue, setting, keep: begin.stay.len() };
    let mut found = search.run(base.clone());
    search.against_hidden_cause(&mut found);
    let Found { fit, rivals, .. } = found;
    // Next to a stronger effect a tone is less than its share at first.
    if looks_again
        && fit.model.terms.len() > begin.stay.len()
        && let Some(tone) = tone_beside(&fit)
    {
        return Some(tone);
    }
    let unclear = |rivals: &[Rival]| -> Vec<String> {
        let unclear = rivals.iter().filter(|rival| !rival.is_variant && rival.odds < UNCLEAR_ODDS);
        unclear.map(|rival| rival.id.clone()).collect()
    };
    let own = fit.model.terms.iter().zip(&rivals).skip(begin.stay.len());
    let of = |at: &Fit, more: &[Term]| -> (Vec<Test>, Vec<String>) {
        let Some(screen) = Screen::new(searched, at, setting.blocks, false) else {
            return Default::default();
        };
        let mut terms = catalogue.detected(at, &screen);
        terms.retain(|term| !more.iter().any(|own| own.id == term.id));
        terms.extend(more.iter().cloned());
        tests(&setting, at, &terms)
    };
    let (first, mut dropped) = of(&base, &fit.model.terms[begin.stay.len()..]);
    let (last, more) = of(&fit, &[]);
    dropped.extend(more);
    dropped.sort_unstable();
    dropped.dedup();
    Some(Round::End(Selection {
        found: own.map(|(term, rivals)| selected(term, unclear(rivals))).collect(),
        model: core_model(&fit, begin.model),
        first,
        last,
        candidates: setting.candidates as usize,
        dropped,
        ended_early: search.is_spent(),
    }))
}

/// What moves beside the terms that a model has; nothing where the log has no times.
pub fn moving(samples: &Samples, table: &Table, registry: Registry, begin: &Begin) -> Moving {
    let of = |fit: Fit, log: &Log| log.is_timed.then(|| Moving::of(&fit));
    of_base(samples, table, registry, begin, of).unwrap_or_default()
}

/// p-value of each term that a model has, all others in it, by the spread of its coefficients over parts of the log; one where no model can be
/// fitted.
pub fn p_values_of(samples: &Samples, table: &Table, registry: Registry, begin: &Begin) -> Vec<f64> {
    let found = of_base(samples, table, registry, begin, |fit, _| Some(p_values(&fit)));
    found.unwrap_or_else(|| vec![1.0; begin.stay.len()])
}

/// Each sample of a board at rest three times, once for each axis.
fn one_per_axis(samples: &Samples, table: &Table) -> Samples {
    let few = (samples.len() > MAX_BLOCKS).then(|| samples.thinned(table, MAX_BLOCKS));
    let rows = &few.as_ref().unwrap_or(samples).row;
    samples.of_these(table, rows.iter().flat_map(|&row| [row; 3]).collect())
}

/// One sample of each block of a long log, at uneven places: a tone cannot pass for a slower one. `None` where the log is short.
fn thinned(samples: &Samples, table: &Table) -> Option<Samples> {
    let size = Blocks::at_most(samples.len(), MAX_BLOCKS).size;
    if size < 2 {
        return None;
    }
    let places: Vec<usize> = (0..samples.len() / size)
        .map(|block| {
            block * size + ((block as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as usize % size
        })
        .collect();
    let mut few = samples.of_these(table, places.iter().map(|&place| samples.row[place]).collect());
    // What was taken out of the readings stays out.
    for (reading, place) in few.readings.iter_mut().zip(places) {
        reading.measured_ut = samples.readings[place].measured_ut;
    }
    Some(few)
}

/// The likeliest fit without terms, or with those that stay, and how it was made.
fn base_of<'a>(log: &Log<'a>, begin: &Begin, registry: Registry) -> Option<(Fit<'a>, Setting)> {
    // A mean over the axes of a board at rest is no reading.
    let blocks = if log.is_at_rest { log.len() } else { MAX_BLOCKS };
    let blocks = Blocks::at_most(log.len(), blocks);
    let candidates = Catalogue::new(log, registry).count.max(1.0);
    let stay = begin.stay.iter().map(|term| log.again(term)).collect::<Option<Vec<_>>>()?;
    let mut bases = Vec::new();
    for (mut model, scale) in starts(begin.model, log) {
        model.terms.clone_from(&stay);
        let reads = |term: &&Term| term.acts(Acts::Measured) && term.stands();
        model.bends = stay.iter().find(reads).map_or(model.bends, |term| term.bends);
        let setting = Setting { blocks, scale, candidates, is_white: false };
        let fit = Fit::of(log, &setting, model, None);
        bases.extend(fit.map(|fit| (fit, setting)));
    }
    bases.into_iter().min_by(|a, b| a.0.score.total_cmp(&b.0.score))
}
