//! The noise-free point that the shapes look at, and how a strong disturbance answers when the model moves.

use super::base::{Linearised, Model};
use super::sample::{NotFinite, Observation, Term};
use super::secant::Secant;
use crate::effect::{Bends, Quantities, Shape};
use crate::math::Real;
use crate::vector::{cross, dot, minus, norm, plus, scaled};

/// Looks at a disturbance that depends on the field it disturbs.
const MOST_ITERATIONS: usize = 24;
/// After so many a strong one is hastened; a weak one stands by then.
const PLAIN_LOOKS: usize = 2;

/// The measured vector without its noise, and the same about the centre.
#[derive(Clone, Copy)]
struct ClosestPoint<T> {
    measured: [T; 3],
    centred: [T; 3],
}

/// How a disturbance that looks at the field answers to a change of that field. The columns of a strong effect are not
/// its shape alone: what the shape looks at moves with every parameter.
#[derive(Clone, Copy)]
pub(super) struct Reaction<T> {
    /// Two directions along the ellipsoid, ...
    along: [[T; 3]; 2],
    /// ... what the disturbance does for a step of the centred vector along each, ...
    follows: [[T; 3]; 2],
    /// ... for a step of the measured vector that moves the residual by one, ...
    outward: [T; 3],
    /// ... for a step of the centred vector by as much, ...
    inward: [T; 3],
    /// ... and for a step of the turning vector along each axis. `None` where nothing turns.
    turning: Option<[[T; 3]; 3]>,
    /// What that part of it that bends the field does for a step of the offset along each axis, which moves the undisturbed reading.
    /// `None` where nothing bends the field.
    by_offset: Option<[[T; 3]; 3]>,
}

impl<T: Real> Reaction<T> {
    /// Of a disturbance that looks at nothing.
    fn none() -> Self {
        let zero = [T::zero(); 3];
        Reaction {
            along: [zero; 2],
            follows: [zero; 2],
            outward: zero,
            inward: zero,
            turning: None,
            by_offset: None,
        }
    }

    /// What a pull takes off the residual for a step of the offset: `(I + ∂Φ_f θ)ᵀ pull`.
    pub(super) fn of_offset(&self, pull: [T; 3]) -> [T; 3] {
        match self.by_offset {
            Some(slopes) => plus(pull, slopes.map(|slope| dot(pull, slope))),
            None => pull,
        }
    }

    /// What `pull` becomes for a change of offset or coefficients: `zᵀ(I + Σ fᵢ aᵢᵀ) = pullᵀ`.
    pub(super) fn answer(&self, pull: [T; 3]) -> [T; 3] {
        let [[a, b], [c, d]] = self.follows.map(|follow| self.along.map(|along| dot(along, follow)));
        let (a, d) = (a + T::one(), d + T::one());
        let [p, q] = self.follows.map(|follow| dot(pull, follow));
        let determinant = a * d - b * c;
        if !(determinant > T::of(0.05)) {
            return pull;
        }
        let (u, v) = ((p * d - q * b) / determinant, (q * a - p * c) / determinant);
        let [first, second] = self.along;
        minus(minus(pull, scaled(first, u)), scaled(second, v))
    }

    /// By how much a change of the magnitude's residual grows that moves the ellipsoid, and with it the closest point: that of the matrix.
    pub(super) fn with_the_ellipsoid(&self, answered: [T; 3]) -> T {
        T::one() + dot(answered, self.inward)
    }

    /// By how much a change of the magnitude's residual grows because the noise-free measured vector moves with it.
    pub(super) fn grown(&self, answered: [T; 3]) -> T {
        let left = T::one() - dot(answered, self.outward);
        if left > T::of(0.1) { T::one() / left } else { T::one() }
    }
}

impl<T: Real> Model<T> {
    /// What the turning vector's own dependence on the matrix adds to the six columns of the triangle, where `pull` is what
    /// the disturbance answers with and `centred` the closest point.
    pub(super) fn through_turning(
        &self,
        reaction: &Reaction<T>,
        pull: [T; 3],
        centred: [T; 3],
        turn: Option<[T; 3]>,
    ) -> [T; 6] {
        let (Some(answers), Some(turn)) = (reaction.turning, turn) else { return [T::zero(); 6] };
        let back = self.transposed_inverse(answers.map(|answer| dot(pull, answer)));
        let [a, b, c] = self.transposed_rotation(cross(back, turn));
        let [d, e, f] = self.transposed_rotation(back);
        let [x, y, z] = centred;
        let [p, q, r] = self.quantities(centred, centred, Some(turn)).turning_ut_per_s;
        [d * p - a * x, d * q - a * y, d * r - a * z, e * q - b * y, e * r - b * z, f * r - c * z]
    }
}

impl<T: Real> Model<T> {
    /// Linearises at the closest point; leaves the shapes there in `shapes`.
    ///
    /// Columns made of the noisy sample would correlate with its residual; at the closest point they do not. A disturbance
    /// that depends on the field it disturbs is looked at until it stands.
    pub(super) fn at_closest<const N: usize>(
        &self,
        reading: &Observation<T>,
        terms: &[Term<'_, T>],
        shapes: &mut [Shape<T>; N],
    ) -> Result<(Linearised<T>, Reaction<T>), NotFinite> {
        let measured = reading.measured_ut;
        let linearise = |disturbance| self.linearise(measured, disturbance).ok_or(NotFinite::Sample);
        let closest_point_of = |at: &Linearised<T>| {
            let off = self.closest(at);
            ClosestPoint { measured: minus(measured, off), centred: minus(at.centred, off) }
        };
        let mut at = linearise([T::zero(); 3])?;
        if !terms.iter().any(|term| term.is_active()) {
            let closest = closest_point_of(&at);
            let quantities = self.quantities(closest.measured, closest.centred, reading.turn_radps);
            self.shapes(&quantities, terms.iter(), |_| true, shapes)?;
            return Ok((at, Reaction::none()));
        }
        let close = self.field_ut * (T::of(1e-7) + T::of(8.0) * T::epsilon());
        let mut closest = ClosestPoint { measured, centred: at.centred };
        let mut disturbance = [T::zero(); 3];
        let mut stands = true;
        let mut before = T::zero();
        // Whether repeating it leads away: then there is no going on without knowing its slope.
        let mut apart = false;
        let mut secant = Secant::default();
        let mut quantities = self.quantities(closest.measured, closest.centred, reading.turn_radps);
        for look in 0..MOST_ITERATIONS {
            let found = self.shapes(&quantities, terms.iter(), |term| term.is_active(), shapes)?;
            let moved = norm(minus(found, disturbance));
            // The first look is at the noisy sample. Where looks go apart there is no such disturbance.
            let leads_away = look > 1 && moved > before;
            if look > 0 && !(moved > close) || leads_away && apart {
                at = linearise(found)?;
                break;
            }
            apart |= leads_away;
            // What the first look did is of another map.
            let next = if look == 0 { found } else { secant.next(disturbance, found) };
            disturbance = if look < PLAIN_LOOKS && !apart { found } else { next };
            at = linearise(disturbance)?;
            before = moved;
            stands &= look == 0;
            closest = closest_point_of(&at);
            quantities = self.quantities(closest.measured, closest.centred, reading.turn_radps);
        }
        // Candidates look where the others have settled.
        self.shapes(&quantities, terms.iter(), |term| !term.is_active(), shapes)?;
        let reaction = if stands { Reaction::none() } else { self.reaction(&at, &closest, reading, terms)? };
        Ok((at, reaction))
    }

    /// How the disturbance answers, by differences.
    fn reaction(
        &self,
        at: &Linearised<T>,
        closest: &ClosestPoint<T>,
        reading: &Observation<T>,
        terms: &[Term<'_, T>],
    ) -> Result<Reaction<T>, NotFinite> {
        let (zero, one) = (T::zero(), T::one());
        let reads_centre = |term: &Term<'_, T>| term.reads_centre();
        let bends_field = |term: &Term<'_, T>| term.bends == Bends::Field;
        let all = |_: &Term<'_, T>| true;
        let sum_at = |at: Quantities<T>, some: &dyn Fn(&Term<'_, T>) -> bool| {
            let mut sum = [zero; 3];
            for (index, term) in terms.iter().enumerate().filter(|(_, term)| term.is_active() && some(term)) {
                let at = term.sees(&at, self.offset_ut);
                let own = term.effect.disturbance(&at, &term.coefficients);
                if own.iter().any(|value| !value.is_finite()) {
                    return Err(NotFinite::Effect(index));
                }
                sum = minus(sum, scaled(own, -one));
            }
            Ok(sum)
        };
        let quantities = |closest: &ClosestPoint<T>| {
            self.quantities(closest.measured, closest.centred, reading.turn_radps)
        };
        let here = quantities(closest);
        let size = norm(at.pull);
        let normal = scaled(at.pull, one / size);
        // Across the axis that the normal has least of.
        let [x, y, z] = normal.map(|value| value * value);
        let axis = if x <= y && x <= z {
            [one, zero, zero]
        } else if y <= z {
            [zero, one, zero]
        } else {
            [zero, zero, one]
        };
        let first = cross(normal, axis);
        let first = scaled(first, one / norm(first));
        let along = [first, cross(normal, first)];
        let step = self.field_ut * T::of(1e-3);
        let mut follows = [[zero; 3]; 2];
        let mut inward = [zero; 3];
        let mut turning = None;
        if terms.iter().any(|term| reads_centre(term) && term.is_active()) {
            let still = sum_at(here, &reads_centre)?;
            for (follow, direction) in follows.iter_mut().zip(along) {
                let moved =
                    ClosestPoint { centred: minus(closest.centred, scaled(direction, -step)), ..*closest };
                *follow = scaled(minus(sum_at(quantities(&moved), &reads_centre)?, still), one / step);
            }
            let moved = ClosestPoint { centred: minus(closest.centred, scaled(normal, -step)), ..*closest };
            inward = scaled(minus(sum_at(quantities(&moved), &reads_centre)?, still), one / (step * size));
            if reading.turn_radps.is_some() {
                let mut answers = [[zero; 3]; 3];
                for (axis, answer) in answers.iter_mut().enumerate() {
                    let mut moved = here;
                    if let Some(entry) = moved.turning_ut_per_s.get_mut(axis) {
                        *entry += step;
                    }
                    *answer = scaled(minus(sum_at(moved, &reads_centre)?, still), one / step);
                }
                turning = Some(answers);
            }
        }
        let moved = ClosestPoint { measured: minus(closest.measured, scaled(normal, -step)), ..*closest };
        let outward = minus(sum_at(quantities(&moved), &all)?, sum_at(here, &all)?);
        let outward = scaled(outward, one / (step * size));
        let mut by_offset = None;
        if terms.iter().any(|term| bends_field(term) && term.is_active()) {
            let still = sum_at(here, &bends_field)?;
            let mut slopes = [[zero; 3]; 3];
            for (axis, slope) in slopes.iter_mut().enumerate() {
                let mut moved = here;
                if let Some(entry) = moved.centred_ut.get_mut(axis) {
                    *entry += step;
                }
                *slope = scaled(minus(sum_at(moved, &bends_field)?, still), one / step);
            }
            by_offset = Some(slopes);
        }
        Ok(Reaction { along, follows, outward, inward, turning, by_offset })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pull_is_answered_by_what_the_disturbance_leaves_of_it() {
        let reaction = Reaction {
            along: [[0.8, 0.6, 0.0], [0.0, 0.0, 1.0]],
            follows: [[0.3, -0.2, 0.1], [0.15, 0.25, -0.4]],
            ..Reaction::none()
        };
        let pull = [0.5, -1.0, 2.0];
        let answered = reaction.answer(pull);
        // zᵀ(I + Σ fᵢ aᵢᵀ) is the pull again.
        for axis in 0..3 {
            let given: f64 =
                (0..2).map(|i| dot(answered, reaction.follows[i]) * reaction.along[i][axis]).sum();
            assert!((answered[axis] + given - pull[axis]).abs() < 1e-12, "{answered:?}");
        }
    }

    #[test]
    fn a_disturbance_that_repeating_leads_away_from_stands_too() {
        let matrix = [[1.05, 0.03, -0.02], [0.0, 0.97, 0.04], [0.0, 0.0, 1.01]];
        let turned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let of_field =
            |field_ut| Model::new([4.0, -7.0, 11.0], matrix, field_ut, turned, 0.6).expect("a model");
        let mut coefficients = [0.0; crate::effect::MAX_COEFFICIENTS];
        // At 40 µT the slope of the cubes is -1.4: a look that is off by one sends the next off by 1.4.
        coefficients[3..6].copy_from_slice(&[-3e-4, -2.9e-4, -3e-4]);
        let term = Term {
            effect: &crate::effect::Nonlinearity,
            coefficients,
            inputs: [0.0; 2],
            bends: Bends::Reading,
        };
        for measured_ut in [[39.0, -38.0, 36.0], [-40.0, 37.0, 41.0], [38.0, 40.0, -39.0]] {
            // In a field that the reading is 0.6 µT beyond.
            let model = of_field(50.0);
            let at = model.quantities(measured_ut, measured_ut, None);
            let plain = term.effect.disturbance(&at, &coefficients);
            let beyond = model.linearise(measured_ut, plain).expect("a row").residual;
            let model = of_field(50.0 + beyond - 0.6);
            let reading = Observation { measured_ut, turn_radps: None, down: None };
            let mut shapes = [crate::effect::no_shape(); 1];
            let (at, _) = model.at_closest(&reading, &[term], &mut shapes).expect("a row");
            // What was taken off is what the effect does at the point where it stands.
            let closest = minus(measured_ut, model.closest(&at));
            let there = model.quantities(closest, closest, None);
            let again = term.effect.disturbance(&there, &coefficients);
            let stands = model.linearise(measured_ut, again).expect("a row").residual;
            assert!((stands - at.residual).abs() < 1e-4, "{measured_ut:?}: {stands} and {}", at.residual);
        }
    }
}
