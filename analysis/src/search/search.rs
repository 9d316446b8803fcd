//! Searches over the parameter that fixes a shape: when a step happened, how late a column acts, at what frequency.

use crate::base::engine::{Design, Fitted};
use crate::base::term::{BadShape, COLUMNS, Matrix, Term};
use crate::samples::samples::Samples;
use crate::samples::series::median;
use crate::search::candidates::Catalogue;
use crate::search::gains::{decreases, largest};
use crate::search::screen::WORTH_NAMING;
use crate::search::tone::periodic;
use ironout::effect::{Named, Searched};
/// Places where a step is looked for at first.
use ironout::study::rule::STEP_PLACES as STEP_SEGMENTS;

/// A column that takes so many times more off the error late than at once is worth a closer look.
const LATE_OVER_PROMPT: f64 = 1.2;

/// Leads are looked for up to this, s: telemetry of one value a second is late by up to two of them.
const LONGEST_LEAD_S: f64 = 2.0;

/// Time constants are looked for up to this, s: boards and batteries warm within minutes.
const LONGEST_TIME_CONSTANT_S: f64 = 600.0;
/// Between two that are tried at first: the shapes of two low-passes this far apart are alike by 97 % at least.
const TIME_CONSTANTS_APART: f64 = 2.0;

/// Delays are looked for up to this, s: what follows later than a motor or a power module does has a time of its own to show.
const LONGEST_DELAY_S: f64 = 5.0;

/// The best place of an effect of which something is searched for. `None` where nothing is, or the log does not allow it.
pub fn best<'a>(
    design: &Design,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<Option<Term<'a>>, BadShape> {
    match named.form.searched {
        Some(Searched::At) => step(design, fitted, catalogue, named),
        Some(Searched::Frequency) => periodic(design, fitted, catalogue, named),
        Some(Searched::Delay | Searched::TimeConstant) => past(design, fitted, catalogue, named),
        None => Ok(None),
    }
}

/// Where an offset step takes the most off the squared error.
fn step<'a>(
    design: &Design,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<Option<Term<'a>>, BadShape> {
    let Some(time) = &design.samples.time else { return Ok(None) };
    let n = design.samples.len();
    let base = fitted.columns();
    if n < 4 * STEP_SEGMENTS || base + 3 > COLUMNS {
        return Ok(None);
    }
    let terms: Vec<&Term> = fitted.terms.iter().collect();
    let mut bounds: Vec<usize> = (0..=STEP_SEGMENTS).map(|k| n * k / STEP_SEGMENTS).collect();
    let mut total: Option<Matrix> = None;
    let mut after = Matrix::new(base);
    let mut best = (0.0, 0);
    loop {
        let segments = design.blocks(&bounds, &fitted.model, &terms)?;
        let whole = total.get_or_insert_with(|| Matrix::total(&segments, Some(&fitted.prior)));
        let mut suffix = Matrix::new(base);
        suffix.merge(&after);
        let mut sums = vec![suffix.clone()];
        for segment in segments.iter().rev() {
            suffix.merge(segment);
            sums.push(suffix.clone());
        }
        sums.reverse();
        best = (0.0, best.1);
        // The first and last bound are no places for a step unless they lie inside the log.
        for (place, bound) in bounds.iter().enumerate() {
            if *bound < n / 50 || *bound > n - n / 50 {
                continue;
            }
            let masked = with_steps(whole, &[&sums[place]], base);
            let decrease = masked.test(0..base, base..base + 3).map_or(0.0, |gain| gain.decrease);
            if decrease > best.0 {
                best = (decrease, place);
            }
        }
        if best.0 <= 0.0 {
            return Ok(None);
        }
        let (low, high) = (bounds[best.1.saturating_sub(1)], bounds[(best.1 + 1).min(bounds.len() - 1)]);
        let at = bounds[best.1];
        if bounds.windows(2).all(|pair| pair[1] - pair[0] <= 1) || high - low <= 2 {
            let at_s = if at == 0 { time[0] } else { 0.5 * (time[at - 1] + time[at]) };
            let term = catalogue.build(named, at_s);
            return Ok(term.map(|term| Term { trials: STEP_SEGMENTS as f64, ..term }));
        }
        // Finer around the best place.
        after = sums[(best.1 + 1).min(sums.len() - 1)].clone();
        let parts = (high - low).min(32);
        bounds = (0..=parts).map(|k| low + (high - low) * k / parts).collect();
    }
}

/// The normal matrix with three more columns for each of `suffixes`: those of the offset from some time on, whose own matrix the
/// suffix is. A later one lies within an earlier one.
fn with_steps(whole: &Matrix, suffixes: &[&Matrix], base: usize) -> Matrix {
    let mut out = Matrix::new(base + 3 * suffixes.len());
    out.merge(whole);
    for (place, suffix) in suffixes.iter().enumerate() {
        let at = base + 3 * place;
        for axis in 0..3 {
            for column in 0..base {
                out.inform(column, at + axis, suffix.entry(column, axis));
            }
            for other in axis..3 {
                out.inform(at + axis, at + other, suffix.entry(axis, other));
            }
            for later in place + 1..suffixes.len() {
                for other in 0..3 {
                    let both = suffixes[later].entry(axis, other);
                    out.inform(at + axis, base + 3 * later + other, both);
                }
            }
            out.pull(at + axis, suffix.right(axis));
        }
    }
    out
}

/// Delays that are tried at first: whole samples, ever fewer the longer; or time constants, each twice the one before.
fn pasts(samples: &Samples, searched: Option<Searched>) -> Option<Vec<f64>> {
    let time = samples.time.as_ref()?;
    let mut gaps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > 0.0).collect();
    let step = median(&mut gaps) / samples.stride as f64;
    let seconds = time.last().unwrap_or(&0.0) - time.first().unwrap_or(&0.0);
    if step.is_nan() || step <= 0.0 {
        return None;
    }
    if searched == Some(Searched::TimeConstant) {
        let longest = LONGEST_TIME_CONSTANT_S.min(seconds / 2.0);
        let tried = std::iter::successors(Some(2.0 * step), |s| Some(TIME_CONSTANTS_APART * s));
        let tried: Vec<f64> = tried.take_while(|s| *s <= longest).collect();
        return (!tried.is_empty()).then_some(tried);
    }
    let longest = LONGEST_DELAY_S.max(10.0 * step).min(seconds / 10.0);
    let mut delays: Vec<f64> = Vec::new();
    let (mut one, mut two) = (1.0, 2.0);
    while one * step <= longest {
        delays.push(one * step);
        (one, two) = (two, one + two);
    }
    // Before its column is logged: a slower bus or a rolling mean behind it.
    let early = delays.iter().map(|delay| -delay).take_while(|delay| *delay >= -LONGEST_LEAD_S);
    let mut delays: Vec<f64> = early.chain(delays.iter().copied()).collect();
    delays.sort_by(f64::total_cmp);
    (!delays.is_empty()).then_some(delays)
}

/// Whether a column takes clearly more off the error late than at once.
pub fn acts_late<'a>(
    design: &Design,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<bool, BadShape> {
    let Some(mut delays) = pasts(design.samples, named.form.searched) else { return Ok(false) };
    delays.insert(0, 0.0);
    let terms: Vec<Term> = delays.iter().filter_map(|d| catalogue.build(named, *d)).collect();
    let taken = decreases(design, fitted, &terms)?;
    let Some((prompt, late)) = taken.split_first() else { return Ok(false) };
    let most = late.iter().copied().fold(0.0, f64::max);
    Ok(most > LATE_OVER_PROMPT * prompt && most > WORTH_NAMING * fitted.squares)
}

/// How late a column acts, or through which low-pass, where a past of it acts.
fn past<'a>(
    design: &Design,
    fitted: &Fitted,
    catalogue: &Catalogue<'a>,
    named: &Named,
) -> Result<Option<Term<'a>>, BadShape> {
    let Some(mut delays) = pasts(design.samples, named.form.searched) else { return Ok(None) };
    let searched = delays.len() as f64;
    for round in 0..3 {
        let terms: Vec<Term> = delays.iter().filter_map(|d| catalogue.build(named, *d)).collect();
        let gains = decreases(design, fitted, &terms)?;
        let best = largest(&gains);
        if round == 2 || gains.get(best).is_none_or(|gain| *gain <= 0.0) {
            return Ok(terms.into_iter().nth(best).map(|term| Term { trials: searched, ..term }));
        }
        let low = if best == 0 { delays[0] - 0.5 * delays[0].abs() } else { delays[best - 1] };
        let high = delays.get(best + 1).copied().unwrap_or(delays[best]);
        delays = (0..9).map(|k| low + (high - low) * f64::from(k) / 8.0).collect();
    }
    Ok(None)
}
