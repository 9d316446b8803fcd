//! The effects that `--add` asks for, put into the model.

use crate::base::engine::Fitted;
use crate::base::mounting;
use crate::base::term::Term;
use crate::evidence::select::{Selection, placed};
use crate::outcome::request::{Options, Refusal};
use crate::search::candidates::Catalogue;
use crate::search::screen::test;
use crate::search::state::Fitter;
use crate::similar;
use ironout::extended::MAX_EFFECTS;
use ironout::study::Model;

/// What the likelihood says of these effects beside a model: where what is searched of each lies, their coefficients, and offset and matrix
/// beside them.
pub(crate) fn placed_at<'a>(
    fitter: &Fitter<'_, 'a>,
    start: &Fitted<'a>,
    ids: &[&String],
) -> Result<(Vec<Term<'a>>, Option<Model<f64>>), Refusal> {
    let (catalogue, registry) = (fitter.catalogue, fitter.catalogue.registry);
    let unknown = |id: &String| Refusal::cannot_add(id, cannot_add(catalogue, id));
    let mut asked = Vec::new();
    for id in ids {
        let named = registry.parse(id).filter(|named| catalogue.build(named, 0.0).is_some());
        asked.push(named.ok_or_else(|| unknown(id))?);
    }
    let found = placed(fitter.design.samples, catalogue.table(), registry, &fitter.begin(start), &asked);
    let Selection { found, model, .. } = match found {
        Ok(found) => found,
        Err(Some(index)) => return Err(unknown(ids[index])),
        // Without a model of the log nothing is searched: what needs no place is fitted all the same.
        Err(None) => Selection::default(),
    };
    let mut terms = Vec::new();
    for (index, (id, named)) in ids.iter().zip(&asked).enumerate() {
        let one = found.get(index);
        if one.is_none() && named.form.searched.is_some() {
            return Err(unknown(id));
        }
        let own = catalogue.build(named, one.map_or(0.0, |one| one.parameter)).ok_or_else(|| unknown(id))?;
        let (trials, coefficients) =
            one.map_or((1.0, own.coefficients), |one| (one.trials, one.coefficients));
        terms.push(Term { id: id.to_string(), trials, coefficients, ..own });
    }
    Ok((terms, model))
}

/// Whether it may be a coupling or a pure delay, which the data decide.
fn is_coupling(id: &str, options: &Options) -> bool {
    let named = options.registry.parse(id);
    named.is_some_and(|named| !named.family.delay_coefficients(named.form).is_empty())
}

/// A model with the effects that were asked for.
pub(crate) struct Added<'a> {
    /// It.
    pub(crate) start: Fitted<'a>,
    /// Whether a pure lag was asked for.
    pub(crate) pure_lag: bool,
}

/// Adds what `--add` names to the base model; or why that cannot be fitted.
pub(crate) fn asked_for<'a>(
    fitter: &Fitter<'_, 'a>,
    base: &Fitted<'a>,
    options: &Options,
) -> Result<Result<Added<'a>, String>, Refusal> {
    let mut ids: Vec<&String> = Vec::new();
    for id in options.add.iter().filter(|id| !mounting::is_one(id)) {
        if !ids.contains(&id) {
            ids.push(id);
        }
    }
    if let Some(more) = ids.get(MAX_EFFECTS) {
        return Err(Refusal::cannot_add(more, format!("a calibration stores at most {MAX_EFFECTS} effects")));
    }
    // Which of the two a coupling is shows only beside the others.
    let (couplings, others): (Vec<&String>, Vec<&String>) =
        ids.into_iter().partition(|id| is_coupling(id, options));
    let mut start = base.clone();
    let mut pure_lag = false;
    for list in [others, couplings].into_iter().filter(|list| !list.is_empty()) {
        let (mut terms, near) = placed_at(fitter, &start, &list)?;
        if fitter.catalogue.has_down() {
            for term in terms.extract_if(.., |term| !term.hidden_delay().is_empty()) {
                // Whether it is the coupling or the pure delay, the data decide.
                let alone = Term { coefficients: Default::default(), ..term.clone() };
                let tested = test(&fitter.design, &start, &alone, 1)?;
                if !tested.is_some_and(|tested| tested.accepted) {
                    pure_lag = true;
                    continue;
                }
                start = match fitter.with(&start, vec![term.clone()], near)? {
                    Some(next) => fitter.aligned(next)?,
                    None => return Ok(Err(does_not_converge(std::iter::once(term.id.as_str())))),
                };
            }
        }
        if terms.is_empty() {
            continue;
        }
        let ids: Vec<String> = terms.iter().map(|term| term.id.clone()).collect();
        start = match fitter.with(&start, terms, near)? {
            Some(next) => fitter.aligned(next)?,
            None => return Ok(Err(does_not_converge(ids.iter().map(String::as_str)))),
        };
    }
    Ok(Ok(Added { start, pure_lag }))
}

fn does_not_converge<'i>(ids: impl Iterator<Item = &'i str>) -> String {
    let ids: Vec<&str> = ids.collect();
    format!(
        "the fit with {} does not converge: in this log the effect and the calibration are nearly collinear. Fix: drop it, \
         or record more",
        ids.join(" and ")
    )
}

pub(crate) fn cannot_add(catalogue: &Catalogue, id: &str) -> String {
    if let Some(one) = catalogue.untestable().into_iter().find(|one| one.id == id) {
        return one.why;
    }
    let known: Vec<String> = catalogue.offered().map(|named| named.to_string()).collect();
    similar::unknown_effect(id, &known)
}
