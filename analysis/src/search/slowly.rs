//! A column that moves slowly, held against any slow change: two things that wander meet by chance, and the fewer times they turn
//! the more often (spurious regression: Granger and Newbold, J. Econometrics 2, 1974).

use crate::base::engine::Fitted;
use crate::base::term::{BadShape, COLUMNS, Clock, Term};
use crate::search::screen::rivalry;
use crate::search::state::Greedy;
use ironout::effect::{Effect, Follows, Quantities, Shape};
use ironout::study::Residual;
use std::sync::Arc;

/// An offset that goes with time, its square and its cube: three numbers an axis. Beside a drift, which is the first of them
/// already, with the others.
struct Slowly {
    drifts: bool,
}

impl Slowly {
    fn powers(&self) -> std::ops::Range<usize> {
        usize::from(self.drifts)..POWERS
    }
}

/// Powers of time.
const POWERS: usize = 3;
/// A column moves slowly where so much of its variance follows these powers.
const SLOW: f64 = 0.6;
/// What it has beside them shows below this probability.
const SHOWS: f64 = 1e-3;
/// What slow change has beside the column is chance above this probability: then the column may be all of it.
const MORE: f64 = 0.05;

/// Legendre's polynomials one to three at `x` between -1 and 1: powers that do not resemble each other.
fn powers(x: f64) -> [f64; POWERS] {
    [x, 1.5 * x * x - 0.5, (2.5 * x * x - 1.5) * x]
}

impl Effect<f64> for Slowly {
    fn id(&self, out: &mut dyn std::fmt::Write) -> std::fmt::Result {
        out.write_str("slowly")
    }
    fn name(&self) -> &'static str {
        "slow change"
    }
    fn explanation(&self) -> &'static str {
        "The offset changes slowly. A slowly changing column must be significant in addition to that."
    }
    fn coefficients(&self) -> usize {
        3 * self.powers().len()
    }
    fn unit(&self) -> &'static str {
        "µT"
    }
    fn reads_centre(&self) -> bool {
        false
    }
    fn shape(&self, at: &Quantities<f64>, shape: &mut Shape<f64>) {
        let all = powers(at.inputs[0]);
        let places = self.powers().flat_map(|power| (0..3).map(move |axis| (power, axis)));
        for ((power, axis), vector) in places.zip(shape.iter_mut()) {
            *vector = [0.0; 3];
            vector[axis] = all[power];
        }
    }
}

/// Share of the values' variance that follows the powers of the places.
fn follows(values: &[f64], places: &[f64]) -> f64 {
    // The places need not be even, so that the powers are made orthogonal one by one.
    let mut left = values.to_vec();
    let mut basis: Vec<Vec<f64>> = vec![vec![1.0; values.len()]];
    for power in 0..POWERS {
        basis.push(places.iter().map(|x| powers(*x)[power]).collect());
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut whole = 0.0;
    for place in 0..basis.len() {
        let (before, rest) = basis.split_at_mut(place);
        let Some(own) = rest.first_mut() else { break };
        for other in before {
            let share = dot(own, other) / dot(other, other).max(f64::MIN_POSITIVE);
            own.iter_mut().zip(other.iter()).for_each(|(own, other)| *own -= share * other);
        }
        let share = dot(&left, own) / dot(own, own).max(f64::MIN_POSITIVE);
        left.iter_mut().zip(own.iter()).for_each(|(left, own)| *left -= share * own);
        if place == 0 {
            whole = dot(&left, &left);
        }
    }
    if whole > 0.0 { 1.0 - dot(&left, &left) / whole } else { 0.0 }
}

impl<'a> Greedy<'_, 'a> {
    /// Whether an effect of a column shows beside any slow change of the offset, or at least leaves nothing for that to explain; true
    /// of a column that does not move slowly.
    pub(crate) fn is_more_than_slow(&self, without: &Fitted<'a>, term: &Term<'a>) -> Result<bool, BadShape> {
        let Some(time) = &self.design.samples.time else { return Ok(true) };
        let drifts = |term: &Term| term.follows(Follows::Time) && term.searched().is_none();
        let slowly = Slowly { drifts: without.terms.iter().any(drifts) };
        let columns = without.columns() + term.k() + slowly.coefficients();
        if !term.follows(Follows::Column)
            || self.design.residual != Residual::Magnitude
            || term.inputs.len() != time.len()
            || columns > COLUMNS
        {
            return Ok(true);
        }
        let (Some(first), Some(last)) = (time.first(), time.last()) else { return Ok(true) };
        let half = (0.5 * (last - first)).max(f64::MIN_POSITIVE);
        let places: Vec<f64> = time.iter().map(|t| (t - first) / half - 1.0).collect();
        let values: Vec<f64> = term.inputs.iter().map(|input| input[0]).collect();
        if follows(&values, &places) < SLOW {
            return Ok(true);
        }
        let slowly = Term {
            id: "slow change".into(),
            made: None,
            effect: Arc::new(slowly),
            coefficients: Default::default(),
            inputs: Arc::new(places.iter().map(|x| [*x, 0.0]).collect()),
            trials: 1.0,
            clock: Clock::Stamps,
            known_at: None,
        };
        let fresh = Term { coefficients: Default::default(), ..term.clone() };
        let beside = rivalry(&self.design, without, &fresh, &slowly, self.known)?;
        Ok(beside.is_none_or(|beside| beside.first < SHOWS || beside.second > MORE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warming_board_is_slow_and_a_switch_is_not() {
        let places: Vec<f64> = (0..400).map(|i| f64::from(i) / 200.0 - 1.0).collect();
        let of = |shape: &dyn Fn(f64) -> f64| {
            follows(&places.iter().map(|x| shape(*x)).collect::<Vec<_>>(), &places)
        };
        assert!(of(&|x| 20.0 - 8.0 * (-2.0 * x).exp()) > 0.99);
        assert!(of(&|x| 3.0 + x) > 0.999_999);
        assert!(of(&|x| f64::from(u8::from((40.0 * x).sin() > 0.0))) < 0.2);
        assert!(of(&|_| 5.0) < 1e-9);
    }
}
