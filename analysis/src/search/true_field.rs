//! At which vector a shape is looked at: the measured one, or the one without the disturbance.
//!
//! The model of a calibration evaluates `Φ` at the measured vector, which is what a correction has. A sensor may as well
//! obey `ĥ = x + Φ(x) θ` with `x = A h + b`: a core saturates with the field it is in, not with its own reading. The two
//! differ in the second order, which beyond twice the noise is enough to bias coefficients by several standard errors and
//! to look like a further effect. Where the data tell the two apart the search goes on with the one that fits.

use crate::base::engine::{Design, Fitted};
use crate::base::looked_at::{LookedAt, Place, Seen, Shared};
use crate::base::prior::Prior;
use crate::base::term::{BadShape, Term, ready};
use crate::samples::series::Autocorrelation;
use crate::search::state::MOST_SEARCHED;
use crate::threads::parts;
use ironout::effect::{Acts, Coefficients, Effect, MAX_INPUTS, Quantities};
use ironout::study::{Model, Residual};
use ironout::vector::{determinant, dot, inverse_3x3, minus, norm, scaled, times};
use std::ops::Range;
use std::sync::Arc;

/// The undisturbed vector must take this many variances off the squared error. By chance, the wrong one does in one log of
/// a thousand at most.
const PREFERRED: f64 = 10.0;
/// Rounds in which coefficients and undisturbed vectors settle.
const MOST_ROUNDS: usize = 16;
/// After so many the error must be below that of the measured vector.
const PATIENCE: usize = 6;
/// The same in a long log: its thinned copy has been asked with more.
const LITTLE_PATIENCE: usize = 1;
/// Rounds have settled where one changes the squares by so many variances of a sample, before the vectors are held ...
const SETTLED: f64 = 0.1;
/// ... and where they are not: that much a coefficient moves within its own error.
const NEARLY_SETTLED: f64 = 1.0;
/// A round that changes the squares by more than this share goes far.
const FAR: f64 = 0.01;
/// A vector that is held may leave so many times the squares.
const AS_GOOD: f64 = 1.01;
/// Steps from a measured vector to the undisturbed one (Newton's).
const MOST_STEPS: usize = 12;
/// The undisturbed vector has settled when what it gives is this near to the reading, µT.
const SETTLED_UT: f64 = 1e-4;
/// The answer of the readings to the field is told from a step of this size, µT.
const STEP_UT: f64 = 1e-3;
/// Where a volume of fields becomes one of readings that is less than this share of it, the readings fold over.
const FOLDED: f64 = 0.1;

/// At the undisturbed vector, as coefficients near the effect's own give it.
#[derive(Clone, Copy)]
struct AtTrueField(Coefficients<f64>);

impl AtTrueField {
    /// What the sensor reads in the field that these quantities have.
    fn reading_ut(&self, inner: &dyn Effect<f64>, near: &Quantities<f64>) -> [f64; 3] {
        minus(near.measured_ut, scaled(inner.disturbance(near, &self.0), -1.0))
    }

    /// How the reading answers to the field there, inverted, by differences. `None` where the readings fold over, or nearly.
    fn inverse(
        &self,
        inner: &dyn Effect<f64>,
        near: &Quantities<f64>,
        reading_ut: [f64; 3],
    ) -> Option<[[f64; 3]; 3]> {
        let mut answers = [[0.0; 3]; 3];
        for axis in 0..3 {
            let mut beside = *near;
            beside.measured_ut[axis] += STEP_UT;
            let moved = minus(self.reading_ut(inner, &beside), reading_ut);
            (0..3).for_each(|row| answers[row][axis] = moved[row] / STEP_UT);
        }
        if determinant(&answers) > FOLDED { inverse_3x3(&answers) } else { None }
    }
}

impl Place for AtTrueField {
    fn vector_ut(&self, inner: &dyn Effect<f64>, at: &Quantities<f64>) -> [f64; 3] {
        let mut near = *at;
        let mut found = self.reading_ut(inner, &near);
        for _ in 0..MOST_STEPS {
            let lacks = minus(at.measured_ut, found);
            if !(norm(lacks) > SETTLED_UT) {
                break;
            }
            // Coefficients on their way may fold the readings over, and then no field gives this one: the nearest is taken.
            let Some(inverse) = self.inverse(inner, &near, found) else { break };
            let mut next = near;
            next.measured_ut = minus(near.measured_ut, scaled(times(&inverse, lacks), -1.0));
            let there = self.reading_ut(inner, &next);
            // Past the fold.
            if !(norm(minus(at.measured_ut, there)) < norm(lacks)) {
                break;
            }
            (near, found) = (next, there);
        }
        near.measured_ut
    }
}

/// The measured vectors without their noise, as a model's residuals show it: columns made of the noisy ones would correlate
/// with them.
fn without_noise(design: &Design, model: &Model<f64>, terms: &[Term]) -> Result<Vec<[f64; 3]>, BadShape> {
    let list: Vec<&Term> = terms.iter().collect();
    let within = |range: &Range<usize>| -> Result<Vec<[f64; 3]>, BadShape> {
        let mut vectors: Vec<[f64; 3]> =
            design.samples.readings[range.clone()].iter().map(|reading| reading.measured_ut).collect();
        design.rows(range.clone(), model, &list, |sample, row, residual| {
            let against = [row[0], row[1], row[2]];
            let off = scaled(against, -residual / dot(against, against).max(f64::MIN_POSITIVE));
            let vector = &mut vectors[sample - range.start];
            *vector = minus(*vector, off);
        })?;
        Ok(vectors)
    };
    Ok(parts(design.samples.len(), within)?.concat())
}

/// The undisturbed vector of one reading, and of what reads nearly the same.
struct Nearby {
    /// The reading, µT.
    reading_ut: [f64; 3],
    /// The undisturbed vector, µT.
    vector_ut: [f64; 3],
    /// How it follows the reading there.
    inverse: [[f64; 3]; 3],
    /// Where that is only the first step to it: while a fit still goes far.
    exactly: Option<AtTrueField>,
}

impl Place for Nearby {
    fn vector_ut(&self, inner: &dyn Effect<f64>, at: &Quantities<f64>) -> [f64; 3] {
        let mut near = *at;
        let Some(exactly) = self.exactly else {
            return minus(self.vector_ut, times(&self.inverse, minus(self.reading_ut, at.measured_ut)));
        };
        near.measured_ut = minus(self.vector_ut, minus(self.reading_ut, at.measured_ut));
        let mut before = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let lacks = minus(at.measured_ut, exactly.reading_ut(inner, &near));
            let left = norm(lacks);
            if left <= SETTLED_UT {
                return near.measured_ut;
            }
            if !(left < 0.5 * before) {
                break;
            }
            before = left;
            near.measured_ut = minus(near.measured_ut, scaled(times(&self.inverse, lacks), -1.0));
        }
        exactly.vector_ut(inner, at)
    }
}

/// What an effect that reads the vector alone is asked in one sample.
fn asked(term: &Term, sample: usize, measured_ut: [f64; 3]) -> Quantities<f64> {
    let inputs = term.inputs.get(sample).copied().unwrap_or([0.0; MAX_INPUTS]);
    Quantities { measured_ut, centred_ut: measured_ut, turning_ut_per_s: [0.0; 3], inputs }
}

/// The term with its shape at the undisturbed vector, as these coefficients give it.
fn looked_at<'a>(
    term: &Term<'a>,
    inner: &Shared<'a>,
    at: AtTrueField,
    goes_far: bool,
    readings_ut: &[[f64; 3]],
) -> Term<'a> {
    let effect: Shared = Arc::new(LookedAt { inner: inner.clone(), place: at });
    let of_sample = |(sample, &reading_ut): (usize, &[f64; 3])| -> Shared<'a> {
        let mut near = asked(term, sample, reading_ut);
        near.measured_ut = at.vector_ut(inner.as_ref(), &near);
        let there = at.reading_ut(inner.as_ref(), &near);
        let Some(inverse) = at.inverse(inner.as_ref(), &near, there) else { return effect.clone() };
        let exactly = goes_far.then_some(at);
        let place = Nearby { reading_ut, vector_ut: near.measured_ut, inverse, exactly };
        Arc::new(LookedAt { inner: inner.clone(), place })
    };
    // What reads more of the field than the vector is solved for anew at every look.
    let known = || Arc::new(readings_ut.iter().enumerate().map(of_sample).collect());
    let known_at = (!inner.reads_centre()).then(known);
    Term { effect, known_at, ..term.clone() }
}

/// The same with that vector held as it is at each of these readings, which is cheap to go on with.
fn held_at<'a>(term: &Term<'a>, inner: &Shared<'a>, readings_ut: &[[f64; 3]]) -> Term<'a> {
    let at = AtTrueField(term.coefficients);
    let of_sample = |(sample, &reading_ut): (usize, &[f64; 3])| -> Shared<'a> {
        let place = Seen(at.vector_ut(inner.as_ref(), &asked(term, sample, reading_ut)));
        Arc::new(LookedAt { inner: inner.clone(), place })
    };
    let known = || Arc::new(readings_ut.iter().enumerate().map(of_sample).collect());
    let known_at = (!inner.reads_centre()).then(known);
    Term { effect: Arc::new(LookedAt { inner: inner.clone(), place: at }), known_at, ..term.clone() }
}

/// The model with its shapes at the undisturbed vector, settled, from one that is near. `None` where the fit fails.
fn at_true_field<'a>(
    design: &Design,
    plain: &Fitted<'a>,
    near: &Fitted,
    hold: bool,
    known: &Prior,
) -> Result<Option<Fitted<'a>>, BadShape> {
    let inner: Vec<_> = plain.terms.iter().map(|term| term.effect.clone()).collect();
    let mut now = Fitted { model: near.model, squares: f64::INFINITY, ..plain.clone() };
    for term in &mut now.terms {
        if let Some(same) = near.terms.iter().find(|other| other.id == term.id) {
            term.coefficients = same.coefficients;
        }
    }
    let mut at: Vec<_> = now.terms.iter().map(|term| term.coefficients).collect();
    let patience = if design.samples.len() > MOST_SEARCHED { LITTLE_PATIENCE } else { PATIENCE };
    let mut best: Option<Fitted> = None;
    let mut goes_far = true;
    let settles = if hold { SETTLED } else { NEARLY_SETTLED };
    let readings_ut: Vec<_> = design.samples.readings.iter().map(|reading| reading.measured_ut).collect();
    for round in 0..MOST_ROUNDS {
        let mut terms = now.terms.clone();
        for ((term, inner), at) in terms.iter_mut().zip(&inner).zip(&mut at) {
            // Half way: coefficients that nearly make up for each other would overshoot.
            for (old, new) in at.iter_mut().zip(term.coefficients) {
                *old = 0.5 * (*old + new);
            }
            if term.acts(Acts::Measured) {
                *term = looked_at(term, inner, AtTrueField(*at), goes_far, &readings_ut);
            }
        }
        // A shape that ran away is no reason to give up the model that stands.
        let Ok(Some(next)) = design.approach(now.model, terms, known) else { break };
        let change = (next.squares - now.squares).abs();
        let settled = (hold || !goes_far) && change < settles * next.squares / next.rows.max(1.0);
        goes_far = hold || change > FAR * next.squares;
        now = next;
        // Near a fold the rounds do not settle: the best of them counts.
        if best.as_ref().is_none_or(|best| now.squares < best.squares) {
            best = Some(now.clone());
        }
        let behind = |best: &Fitted| best.squares > plain.squares;
        if settled || (round >= patience && best.as_ref().is_none_or(behind)) {
            break;
        }
    }
    let Some(best) = best.filter(|best| best.squares < plain.squares) else { return Ok(None) };
    if !hold {
        return Ok(Some(best));
    }
    let Ok(readings_ut) = without_noise(design, &best.model, &best.terms) else { return Ok(Some(best)) };
    let mut terms = best.terms.clone();
    for (term, inner) in terms.iter_mut().zip(&inner).filter(|(term, _)| term.acts(Acts::Measured)) {
        *term = held_at(term, inner, &readings_ut);
    }
    let held = design.approach(best.model, terms, known).ok().flatten();
    let held = held.filter(|held| held.squares < AS_GOOD * best.squares);
    Ok(held.or(Some(best)))
}

/// Whether shapes of it are looked at elsewhere than at the measured vector.
fn is_elsewhere(fitted: &Fitted) -> bool {
    fitted.terms.iter().any(|term| term.known_at.is_some())
}

/// Its effects with their shapes at the readings.
fn at_the_readings<'a>(fitted: &Fitted<'a>) -> Vec<Term<'a>> {
    let mut terms = fitted.terms.clone();
    for term in &mut terms {
        if let (Some(made), true) = (term.made, term.acts(Acts::Measured)) {
            term.effect = ready(made);
            term.known_at = None;
        }
    }
    terms
}

/// A model whose undisturbed vectors were held, with them as its coefficients give them. `None` where there are none.
pub fn let_go<'a>(
    design: &Design,
    fitted: &Fitted<'a>,
    known: &Prior,
) -> Result<Option<Fitted<'a>>, BadShape> {
    let Some(plain) = as_corrected(design, fitted, known)? else { return Ok(None) };
    at_true_field(design, &plain, &plain, false, known)
}

/// The model as a correction has it, fitted with all shapes at the readings. `None` where they are there already.
pub fn as_corrected<'a>(
    design: &Design,
    fitted: &Fitted<'a>,
    known: &Prior,
) -> Result<Option<Fitted<'a>>, BadShape> {
    if !is_elsewhere(fitted) {
        return Ok(None);
    }
    design.fit(fitted.model, at_the_readings(fitted), known)
}

/// Of the two models the one that the data ask for; the shapes at the measured vector where they do not tell. `near` may have
/// found the other one of the same effects in some of the samples.
pub fn prefer<'a>(
    design: &Design,
    fitted: Fitted<'a>,
    near: Option<&Fitted>,
    known: &Prior,
) -> Result<Fitted<'a>, BadShape> {
    if design.residual != Residual::Magnitude || !fitted.terms.iter().any(|term| term.acts(Acts::Measured)) {
        return Ok(fitted);
    }
    let terms = at_the_readings(&fitted);
    let Some(plain) = design.fit(fitted.model, terms, known)? else { return Ok(fitted) };
    // With the vectors held a search goes on more cheaply and more surely. What is said of all samples of a long log, which no
    // search follows, has them follow its readings.
    let hold = design.samples.len() <= MOST_SEARCHED;
    let mut other = None;
    if let Some(near) = near.filter(|near| is_elsewhere(near)) {
        other = at_true_field(design, &plain, near, hold, known)?;
    }
    if other.is_none() {
        other = at_true_field(design, &plain, &plain, hold, known)?;
    }
    let Some(other) = other else { return Ok(plain) };
    let list: Vec<&Term> = other.terms.iter().collect();
    let residuals = design.residuals(&other.model, &list)?;
    let time = Autocorrelation::of(&residuals).time;
    let variance = other.squares / other.rows.max(1.0) * time;
    let better = other.squares.is_finite() && plain.squares - other.squares > PREFERRED * variance;
    Ok(if better { other } else { plain })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ironout::effect::{MAX_COEFFICIENTS, Nonlinearity};

    /// The field at which the shape is looked at, of a reading of one axis, with this cube.
    fn field_of(reading: f64, cube: f64) -> f64 {
        let mut coefficients = [0.0; MAX_COEFFICIENTS];
        coefficients[3..6].fill(cube);
        let at = Quantities {
            measured_ut: [reading, 0.0, 0.0],
            centred_ut: [reading, 0.0, 0.0],
            turning_ut_per_s: [0.0; 3],
            inputs: [0.0; MAX_INPUTS],
        };
        AtTrueField(coefficients).vector_ut(&Nonlinearity, &at)[0]
    }

    #[test]
    fn a_core_that_saturates_is_looked_at_in_the_field_it_is_in() {
        let cube = -5e-5;
        for field in [-55.0_f64, -20.0, 8.0, 40.0, 60.0] {
            let found = field_of(field + cube * field.powi(3), cube);
            assert!((found - field).abs() < 1e-3, "{found} for {field}");
        }
    }

    #[test]
    fn a_reading_that_no_field_gives_is_looked_at_near_the_largest_that_there_is() {
        // Readings end at 54.4, in a field of 81.6.
        let found = field_of(70.0, -5e-5);
        assert!((60.0..90.0).contains(&found), "{found}");
    }
}
