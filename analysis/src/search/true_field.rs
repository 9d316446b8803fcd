//! Effects that follow the field at the sensor, not its reading.
//!
//! A core that saturates, or gains and cross-axis responses before the amplifier, read the field as it is. Others, behind a feedback or in
//! what reads out the sensor, follow the reading. Where an effect is strong the two differ, and the data tell which it is: the shapes are
//! also looked at the undisturbed vectors, which are the closest points of the likeliest model of that kind.

use crate::base::engine::{Design, Fitted};
use crate::base::looked_at::{LookedAt, Shared};
use crate::base::prior::Prior;
use crate::base::term::{BadShape, Term, ready};
use crate::bounds::MIN_ODDS;
use crate::evidence::select::{Begin, undisturbed_ut};
use crate::samples::series::Autocorrelation;
use crate::search::state::Fitter;
use ironout::effect::Acts;
use ironout::study::{Model, Residual};
use std::sync::Arc;

/// The term with its shape at these vectors, one a sample.
fn held_at<'a>(term: &Term<'a>, vectors_ut: &[[f64; 3]]) -> Term<'a> {
    let of_sample = |vector_ut: &[f64; 3]| -> Shared<'a> {
        Arc::new(LookedAt { inner: term.effect.clone(), vector_ut: *vector_ut })
    };
    Term { known_at: Some(Arc::new(vectors_ut.iter().map(of_sample).collect())), ..term.clone() }
}

/// The model as a correction has it, fitted with all shapes at the readings. `None` where they are there already.
pub fn as_corrected<'a>(
    design: &Design,
    fitted: &Fitted<'a>,
    known: &Prior,
) -> Result<Option<Fitted<'a>>, BadShape> {
    if fitted.terms.iter().all(|term| term.known_at.is_none()) {
        return Ok(None);
    }
    let mut terms = fitted.terms.clone();
    for term in &mut terms {
        if let (Some(made), true) = (term.made, term.known_at.is_some()) {
            (term.effect, term.known_at) = (ready(made), None);
        }
    }
    design.fit(fitted.model, terms, known)
}

impl<'a> Fitter<'_, 'a> {
    /// Of a model with its shapes at the readings and of that with them at the undisturbed vectors the one that the data ask for; the
    /// first where they do not tell. The second begins at `begin` with `terms`.
    pub(crate) fn at_likelier_vectors(
        &self,
        plain: Option<Fitted<'a>>,
        begin: Model<f64>,
        terms: Vec<Term<'a>>,
    ) -> Result<Option<Fitted<'a>>, BadShape> {
        let design = &self.design;
        let reads = |term: &Term| term.acts(Acts::Measured);
        if design.residual != Residual::Magnitude || !terms.iter().any(reads) {
            return Ok(plain);
        }
        let terms = plain.as_ref().map_or(terms, |plain| plain.terms.clone());
        let near = Begin { model: &begin, known: self.known, stay: &terms, is_at_rest: false };
        let (table, registry) = (self.catalogue.table(), self.catalogue.registry);
        let Some(vectors_ut) = undisturbed_ut(design.samples, table, registry, &near) else {
            return Ok(plain);
        };
        let held = |term: &Term<'a>| if reads(term) { held_at(term, &vectors_ut) } else { term.clone() };
        let held = terms.iter().map(held).collect();
        // A shape that ran away is no reason to give up the model that stands.
        let Ok(Some(other)) = design.fit(begin, held, self.known) else { return Ok(plain) };
        let Some(plain) = plain else { return Ok(Some(other).filter(|other| other.converged)) };
        let residuals = design.residuals(&other.model, &other.terms.iter().collect::<Vec<_>>())?;
        let variance = other.squares / other.rows.max(1.0) * Autocorrelation::of(&residuals).time;
        let is_likelier = plain.squares - other.squares > MIN_ODDS * variance;
        Ok(Some(if is_likelier { other } else { plain }))
    }
}
