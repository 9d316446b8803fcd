//! A model with one more effect, fully fitted.

use crate::base::engine::Fitted;
use crate::base::term::{BadShape, Term};
use crate::search::parameter;
use crate::search::search;
use crate::search::selected::finite;
use crate::search::state::Fitter;
use ironout::effect::Searched;

impl<'a> Fitter<'_, 'a> {
    /// The model with one more effect, fully refitted, and what fixes its shape moved to where the error is least. `None`
    /// where the fit does not converge, or runs away.
    pub(crate) fn with(&self, fitted: &Fitted<'a>, term: &Term<'a>) -> Result<Option<Fitted<'a>>, BadShape> {
        self.with_all(fitted, std::iter::once(term))
    }

    /// The same with several more.
    pub(crate) fn with_all<'p>(
        &self,
        fitted: &Fitted<'a>,
        more: impl Iterator<Item = &'p Term<'a>>,
    ) -> Result<Option<Fitted<'a>>, BadShape>
    where
        'a: 'p,
    {
        let mut terms = fitted.terms.clone();
        terms.extend(more.cloned());
        let Some(next) = finite(self.design.fit(fitted.model, terms, self.known))?.flatten() else {
            return Ok(None);
        };
        let next = finite(self.settled(next))?;
        Ok(next.filter(|next| next.converged))
    }

    /// The model with what fixes the shapes moved to where the error is least. What was found before an effect came in
    /// was found in the trace that this one left.
    pub(crate) fn settled(&self, fitted: Fitted<'a>) -> Result<Fitted<'a>, BadShape> {
        let next = parameter::refine(&self.design, fitted, self.catalogue, self.known)?;
        self.at_its_time(next)
    }

    /// A strong step bends the base that its time was searched at: searched again at the model with the step, each of
    /// several beside the others.
    pub(crate) fn at_its_time(&self, mut fitted: Fitted<'a>) -> Result<Fitted<'a>, BadShape> {
        for _ in 0..3 {
            let mut moved = false;
            for place in 0..fitted.terms.len() {
                let mut terms = fitted.terms.clone();
                if !matches!(terms[place].searched(), Some((Searched::At, _))) {
                    continue;
                }
                let step = terms.remove(place);
                // Without the step the others may run away: then it stays where it is.
                let Some(bare) = finite(self.design.hold(fitted.model, terms.clone(), self.known))? else {
                    continue;
                };
                let Some(named) = step.named() else { continue };
                let Some(found) = search::best(&self.design, &bare, self.catalogue, &named)? else {
                    continue;
                };
                if found.parts() == step.parts() {
                    continue;
                }
                let Term { id, coefficients, .. } = step;
                terms.insert(place, Term { id, coefficients, ..found });
                match self.design.fit(fitted.model, terms, self.known)? {
                    Some(next) if next.squares < fitted.squares => (fitted, moved) = (next, true),
                    _ => {}
                }
            }
            if !moved {
                break;
            }
        }
        Ok(fitted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::engine::Design;
    use crate::base::ground::Ground;
    use crate::base::prior::Prior;
    use crate::search::candidates::Catalogue;
    use crate::table::Table;
    use ironout::effect::{Effect, MAX_INPUTS, Quantities, Registry, Shape};
    use ironout::fit::Method;
    use ironout::study::Residual;
    use ironout_simulation::{EffectSpec, World, WorldOptions};

    /// A shape that is one near the field, and no number far from it.
    struct Near;

    impl Effect<f64> for Near {
        fn id(&self, out: &mut dyn std::fmt::Write) -> std::fmt::Result {
            out.write_str("near")
        }
        fn name(&self) -> &'static str {
            "near"
        }
        fn explanation(&self) -> &'static str {
            "It is one near the field."
        }
        fn coefficients(&self) -> usize {
            1
        }
        fn unit(&self) -> &'static str {
            "µT"
        }
        fn shape(&self, at: &Quantities<f64>, shape: &mut Shape<f64>) {
            let far = at.measured_ut.iter().any(|value| value.abs() > 1e3);
            shape[0] = [if far { f64::NAN } else { at.measured_ut[0] / 50.0 }; 3];
        }
    }

    #[test]
    fn what_runs_away_without_a_step_or_with_it_is_passed_over() {
        let step = EffectSpec::parse("step=6").expect("an effect");
        let log = World::new(WorldOptions {
            seed: 8,
            seconds: 40.0,
            effects: vec![step],
            ..WorldOptions::default()
        })
        .run();
        let table = Table::from_columns(log.named()).expect("columns");
        let ground = Ground::of(&table, Method::default(), None, None);
        let model = ground.base.as_ref().ok().and_then(|base| base.model()).expect("a base model");
        let samples = ground.counted.with_bursts.as_ref().unwrap_or(&ground.counted.samples);
        let catalogue = Catalogue::new(samples, &table, Registry::BUILT_IN);
        let (design, known) = (Design::new(samples, Residual::Magnitude), Prior::default());
        let fitter = Fitter::new(design, &catalogue, &known);
        let base = design.fit(model, Vec::new(), &known).ok().flatten().expect("a fit");
        let step = catalogue.searched().into_iter().find(|named| named.form.searched == Some(Searched::At));
        let step =
            search::best(&design, &base, &catalogue, &step.expect("steps")).ok().flatten().expect("a step");
        let with_step = fitter.with(&base, &step).ok().flatten().expect("a fit with the step");
        let inputs = std::sync::Arc::new(vec![[0.0; MAX_INPUTS]; samples.len()]);
        let made =
            catalogue.plain(false).into_iter().find(|term| term.id == "cross-axis").expect("an effect");
        let mut away = Term { effect: std::sync::Arc::new(Near), inputs, ..made };
        away.coefficients[0] = 1e6;
        assert!(matches!(design.hold(model, vec![away.clone()], &known), Err(BadShape::NotFinite(_))));

        // It stays where it is, ...
        let mut terms = with_step.terms.clone();
        terms.push(away.clone());
        let places: Vec<_> = terms.iter().map(|term| term.id.clone()).collect();
        let kept = fitter.at_its_time(Fitted { terms, ..with_step.clone() }).expect("a model");
        assert_eq!(kept.terms.iter().map(|term| term.id.clone()).collect::<Vec<_>>(), places);
        // ... and no candidate that runs away gives up the search.
        assert!(matches!(fitter.with(&with_step, &away), Ok(None)));
    }
}
