//! What is done with every model of effects: fit it, align it, settle it, and tell the error falling.

use crate::base::alignment::{align, without_effects};
use crate::base::applied::Applied;
use crate::base::engine::{Design, Fitted, SETTLED};
use crate::base::prior::Prior;
use crate::base::term::BadShape;
use crate::bounds::RAISES;
use crate::evidence::significance::Test;
use crate::search::candidates::Catalogue;
use crate::search::shown::Shown;
use ironout::study::{Residual, held_out};

/// The coupling's share along the identity has settled when it moves by less than this, s.
const SETTLED_S: f64 = 2e-5;
/// Rounds of fit and alignment at the end …
const SETTLING: usize = 12;
/// … until nothing moves by more than this share of the offset's and of the coefficients' size.
const SETTLED_SHARE: f64 = 1e-7;

/// The state of the model after one addition.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// The effect added; `None` for the base model.
    pub added: Option<String>,
    /// Rms residual, µT (rad for the dip).
    pub rms: f64,
    /// Rms residual on held-out blocks.
    pub held_out: Option<f64>,
}

/// Candidates that explain the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Confounded {
    /// Their ids, the one that stands in the model first.
    pub ids: Vec<String>,
}

/// What the search found.
#[derive(Clone)]
pub struct Explanation<'a> {
    /// The base model.
    pub base: Fitted<'a>,
    /// The model with everything found.
    pub fitted: Fitted<'a>,
    /// The error falling.
    pub steps: Vec<Step>,
    /// Groups that cannot be told apart.
    pub confounded: Vec<Confounded>,
    /// The candidates tested against the base model.
    pub first: Vec<Test>,
    /// The candidates tested last, against the final model.
    pub last: Vec<Test>,
    /// Effects that were found and are not certain.
    pub withdrawn: Vec<Withdrawn>,
    /// Candidates whose shape was not finite somewhere, and which were left out.
    pub dropped: Vec<String>,
    /// Whether the search ended before all was tried: at the limit of its work, or because the model ran away.
    pub ended_early: bool,
    /// How many candidates a round has.
    pub count: usize,
    /// p-value of an effect of the model given all others, corrected for its search, by id.
    pub chances: Vec<(String, f64)>,
    /// The tests of the effects that were asked for; empty after a search, which adds only what is shown.
    pub shown: Vec<Shown>,
}

impl<'a> Explanation<'a> {
    /// Of a model whose effects nobody searched.
    pub(crate) fn plain(base: Fitted<'a>, fitted: Fitted<'a>, steps: Vec<Step>) -> Self {
        Explanation {
            base,
            fitted,
            steps,
            confounded: Vec::new(),
            first: Vec::new(),
            last: Vec::new(),
            withdrawn: Vec::new(),
            dropped: Vec::new(),
            ended_early: false,
            count: 1,
            chances: Vec::new(),
            shown: Vec::new(),
        }
    }
}

/// Rms on held-out blocks.
pub fn held_out_rms(fitted: &Fitted) -> Option<f64> {
    let own: Vec<usize> = (0..fitted.columns()).collect();
    held_out(&fitted.blocks, Some(&fitted.prior), &own)?.rms()
}

/// The errors of a fitted model as its correction leaves them: rms, and rms on held-out blocks.
pub fn errors_applied(design: &Design, fitted: &Fitted) -> Result<(f64, Option<f64>), BadShape> {
    let share = Applied::of(design, fitted)?.share;
    Ok((share * fitted.rms(), held_out_rms(fitted).map(|held| share * held)))
}

fn state(design: &Design, added: Option<String>, fitted: &Fitted) -> Result<Step, BadShape> {
    let (rms, held_out) = errors_applied(design, fitted)?;
    Ok(Step { added, rms, held_out })
}

/// An effect that was found and is not certain.
#[derive(Debug, Clone, PartialEq)]
pub struct Withdrawn {
    /// Its id.
    pub id: String,
    /// Why it is not certain.
    pub why: String,
}

/// By how much two fits of the same effects differ, as the largest share of the offset's or of an effect's coefficients' size.
fn moved(one: &Fitted, other: &Fitted) -> f64 {
    let share = |a: &[f64], b: &[f64]| {
        let size = a.iter().fold(f64::MIN_POSITIVE, |most: f64, value| most.max(value.abs()));
        a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs() / size))
    };
    let effects = one.terms.iter().zip(&other.terms).map(|(a, b)| share(&a.coefficients, &b.coefficients));
    effects.fold(share(&one.model.offset_ut, &other.model.offset_ut), f64::max)
}

/// Fits and tests the effects of a log.
pub struct Fitter<'p, 'a> {
    /// What it runs over.
    pub design: Design<'p>,
    /// What it may add.
    pub catalogue: &'p Catalogue<'a>,
    /// What is known besides.
    pub known: &'p Prior,
    /// The base model's held-out error as `fit` gives it, which is the first of those that are told.
    pub base_held_out: Option<f64>,
}

impl<'p, 'a> Fitter<'p, 'a> {
    /// Over these samples.
    pub fn new(design: Design<'p>, catalogue: &'p Catalogue<'a>, known: &'p Prior) -> Self {
        Fitter { design, catalogue, known, base_held_out: None }
    }
}

impl<'a> Fitter<'_, 'a> {
    /// Gives a fitted model its rotation to the accelerometer, and a coupling to the turning field the share that is
    /// a pure delay, which only the dip sees. The magnitude does not depend on the rotation, but what turns with the gyro does.
    pub fn aligned(&self, fitted: Fitted<'a>) -> Result<Fitted<'a>, BadShape> {
        self.aligned_with(&mut true, fitted)
    }

    /// The same where `delays` says whether the share that is a delay is looked for: no more once the magnitude contradicts it.
    fn aligned_with(&self, delays: &mut bool, mut fitted: Fitted<'a>) -> Result<Fitted<'a>, BadShape> {
        if self.design.residual != Residual::Magnitude || !self.catalogue.has_down() {
            return Ok(fitted);
        }
        for _ in 0..8 {
            let clean = without_effects(self.design.samples, &fitted.model, &fitted.terms);
            let Some(alignment) = align(&clean, &fitted.model)? else { return Ok(fitted) };
            let index = fitted.terms.iter().position(|term| !term.hidden_delay().is_empty());
            // A coupling turns with the gyro. What the dip says beside it is told by forces of the board's own.
            if let (Some(_), true) = (index, alignment.by_gyro) {
                *delays = false;
                return Ok(match self.design.fit(alignment.model, fitted.terms.clone(), self.known)? {
                    Some(next) if next.squares <= RAISES * fitted.squares => next,
                    _ => fitted,
                });
            }
            fitted.model = alignment.model;
            if !*delays {
                return Ok(fitted);
            }
            let (Some(index), Some(lag)) = (index, self.catalogue.late_sensor()) else {
                return Ok(fitted);
            };
            // What the coupling's share along the identity still lacks, together with the rotation.
            let dip = Design::new(&clean, Residual::Dip);
            let fit = dip.fit_to(SETTLED, fitted.model, vec![lag], self.known)?;
            let Some(fit) = fit else { return Ok(fitted) };
            let lacking = fit.terms[0].coefficients[0];
            let mut terms = fitted.terms.clone();
            if let Some(coupled) = terms.get_mut(index) {
                for &entry in coupled.hidden_delay() {
                    coupled.coefficients[entry] += lacking;
                }
            }
            // Specific force of the board's own may look like a delay that the magnitude contradicts.
            match self.design.fit(fit.model, terms, self.known)? {
                Some(next) if next.squares <= RAISES * fitted.squares => fitted = next,
                _ => {
                    *delays = false;
                    return Ok(fitted);
                }
            }
            // What does not settle in one fit does not in eight.
            if lacking.abs() < SETTLED_S || !fitted.converged {
                return Ok(fitted);
            }
        }
        Ok(fitted)
    }

    /// A model with effects fitted so far that the way to it no longer shows: whoever adds the same effects, in whatever
    /// order, gets the same digits but for the last.
    pub fn to_the_end(&self, mut fitted: Fitted<'a>) -> Result<Fitted<'a>, BadShape> {
        if fitted.terms.is_empty() {
            return Ok(fitted);
        }
        let mut delays = true;
        let mut last = f64::INFINITY;
        for _ in 0..SETTLING {
            let before = fitted.clone();
            let aligned = self.aligned_with(&mut delays, before.clone())?;
            let next = self.design.fit_to(SETTLED, aligned.model, aligned.terms, self.known)?;
            fitted = match next {
                Some(next) => next,
                None => return Ok(before),
            };
            // What does not settle in one fit does not in twelve, nor where a round moves as much as the one before.
            let moves = moved(&before, &fitted);
            if moves <= SETTLED_SHARE || moves > 0.5 * last || !fitted.converged {
                break;
            }
            last = moves;
        }
        Ok(fitted)
    }

    /// No search: the effects that stand in the model, and the tests of the others.
    pub fn only(&self, base: Fitted<'a>, fitted: Fitted<'a>) -> Result<Explanation<'a>, BadShape> {
        let order: Vec<String> = fitted.terms.iter().map(|term| term.id.clone()).collect();
        let steps = self.falling(&base, &fitted, &order)?;
        Ok(Explanation::plain(base, fitted, steps))
    }

    /// The error falling as the effects of the final model are added in their order.
    pub(crate) fn falling(
        &self,
        base: &Fitted<'a>,
        fitted: &Fitted<'a>,
        order: &[String],
    ) -> Result<Vec<Step>, BadShape> {
        let mut first = state(&self.design, None, base)?;
        first.held_out = self.base_held_out.or(first.held_out);
        let mut steps = vec![first];
        let mut now = base.clone();
        for (index, id) in order.iter().enumerate() {
            if index + 1 == order.len() {
                now = fitted.clone();
            } else if let Some(term) = fitted.terms.iter().find(|term| term.id == *id) {
                let mut terms = now.terms.clone();
                terms.push(term.clone());
                if let Some(next) = self.design.fit(now.model, terms, self.known)? {
                    now = next;
                }
            }
            steps.push(state(&self.design, Some(id.clone()), &now)?);
        }
        Ok(steps)
    }
}
