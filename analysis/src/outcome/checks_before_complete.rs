//! What speaks against a verdict that would reassure, and what may hide behind one that names nobody.

use crate::base::applied::Applied;
use crate::base::quality::NoiseEstimate;
use crate::base::term::{BadShape, Term};
use crate::outcome::view::View;
use crate::samples::faults;
use crate::search::screen::WORTH_NAMING;
use crate::search::state::{Judged, held_out_rms};
use crate::search::step_evidence::readings_jump;
use ironout::effect::Follows;

/// The squared held-out error exceeds what is expected of noise by chance by so many times that excess ...
const UNSEEN_SLACK: f64 = 2.0;
/// ... and by this share of the noise's square.
const UNSEEN_LEAST: f64 = 0.1;
/// Many parameters and a long memory excuse no held-out error of more than so many times what the noise leaves ...
const UNSEEN_MOST: f64 = 4.0 / 3.0;

/// What was found predicts where it lowers the held-out error to this share.
const PREDICTS: f64 = 0.45;

/// So many effects that explain the most are looked at with what stands out beside them.
const LEADERS: usize = 3;
/// A column that meets the residual so rarely by chance says that it is no noise.
const NO_CHANCE: f64 = 1e-7;

/// Directions with a larger cosine than this are the same: by chance three of a hundred pairs.
const SAME_WAY: f64 = 0.97;

impl View<'_, '_> {
    /// The held-out error over the noise floor, where it is more than that many parameters and that noise's memory make of
    /// it: a model that explains the samples it has seen by chance, or structure that passes for noise.
    pub(super) fn fails_held_out(&self, left: &NoiseEstimate, applied: &Applied) -> Option<f64> {
        let fitted = &self.explanation.fitted;
        let held_out = held_out_rms(fitted)?;
        let ratio = applied.share * held_out / left.floor;
        let independent = fitted.rows / left.time.max(1.0);
        let expected = 1.0 + 2.0 * fitted.columns() as f64 / independent.max(1.0);
        let tolerated = expected + UNSEEN_SLACK * (expected - 1.0) + UNSEEN_LEAST;
        // ... unless what was found takes most of that error away: then the log is short, and the cause there.
        let before = self.explanation.steps.first().and_then(|first| first.held_out);
        let predicts = before.is_some_and(|before| held_out < PREDICTS * before);
        let most = if predicts { f64::INFINITY } else { UNSEEN_MOST * UNSEEN_MOST };
        (ratio * ratio > tolerated.min(most)).then_some(ratio)
    }

    /// A column that explains much of the residual, not by chance, though no effect of it holds: then that residual is no noise,
    /// whatever noise it looks like. On top of an earlier calibration a column that is elsewhere now is an offset for itself, and says
    /// nothing.
    pub(super) fn shows_a_column(&self) -> Option<String> {
        let explanation = &self.explanation;
        if self.known.earlier.is_some() {
            return None;
        }
        let of_column = explanation.first.iter().filter_map(|one| {
            let columns = one.term.effect.columns();
            let logged = |name: &str| self.samples.columns.iter().any(|own| own.name == name);
            let column = columns.iter().flatten().next().filter(|column| logged(column.name))?;
            let share = one.tested.decrease / explanation.base.squares;
            let chance = one.tested.p_value * explanation.count as f64;
            (chance < NO_CHANCE && share >= WORTH_NAMING).then(|| (column.name.to_string(), share, chance))
        });
        let (column, share, chance) = of_column.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let chance = if chance < 1e-99 { "below 1e-99".into() } else { format!("{chance:.0e}") };
        Some(format!(
            "{column} explains {:.0} % of the residual variance (p = {chance}), but no effect of it is significant by \
             itself. The cause may be a quantity that is correlated with it and was not logged",
            100.0 * share
        ))
    }

    /// What stands out of the base model with an effect that explains much, though not with certainty: a magnet that passed may have
    /// hidden it.
    pub(super) fn beside_leaders(&self) -> Result<Vec<(usize, usize)>, BadShape> {
        let explanation = &self.explanation;
        let mut first: Vec<_> =
            explanation.first.iter().filter(|one| one.tested.decrease.is_finite()).collect();
        first.sort_by(|a, b| b.tested.decrease.total_cmp(&a.tested.decrease));
        let worth = |one: &&&Judged| one.tested.decrease >= WORTH_NAMING * explanation.base.squares;
        for leader in first.iter().filter(worth).take(LEADERS) {
            let terms = vec![leader.term.clone()];
            let Some(with) = self.design.fit(explanation.base.model, terms, self.known)? else { continue };
            let list: Vec<&Term> = with.terms.iter().collect();
            let found = faults::bursts(&self.design.residuals(&with.model, &list)?);
            if !found.is_empty() {
                return Ok(found);
            }
        }
        Ok(Vec::new())
    }

    /// Shapes in time that point the same way stand in for one slow cause that the log does not hold: two events, or an event
    /// and a drift, have no reason to. A step by which the readings jump is none.
    pub(super) fn stand_ins(&self) -> Option<String> {
        let in_time = self.explanation.fitted.terms.iter().filter(|term| term.follows(Follows::Time));
        let jumps = |term: &Term| {
            let at_s = term.parts().map_or(f64::NAN, |parts| parts.parameter);
            term.named().is_some_and(|named| named.form.is_repeated())
                && readings_jump(self.samples, term, at_s).is_some()
        };
        let list: Vec<&Term> = in_time.filter(|term| term.k() == 3 && !jumps(term)).collect();
        let dot = |a: &Term, b: &Term| (0..3).map(|i| a.coefficients[i] * b.coefficients[i]).sum::<f64>();
        let alike = |a: &Term, b: &Term| dot(a, b).abs() > SAME_WAY * (dot(a, a) * dot(b, b)).sqrt();
        let pairs = list.iter().enumerate().flat_map(|(at, a)| list[at + 1..].iter().map(move |b| (*a, *b)));
        let (a, b) = pairs.into_iter().find(|(a, b)| alike(a, b))?;
        Some(format!(
            "{} and {} change the offset in the same direction. They are probably proxies for one cause that was not \
             logged. Fix: log what changes over time (temperature, current)",
            a.id, b.id
        ))
    }
}
