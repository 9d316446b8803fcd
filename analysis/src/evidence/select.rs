//! Which terms a log asks for, with what may stand in the place of each.

use crate::base::prior::Prior;
use crate::base::term::Term as BaseTerm;
use crate::bounds::{MAX_BLOCKS, MOST_TONES, UNCLEAR_ODDS};
use crate::evidence::candidates::Catalogue;
use crate::evidence::design::Blocks;
use crate::evidence::fast_tones::{fast_tone, without_tone};
use crate::evidence::fit::{Fit, Setting, starts};
use crate::evidence::gaps::without_gaps;
use crate::evidence::log::Log;
use crate::evidence::search::{Found, Rival, Search};
use crate::evidence::term::Term;
use crate::evidence::wander::Wander;
use crate::samples::samples::Samples;
use crate::table::Table;
use ironout::effect::Registry;
use ironout::study::Model as CoreModel;
use std::borrow::Cow;

/// What a selection begins with.
pub struct Begin<'b> {
    /// The model of the log without effects, or with those that stay.
    pub model: &'b CoreModel<f64>,
    /// What is known besides the log.
    pub known: &'b Prior,
    /// Effects that stay in the model.
    pub stay: &'b [BaseTerm<'b>],
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
    /// Places tried for it.
    pub places: f64,
    /// Ids of others that the log cannot tell from it.
    pub rivals: Vec<String>,
}

/// The terms of a log.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// Those that were found, in their order.
    pub found: Vec<Selected>,
    /// Whether the search ended before all was tried.
    pub ended_early: bool,
}

/// Selects the terms of these samples. `None` where no model can be fitted.
pub fn select(samples: &Samples, table: &Table, registry: Registry, begin: &Begin) -> Option<Selection> {
    let mut samples = without_gaps(samples, table).map_or(Cow::Borrowed(samples), Cow::Owned);
    let mut tones: Vec<Selected> = Vec::new();
    loop {
        match one_search(&samples, table, registry, begin, tones.len() < MOST_TONES)? {
            Round::Tone { rest, tone } => {
                samples = Cow::Owned(*rest);
                tones.push(tone);
            }
            Round::End(mut selection) => {
                // Two tones are one name.
                tones.dedup_by(|one, other| one.id == other.id);
                selection.found.retain(|one| !tones.iter().any(|tone| tone.id == one.id));
                selection.found.splice(..0, tones);
                return Some(selection);
            }
        }
    }
}

/// What one search ends with.
enum Round {
    /// A fast tone, and the samples without it.
    Tone { rest: Box<Samples>, tone: Selected },
    /// The end.
    End(Selection),
}

fn selected(term: &Term, rivals: Vec<String>) -> Selected {
    let parameter = term.searched().map_or(0.0, |(_, parameter)| parameter);
    Selected { id: term.id.clone(), parameter, places: term.places, rivals }
}

fn one_search(
    samples: &Samples,
    table: &Table,
    registry: Registry,
    begin: &Begin,
    looks_again: bool,
) -> Option<Round> {
    let is_known = begin.known.earlier.is_some() || begin.known.holds_matrix();
    let known = is_known.then(|| Prior { memory: 1.0, ..begin.known.clone() });
    let known = known.as_ref();
    let tripled;
    let samples = match begin.is_at_rest {
        true => {
            tripled = one_per_axis(samples, table);
            &tripled
        }
        false => samples,
    };
    let log = Log::new(samples, table, known, begin.is_at_rest);
    // Which terms there are is decided by a sample of each block: a term that matters shows in those as well.
    let few = if begin.is_at_rest { None } else { thinned(samples, table) };
    let few_log = few.as_ref().map(|few| Log::new(few, table, known, false));
    let searched = few_log.as_ref().unwrap_or(&log);
    let (base, setting) = base_of(searched, begin, registry)?;
    // Tones are looked for at the rate of the samples.
    let tone_beside = |fit: &Fit| {
        let setting = Setting { blocks: Blocks::at_most(log.len(), MAX_BLOCKS), ..setting };
        let whole = Fit::of(&log, &setting, fit.model.rebound(&log)?, None)?;
        let term = fast_tone(&log, registry, &setting, &whole)?;
        let rest = Box::new(without_tone(samples, &term, &whole));
        Some(Round::Tone { rest, tone: selected(&term, Vec::new()) })
    };
    let looks_again = looks_again && few_log.is_some();
    if looks_again && let Some(tone) = tone_beside(&base) {
        return Some(tone);
    }
    let catalogue = Catalogue::new(searched, registry);
    let search = Search { log: searched, catalogue: &catalogue, setting, keep: begin.stay.len() };
    let mut found = search.run(base);
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
    Some(Round::End(Selection {
        found: own.map(|(term, rivals)| selected(term, unclear(rivals))).collect(),
        ended_early: search.is_spent(),
    }))
}

/// How the offset wanders beside the terms that a model has; `None` where it does not, or the log has no times.
pub fn wander(samples: &Samples, table: &Table, registry: Registry, begin: &Begin) -> Option<Wander> {
    samples.time.as_ref()?;
    let few = thinned(samples, table);
    let log = Log::new(few.as_ref().unwrap_or(samples), table, None, false);
    let (fit, _) = base_of(&log, begin, registry)?;
    Wander::of(&fit)
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
    let stay = begin.stay.iter().map(|term| Term::standing(log, term)).collect::<Option<Vec<_>>>()?;
    let mut bases = Vec::new();
    for (mut model, scale) in starts(begin.model, log) {
        model.terms.clone_from(&stay);
        let setting = Setting { blocks, scale, candidates, is_white: false };
        let fit = Fit::of(log, &setting, model, None);
        bases.extend(fit.map(|fit| (fit, setting)));
    }
    bases.into_iter().min_by(|a, b| a.0.score.total_cmp(&b.0.score))
}
