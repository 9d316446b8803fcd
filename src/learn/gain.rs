//! An effect taken into a calibration, or out of it, from what was learned.

use super::candidate::{Candidate, Found};
use super::finding::InUse;
use super::lateness::Lateness;
use super::layout::DRIFT_UNIT_MS;
use super::learner::Learner;
use super::point::Point;
use super::solve::{Chosen, Factor};
use super::sums::{WIDEST, Work};
use crate::calibration::Calibration;
use crate::effect::{BuiltIn, Effect};
use crate::extended::{Effects, ExtendedCalibration, FittedEffect, MAX_EFFECTS, Ranges};
use crate::fit::MAX_PREDICTED_ERROR;
use crate::math;
use crate::vector::{cross, dot, minus, norm, product, scaled};
use core::fmt;

/// Why no effect was taken in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotShown {
    /// What was learned does not determine it.
    Undetermined,
    /// The calibration carries as many as it can.
    Full,
}

impl fmt::Display for NotShown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Undetermined => f.write_str("not enough data to determine it: keep rotating the sensor"),
            Self::Full => {
                write!(f, "a calibration has at most {MAX_EFFECTS} effects: effect remove ID first")
            }
        }
    }
}

impl core::error::Error for NotShown {}

impl Learner {
    /// Coefficients of a candidate as a step of its columns.
    pub(super) fn in_columns(
        &self,
        candidate: Candidate,
        theta: [f64; 3],
        sign: f64,
        first: usize,
    ) -> [f32; WIDEST] {
        let field = self.point.map_or(1.0, |point| f64::from(point.field_ut));
        let unit = if candidate == Candidate::Drift { f64::from(DRIFT_UNIT_MS) * 1e-3 } else { 1.0 };
        let mut delta = [0.0; WIDEST];
        for (slot, value) in delta.iter_mut().skip(first).zip(theta) {
            *slot = (sign * value * unit / field) as f32;
        }
        delta
    }

    /// The coefficients that a step of a candidate's columns means.
    fn coefficients(&self, candidate: Candidate, values: &[f32; WIDEST]) -> Option<[f64; 3]> {
        let first = candidate.first_column()?;
        let field = self.point.map_or(1.0, |point| f64::from(point.field_ut));
        let unit = if candidate == Candidate::Drift { f64::from(DRIFT_UNIT_MS) * 1e-3 } else { 1.0 };
        let value = |axis: usize| f64::from(values.get(first + axis).copied().unwrap_or(0.0)) * field / unit;
        Some([value(0), value(1), value(2)])
    }

    /// What the columns of a candidate are held against, in the effect's own unit.
    fn held_against(&self, candidate: Candidate) -> f64 {
        match candidate {
            Candidate::Drift => self.first_ms as f64 * 1e-3,
            Candidate::Column(place) => {
                self.columns.get(usize::from(place)).map_or(0.0, |column| f64::from(column.first))
            }
            Candidate::Step | Candidate::Lag => 0.0,
        }
    }

    /// The effects of a calibration whose columns are studied.
    pub fn in_use(&self, effects: &Effects<f64>) -> InUse {
        let mut in_use = InUse::default();
        for fitted in effects.iter() {
            let Some(candidate) = self.candidate(&fitted.effect) else { continue };
            if let (Some(slot), [x, y, z, ..]) = (in_use.get_mut(candidate.place()), fitted.coefficients) {
                *slot = Some([x, y, z]);
            }
        }
        in_use
    }

    fn studied(&self, effects: &Effects<f64>) -> Found {
        effects
            .iter()
            .filter_map(|fitted| self.candidate(&fitted.effect))
            .filter(|candidate| match candidate {
                Candidate::Step => self.marks.pinned,
                Candidate::Lag => false,
                Candidate::Column(place) => {
                    self.columns.get(usize::from(*place)).is_some_and(|column| !column.is_constant())
                }
                Candidate::Drift => true,
            })
            .fold(Found::none(), Found::with)
    }

    /// The calibration with a further effect, base and effects estimated together from what was learned; what was learned stays, about
    /// the new calibration.
    ///
    /// # Errors
    /// [`NotShown`]; nothing changed then.
    pub fn add(
        &mut self,
        candidate: Candidate,
        calibration: &ExtendedCalibration<f64>,
    ) -> Result<ExtendedCalibration<f64>, NotShown> {
        if calibration.effects.len() >= MAX_EFFECTS {
            return Err(NotShown::Full);
        }
        if candidate == Candidate::Lag {
            self.add_lag(calibration)
        } else {
            self.add_shown(candidate, calibration)
        }
    }

    /// One that the magnitude shows.
    // Apart from a delay: the stack carries the sums of one of them at a time.
    #[inline(never)]
    fn add_shown(
        &mut self,
        candidate: Candidate,
        calibration: &ExtendedCalibration<f64>,
    ) -> Result<ExtendedCalibration<f64>, NotShown> {
        self.settle();
        let effect = self.effect(candidate).ok_or(NotShown::Undetermined)?;
        let studied = self.studied(&calibration.effects).with(candidate);
        let fresh = FittedEffect::new(effect, [0.0; 9], [f64::NAN; 9]).over(self.range(candidate));
        let mut list = calibration.effects;
        list.push(fresh).map_err(|_| NotShown::Full)?;
        let before = ExtendedCalibration { base: calibration.base, effects: list };
        let (total, chosen) = (self.total(), studied.chosen());
        let next =
            self.moved(&before, studied, &total, chosen, [0.0; WIDEST]).ok_or(NotShown::Undetermined)?;
        if candidate == Candidate::Step {
            self.marks.pinned = true;
        }
        Ok(next)
    }

    /// The calibration without an effect, the others and the base estimated anew from what was learned; where that does not
    /// determine them, they stay as they are.
    #[inline(never)]
    pub fn remove(
        &mut self,
        effect: &BuiltIn<f64>,
        calibration: &ExtendedCalibration<f64>,
    ) -> ExtendedCalibration<f64> {
        let candidate = self.candidate(effect);
        let mut without = Effects::none();
        let mut theta = [0.0; 3];
        for fitted in calibration.effects.iter() {
            if fitted.effect == *effect {
                let [x, y, z, ..] = fitted.coefficients;
                theta = [x, y, z];
            } else {
                // There were as many before.
                let _ = without.push(*fitted);
            }
        }
        let plain = ExtendedCalibration { base: calibration.base, effects: without };
        let studied = self.studied(&calibration.effects);
        let Some((candidate, first)) =
            candidate.filter(|one| studied.has(*one)).and_then(|one| Some((one, one.first_column()?)))
        else {
            // What was learned was learned with it taken off.
            self.begin(&plain.base);
            return plain;
        };
        let away = self.in_columns(candidate, theta, -1.0, first);
        let mut total = self.total();
        total.shift(&away);
        let others = studied.without(candidate);
        // Its columns are about their own zero, the effect was about its reference.
        let zero = calibration.effects.iter().find(|fitted| fitted.effect == *effect);
        let reference = zero.and_then(|fitted| fitted.effect.parts().reference()).unwrap_or(0.0);
        let shift = self.held_against(candidate) - reference;
        let mut base = plain;
        if candidate != Candidate::Step {
            base.base.offset_ut =
                core::array::from_fn(|axis| plain.base.offset_ut[axis] + theta[axis] * shift);
        }
        // After a restart a few samples say little: the base that the calibration has is better then.
        let next = tells(&total, others).then(|| self.moved(&base, others, &total, others.chosen(), away));
        match next.flatten() {
            Some(next) => {
                if candidate == Candidate::Step {
                    self.marks.pinned = false;
                }
                next
            }
            None => {
                self.begin(&plain.base);
                plain
            }
        }
    }

    /// Solves for the base and the effects that are studied, moves there, and gives the calibration of it.
    fn moved(
        &mut self,
        from: &ExtendedCalibration<f64>,
        studied: Found,
        total: &Work,
        chosen: Chosen,
        already: [f32; WIDEST],
    ) -> Option<ExtendedCalibration<f64>> {
        let point = self.point?;
        let factor = Factor::of(total, chosen, true)?;
        let mut delta = factor.step(total);
        if !delta.iter().all(|value| value.is_finite()) {
            return None;
        }
        let rows = self.rows();
        let freedom = (f64::from(rows) - chosen.len() as f64).max(1.0);
        let variance = f64::from(factor.squares(total)) / freedom;
        let time = self.memory.time(variance, f64::from(rows), chosen.len() as f64);
        let errors: [f32; WIDEST] = {
            let mut errors = [f32::NAN; WIDEST];
            for candidate in studied.iter() {
                let Some(first) = candidate.first_column() else { continue };
                for (column, slot) in errors.iter_mut().enumerate().skip(first).take(3) {
                    *slot = math::sqrt(variance * time * f64::from(factor.inverse(column))) as f32;
                }
            }
            errors
        };
        let rotation = Point::of(&from.base)?.1;
        let stepped = point.stepped(&delta).calibration(&rotation);
        let scale = from.base.field_ut / f64::from(point.field_ut);
        // In double precision, from what the record holds: a single would round what did not move. The point may have.
        let field = f64::from(point.field_ut);
        let mut offset_ut: [f64; 3] = core::array::from_fn(|axis| {
            let away = point.offset_ut[axis] - from.base.offset_ut[axis] as f32;
            from.base.offset_ut[axis] + f64::from(away) + field * f64::from(delta[axis])
        });
        let mut effects = Effects::none();
        for fitted in from.effects.iter() {
            let mut fitted = *fitted;
            if let Some(candidate) = self.candidate(&fitted.effect).filter(|one| studied.has(*one))
                && let (Some(more), Some(error)) =
                    (self.coefficients(candidate, &delta), self.coefficients(candidate, &errors))
            {
                let reference = fitted.effect.parts().reference();
                let shift = reference.map_or(0.0, |reference| reference - self.held_against(candidate));
                for axis in 0..3 {
                    fitted.coefficients[axis] += more[axis];
                    // As a record keeps it, so that a restart changes no digit.
                    fitted.std_errors[axis] = f64::from(error[axis] as f32);
                    offset_ut[axis] += more[axis] * shift;
                }
                fitted.ranges = self.range(candidate);
            }
            effects.push(fitted).ok()?;
        }
        let base = Calibration {
            offset_ut,
            matrix: stepped.matrix.map(|row| row.map(|value| value * scale)),
            field_ut: from.base.field_ut,
        };
        if !base.is_sound() {
            return None;
        }
        for ((slot, more), away) in delta.iter_mut().zip(already).zip(self.away()) {
            *slot += more + away;
        }
        let (point, _) = Point::of(&base)?;
        self.shift(&delta, point);
        // The effects in use are taken off before a sample comes here, and of the others none is at this point.
        self.carried = Default::default();
        Some(ExtendedCalibration { base, effects })
    }

    /// The sensor's delay; with it the matrix is turned into the accelerometer's and the gyro's axes, in which alone it means something.
    #[inline(never)]
    fn add_lag(&mut self, from: &ExtendedCalibration<f64>) -> Result<ExtendedCalibration<f64>, NotShown> {
        let (_, before) = Point::of(&from.base).ok_or(NotShown::Undetermined)?;
        let lateness = Lateness::of(&self.late).ok_or(NotShown::Undetermined)?;
        let mut coefficients = [0.0; 9];
        let mut std_errors = [f64::NAN; 9];
        (coefficients[0], std_errors[0]) = (f64::from(lateness.delay_s), f64::from(lateness.error_s));
        self.late.shift(&lateness.step);
        let rotation: [[f64; 3]; 3] = self.late.rotation.map(|row| row.map(f64::from));
        // What single precision has left of a rotation is made one again.
        let rotation = orthonormal(&rotation).ok_or(NotShown::Undetermined)?;
        let matrix = product(&rotation, &product(&transposed(&before), &from.base.matrix));
        let mut effects = from.effects;
        let lag = self.effect(Candidate::Lag).ok_or(NotShown::Undetermined)?;
        effects.push(FittedEffect::new(lag, coefficients, std_errors)).map_err(|_| NotShown::Full)?;
        Ok(ExtendedCalibration { base: Calibration { matrix, ..from.base }, effects })
    }

    /// Over which values of its columns a candidate was learned.
    fn range(&self, candidate: Candidate) -> Ranges<f64> {
        match candidate {
            Candidate::Drift => {
                [Some([self.first_ms, self.last_ms].map(|ms| f64::from(ms as f32 * 1e-3))), None]
            }
            Candidate::Column(place) => {
                [self.columns.get(usize::from(place)).map(|column| column.range().map(f64::from)), None]
            }
            // What was attached stays attached.
            Candidate::Step | Candidate::Lag => [None, None],
        }
    }
}

/// Whether sums tell the base beside some effects as well as a calibration that is accepted.
#[inline(never)]
fn tells(total: &Work, others: Found) -> bool {
    Factor::of(total, others.chosen(), true)
        .is_some_and(|factor| factor.largest_error(total) <= MAX_PREDICTED_ERROR as f32)
}

fn transposed(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| m[j][i]))
}

/// The rows made orthogonal, one after the other.
fn orthonormal(rotation: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let [x, y, _] = *rotation;
    let unit = |v: [f64; 3]| Some(scaled(v, 1.0 / Some(norm(v)).filter(|size| *size > 0.5)?));
    let x = unit(x)?;
    let y = unit(minus(y, scaled(x, dot(x, y))))?;
    Some([x, y, cross(x, y)])
}

/// The id of an effect as the console writes it.
pub fn has_id(effect: &BuiltIn<f64>, id: &str) -> bool {
    struct Compare<'a>(&'a str, bool);
    impl fmt::Write for Compare<'_> {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            match self.0.strip_prefix(text) {
                Some(rest) => self.0 = rest,
                None => self.1 = false,
            }
            Ok(())
        }
    }
    let mut compare = Compare(id, true);
    Effect::<f64>::id(effect, &mut compare).is_ok() && compare.1 && compare.0.is_empty()
}
